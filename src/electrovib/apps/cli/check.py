"""``electrovib check``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import say, show

if TYPE_CHECKING:
    from electrovib.study.check import CheckResult
    from electrovib.study.check.series import SeriesResistor

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
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.study.check import check
    from electrovib.study.check.series import series_resistor as resistor_of
    from electrovib.view.checked import check_outcome_file, write_check

    drive, scenario = (first, second) if second else (None, first)
    wanted, declared = read_changes(changes or []), list(limits or [])
    with inputs_noted() as inputs:
        if output:
            check_outcome_file(output, inputs=[], force=force)
        with tracked("checking"):
            result = check(drive, scenario, limits=declared, set=wanted)
        if output:
            check_outcome_file(output, inputs=inputs, force=force)
    resistor = resistor_of(scenario, limits=declared, set=wanted) if series_resistor else None
    _show_verdict(result, resistor, everything=everything)
    if output:
        say(f"written: {write_check(result, output, force=force)}")
    if result.failed:
        raise typer.Exit(FAILED)


def _show_verdict(result: CheckResult, resistor: SeriesResistor | None, *, everything: bool) -> None:
    """Print the verdict in a few lines, after the tables that were asked for."""
    from electrovib.study.catalogue.columns import laid_out
    from electrovib.view.checked import check_lines, resistor_table, tables_of

    if everything:
        for table in tables_of(result):
            show(laid_out(table))
        say(*result.notes, "")
    if resistor is not None:
        show(laid_out(resistor_table(resistor)))
    more = "" if everything else "(--all lists every limit, its source, and published currents)"
    say(*check_lines(result, more=more))
