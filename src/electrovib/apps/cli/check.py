"""``electrovib check``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.terminal import say, show, warned

if TYPE_CHECKING:
    from electrovib.studies.check import CheckResult
    from electrovib.studies.check.series import SeriesResistor

EXAMPLE: Final = "electrovib check vezzoli_2014/fig6 --set limits.voltage='1 kV'"


def command(
    first: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO|DRIVE",
            help="The scenario; or, before a scenario, a file with the columns time and voltage.",
        ),
    ],
    second: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="The scenario in which that drive is checked.")
    ] = "",
    limits: options.Limits = None,
    series_resistor: Annotated[
        bool,
        typer.Option(
            "--series-resistor",
            help="Compute the smallest resistor that holds the body current if the insulator fails.",
        ),
    ] = False,
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="Write the result: .csv, .json or .html.")
    ] = None,
    everything: options.Everything = False,
    changes: options.Changes = None,
    models: options.Models = None,
    force: options.Force = False,
) -> None:
    """Compare voltage, current and breakdown with limits.

    Charge, energy and breakdown of each layer are compared too; exit code 1 if a limit is exceeded.
    """
    from electrovib.apps.changes import read_changes
    from electrovib.apps.exit_codes import FAILED
    from electrovib.studies.check import CheckResult, check
    from electrovib.studies.check.series import series_resistor as resistor_of

    drive, scenario = (first, second) if second else (None, first)
    asked: dict[str, Any] = {"limits": list(limits or []), "set": read_changes(changes or [])}
    resistor = resistor_of(scenario, **asked) if series_resistor else None
    result = answered(
        CheckResult,
        check,
        words="checking",
        output=output,
        force=force,
        show=lambda found: _show(found, resistor, everything=everything),
        drive=drive,
        scenario=scenario,
        **asked,
    )
    if result.failed:
        raise typer.Exit(FAILED)


def _show(result: CheckResult, resistor: SeriesResistor | None, *, everything: bool) -> None:
    """Print the verdict in a few lines, after the tables that were asked for."""
    from electrovib.core.answer import laid_out
    from electrovib.studies.check.result import HARDWARE

    for table in result.tables if everything else ():
        show(laid_out(table))
    if everything:
        say(*result.notes, "")
    if resistor is not None:
        show(laid_out(resistor.document.tables[0]))
    more = "" if everything else " (--all lists every limit, its source, and published currents)"
    say(*result.sentences, *warned(result), f"{HARDWARE}{more}")
