"""``electrovib perceive``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from electrovib.study.percept import Percept


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("perceive")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file, a paper's scenario such as vardar_2017/square, or a Trace.")
    ] = "vezzoli_2014/fig6",
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PATH=VALUE",
            help="Change a parameter, of the scenario or perception.*; repeatable.",
        ),
    ] = None,
) -> None:
    """Tell whether a finger feels the drive, by which channel, and by how many decibels."""
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.chosen import chosen
    from electrovib.apps.progress import tracked
    from electrovib.scenario import paper_of_preset, read_scenario
    from electrovib.study.perceive import perceive

    wanted = read_changes(changes or [])
    with tracked("perceiving"):
        found = perceive(scenario, set=wanted)
    lines = summary(found)
    if paper_of_preset(scenario):
        drawn = {path: value for path, value in wanted.items() if path.partition(".")[0] != "perception"}
        lines += chosen(read_scenario(scenario, changes=drawn), scenario)
    say(*lines)


def summary(found: Percept) -> list[str]:
    """Say in a few lines what is felt, and what that stands on."""
    lines = [found.title] if found.title else []
    lines.append(f"looked at: {found.spectrum.signal.replace('_', ' ')}, {found.spectrum.how}")
    if not found.loudest:
        return [*lines, "nothing moves the skin: not felt", *_stands_on(found)]
    reference = f"a sine of force as large at {found.best_frequency:g} Hz"
    for felt in found.channels:
        level = f"{_decibels(felt.level)} re 1 {found.unit}" if math.isfinite(felt.level) else "nothing"
        relative = (
            f", {_decibels(felt.relative)} relative to {reference}" if math.isfinite(felt.relative) else ""
        )
        lines.append(f"{felt.channel}: {level}{relative} ({felt.status})")
    low, high = found.interval
    word = "strongest in" if found.sensation is None else "felt by"
    level = f"{_decibels(found.relative)}; between {low:+.1f} and {high:+.1f} dB:"
    lines.append(f"{word}: {found.loudest}, {level}")
    lines += [f"  {_decibels(value)} with {name}" for name, value in found.alternatives.items()]
    if found.sensation is None:
        lines.append("verdict: relative only, calibrate with perception.threshold and perception.compliance")
    else:
        lines.append(
            f"verdict: {found.verdict}, {_decibels(found.sensation)} above threshold,"
            f" uncertainty {found.uncertainty:g} dB"
        )
    if math.isfinite(found.numerical_error):
        lines.append(f"numerical error: {abs(found.numerical_error):.1g} dB")
    return lines + _stands_on(found)


def _stands_on(found: Percept) -> list[str]:
    return ["stands on:", *(f"  {text}" for text in found.calibrated_on)]


def _decibels(value: float) -> str:
    return f"{value:+.1f} dB"
