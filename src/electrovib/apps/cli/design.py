"""``electrovib design``."""

from __future__ import annotations

from typing import Annotated, Any, Final

import typer

from electrovib.apps.cli.completion import scenario_names
from electrovib.apps.cli.design_options import (
    Band,
    Between,
    Carrier,
    Draws,
    Free,
    Limits,
    LinearOnly,
    Method,
    Rate,
    Seed,
    Share,
    SpaceOf,
    Target,
    Want,
)
from electrovib.apps.cli.export_options import AmplifierPresent, Edge
from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Everything, Models
from electrovib.apps.cli.terminal import say

EXAMPLE: Final = (
    "electrovib design vezzoli_2014/fig6 --want 'peak electrostatic_force = 1 mN' --free drive.high"
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("design")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file or a paper's scenario.", autocompletion=scenario_names)
    ],
    want: Want = None,
    free: Free = None,
    between: Between = None,
    target: Target = None,
    method: Method = None,
    carrier: Carrier = None,
    rate: Rate = None,
    limits: Limits = None,
    space: SpaceOf = None,
    n: Draws = None,
    seed: Seed = None,
    linear: LinearOnly = False,
    share: Share = None,
    band: Band = None,
    output: Annotated[
        str | None,
        typer.Option(
            "--output",
            "-o",
            help="Write the scenario with the result (.toml), all numbers (.json), or the drive as a waveform (.csv, .npy, ...).",
        ),
    ] = None,
    edge: Edge = "",
    amplifier_present: AmplifierPresent = False,
    everything: Everything = False,
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Find the parameter or drive that gives a wanted force.

    Any quantity of a sweep can be wanted; exit code 1 if none gives it within the limits.
    """
    del models  # imported by now
    from electrovib.apps.cli.export import edge_of

    given = {
        "want": want, "free": free, "between": between, "space": space, "n": n, "seed": seed, "linear": linear or None,
        "target": target, "method": method, "carrier": carrier, "rate": rate,
        "share": share, "band": band, "limits": limits or None,
    }  # fmt: skip
    played = {"edge": edge_of(edge), "amplifier_present": amplifier_present}
    _design(
        scenario,
        given,
        changes=changes or [],
        output=output,
        played=played,
        force=force,
        everything=everything,
    )


def _design(
    scenario: str,
    given: dict[str, Any],
    *,
    changes: list[str],
    output: str | None,
    played: dict[str, Any],
    force: bool,
    everything: bool,
) -> None:
    """Print the result of a design, and write it."""
    from electrovib.apps.changes import read_changes
    from electrovib.apps.exit_codes import FAILED
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.export.design import check_design_file, write_design
    from electrovib.study.design import design

    wanted = read_changes(changes)
    with inputs_noted() as inputs:
        if output:
            check_design_file(output, edge=played["edge"], force=force)
        with tracked("solving") as progress:
            found = design(scenario, **given, set=wanted, progress=progress)
        if output:
            check_design_file(output, edge=played["edge"], inputs=inputs, force=force)
    say(*(found.lines if everything else found.verdict))
    if not everything and (left := len(found.lines) - len(found.verdict)):
        say(f"--all prints {left} more lines: what it depends on and how it was computed.")
    if output:
        say(*write_design(found, output, force=force, **played))
    if not found.is_achieved:
        raise typer.Exit(FAILED)
