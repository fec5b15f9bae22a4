"""``electrovib check``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import typer

from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import say, show, warned

if TYPE_CHECKING:
    from electrovib.studies.check import CheckResult

EXAMPLE: Final = "electrovib check vezzoli_2014/fig6 --set limits.voltage='1 kV'"


@takes("""
first SCENARIO|DRIVE  The scenario; or, before a scenario, a file with the columns time and voltage.
[second] SCENARIO     The scenario in which that drive is checked.
--limits
--series-resistor     Compute the smallest resistor that holds the body current if the insulator fails.
-o, --output FILE     Write the result: .csv, .json or .html.
--all
--set
--models
--force
""")
def command(given: Arguments) -> None:
    """Compare voltage, current and breakdown with limits.

    Charge, energy and breakdown of each layer are compared too; exit code 1 if a limit is exceeded.
    """
    from electrovib.apps.exit_codes import FAILED
    from electrovib.core.answer import laid_out
    from electrovib.studies.check import CheckResult, check
    from electrovib.studies.check.series import series_resistor

    given.read_set()
    drive, scenario = given.pop("first"), given.pop("second", "")
    if not scenario:
        drive, scenario = None, drive
    resistor = None
    if given.pop("series_resistor", False):
        resistor = series_resistor(scenario, limits=given.get("limits"), set=given["set"])

    def told(found: CheckResult, *, everything: bool) -> None:
        """Print the verdict in a few lines, after the tables that were asked for."""
        from electrovib.studies.check.result import HARDWARE

        for table in found.tables if everything else ():
            show(laid_out(table))
        if everything:
            say(*found.notes, "")
        if resistor is not None:
            show(laid_out(resistor.document.tables[0]))
        more = "" if everything else " (--all lists every limit, its source, and published currents)"
        say(*found.sentences, *warned(found), f"{HARDWARE}{more}")

    given |= {"drive": drive, "scenario": scenario}
    if answered(CheckResult, check, "checking", given, told).failed:
        raise typer.Exit(FAILED)
