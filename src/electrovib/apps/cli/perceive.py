"""``electrovib perceive``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.options import Changes, Everything, Models
from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("perceive")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file, a paper's scenario such as vardar_2017/square, or a Trace.")
    ] = "vezzoli_2014/fig6",
    changes: Changes = None,
    everything: Everything = False,
    models: Models = None,
) -> None:
    """Report whether a finger feels the drive.

    State also by which tactile channel, and by how many decibels.
    """
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.chosen import chosen
    from electrovib.apps.progress import tracked
    from electrovib.scenario import paper_of_preset, read_scenario
    from electrovib.study.perceive import perceive
    from electrovib.view.percept import percept_lines

    wanted = read_changes(changes or [])
    with tracked("perceiving"):
        found = perceive(scenario, set=wanted)
    lines = percept_lines(found, everything=everything, more="--all lists assumptions")
    if paper_of_preset(scenario):
        drawn = {path: value for path, value in wanted.items() if path.partition(".")[0] != "perception"}
        lines += chosen(read_scenario(scenario, changes=drawn), scenario)
    say(*lines)
