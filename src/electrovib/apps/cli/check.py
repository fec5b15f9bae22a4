"""``electrovib check``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import say, show

if TYPE_CHECKING:
    from electrovib.study.check import CheckResult, CheckRow
    from electrovib.study.check.series import SeriesResistor
    from electrovib.study.reproduction import Table


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("check")(command)


def command(
    first: Annotated[
        str,
        typer.Argument(
            metavar="[DRIVE] SCENARIO",
            help="A file with the columns time and voltage, if another drive is to be checked, and the scenario.",
        ),
    ],
    second: Annotated[str, typer.Argument(metavar="", hidden=True)] = "",
    limits: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE.toml",
            help="Further limits beside those of the scenario; the strictest counts. Repeatable.",
        ),
    ] = None,
    series_resistor: Annotated[
        bool,
        typer.Option(
            "--series-resistor",
            help="Compute the smallest resistor that holds the body current if the insulator fails.",
        ),
    ] = False,
    output: Annotated[
        str | None, typer.Option("--output", "-o", help="Write the result: .csv or .json.")
    ] = None,
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Compare voltage, current, charge, energy and breakdown of a drive with limits; exit code 1 if one is exceeded."""
    del models  # imported by now
    from electrovib.apps.changes import read_changes
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.exit_codes import FAILED
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.export.check import check_check_output, write_check
    from electrovib.study.check import check
    from electrovib.study.check.series import series_resistor as resistor_of

    drive, scenario = (first, second) if second else (None, first)
    wanted, declared = read_changes(changes or []), list(limits or [])
    with inputs_noted() as inputs:
        if output:
            check_check_output(output, inputs=[], force=force)
        with tracked("checking"):
            result = check(drive, scenario, limits=declared, set=wanted)
        if output:
            check_check_output(output, inputs=inputs, force=force)
    for table in tables_of(result):
        show(as_text(table))
    if series_resistor:
        show(as_text(resistor_table(resistor_of(scenario, limits=declared, set=wanted))))
    say(*result.notes, "", verdict(result))
    if output:
        say(f"written: {write_check(result, output, force=force)}")
    if result.failed:
        raise typer.Exit(FAILED)


def tables_of(result: CheckResult) -> list[Table]:
    """Lay a result out as tables of words."""
    from electrovib.study.check.result import shown
    from electrovib.study.reproduction import Table

    def row(each: CheckRow, words: dict[str, str]) -> tuple[str, ...]:
        margin = "" if each.margin is None else f"{each.margin:.3g}"
        state = words.get(each.state, each.state)
        return (
            state,
            each.quantity,
            shown(each.value, each.unit),
            "" if each.limit is None else shown(each.limit, each.unit),
            margin,
            each.source,
        )

    headings = ("quantity", "largest", "limit", "limit/value", "source of the limit")
    compared = {"pass": "below", "fail": "above"}
    numbers = tuple((each.quantity, shown(each.value, each.unit)) for each in result.numbers)
    return [
        Table(result.title, ("state", *headings), tuple(row(each, {}) for each in result.rows)),
        Table(
            "Comparison with published currents, which decides nothing",
            ("state", *headings),
            tuple(row(each, compared) for each in result.comparisons),
        ),
        Table("Values without a limit", ("quantity", "value"), numbers),
    ]


def resistor_table(found: SeriesResistor) -> Table:
    """Lay the series resistor out as a table of words."""
    from electrovib.study.check.result import shown
    from electrovib.study.reproduction import Table

    rows = [(name, shown(value, unit), "") for name, value, unit in found.items()]
    rows[0] = (*rows[0][:2], found.voltage_source)
    rows[1] = (*rows[1][:2], found.current_source)
    caption = (
        "The insulator counts as a short circuit and the body as no resistance. The charge behind the resistor flows through"
        " the finger without passing it; the resistor has to withstand the largest voltage and the power permanently."
    )
    return Table(
        "Series resistor between amplifier and plate",
        ("quantity", "value", "source"),
        tuple(rows),
        caption=caption,
    )


def verdict(result: CheckResult) -> str:
    """Return one sentence with the outcome."""
    if result.failed:
        return f"failed: {len(result.failed)} of {len(result.rows)} limits exceeded: " + ", ".join(
            row.quantity for row in result.failed
        )
    unknown = sum(row.state == "unknown" for row in result.rows)
    rest = f", {unknown} not judged" if unknown else ""
    return f"no limit exceeded{rest}"
