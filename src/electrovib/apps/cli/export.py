"""``electrovib export``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("export")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace.")
    ],
    output: Annotated[str, typer.Argument(help="The netlist to write: .cir.")],
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Write a scenario as a netlist: drive, layers, body and force, for ngspice."""
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.progress import tracked
    from electrovib.export.scenario import export

    with tracked("solving and writing"):
        written = export(scenario, output, set=read_changes(changes or []), force=force)
    say(f"written: {written}")
    say(f"run it:  ngspice -b {written}")
