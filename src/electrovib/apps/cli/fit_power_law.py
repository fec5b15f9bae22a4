"""``electrovib fit-power-law``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.import_options import DecimalComma, Delimiter, ReaderName
from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from electrovib.recordings.fit.power_law import PowerLawFit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fit-power-law")(command)


def command(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...", help="Tables of measured points; each is a session without --session."
        ),
    ],
    x: Annotated[str, typer.Option("--x", metavar="COLUMN", help='Such as "voltage (V)".')],
    y: Annotated[str, typer.Option("--y", metavar="COLUMN", help='Such as "force (mN)".')],
    session: Annotated[
        str, typer.Option(metavar="COLUMN", help="Column with the number of the session of each point.")
    ] = "",
    reader: ReaderName = "",
    delimiter: Delimiter = None,
    decimal_comma: DecimalComma = None,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE.csv", help="Write the table of the sessions."),
    ] = None,
    force: Force = False,
) -> None:
    """Fit a power law, such as that of force over voltage.

    Report the scatter of its exponent between sessions.
    """
    from pathlib import Path

    from electrovib.core.errors import InputError
    from electrovib.data.atomic import check_writable, write_text
    from electrovib.data.marks import Form
    from electrovib.recordings.fit.power_law import fit_power_law, power_law_csv, read_points

    target = None if output is None else Path(output)
    if target is not None:
        if target.suffix.lower() != ".csv":
            raise InputError(f"the table is written as .csv, not as '{target.suffix}'", path=target)
        check_writable({target: Form.TABLE}, inputs=[Path(each) for each in files], force=force)
    along, values, sessions = read_points(
        files, x=x, y=y, session=session, reader=reader, delimiter=delimiter, decimal_comma=decimal_comma
    )
    law = fit_power_law(along, values, session=sessions)
    say(*summary(law))
    if target is not None:
        write_text(target, power_law_csv(law), Form.TABLE, force=force)
        say(f"written: {target}")


def summary(law: PowerLawFit) -> list[str]:
    """Report the exponent with its interval, and that of each session."""
    return [
        f"exponent {law.exponent:.4g}, 95 % interval {law.lower:.4g} to {law.upper:.4g}",
        *(
            f"  {name}: exponent {each.exponent:.4g}, standard error {each.standard_error:.2g}"
            f" (ln y scatters by {each.scatter:.2g}), y at x = 1 in SI {each.factor:.4g}"
            for name, each in law.sessions.items()
        ),
        law.sentence,
    ]
