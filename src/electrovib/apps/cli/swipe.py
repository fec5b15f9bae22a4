"""``electrovib swipe``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.terminal import say


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("swipe")(command)


def command(
    record: Annotated[
        str,
        typer.Argument(
            help="Trace file with a normal and a lateral force, as electrovib import writes it; with --channels a file of an"
            " instrument."
        ),
    ],
    channels: Annotated[
        str | None,
        typer.Option(metavar="FILE.toml", help="Columns of the file, with sensitivities, clock and encoder."),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            metavar="SPEED", help="Set sliding speed, such as '40 mm/s', where no motion is recorded."
        ),
    ] = None,
    trim: Annotated[
        float, typer.Option(metavar="PER_CENT", help="Part of the distance omitted at both ends of a slide.")
    ] = 5.0,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="DIR", help="Folder for report.html and swipes.csv."),
    ] = None,
    force: Force = False,
) -> None:
    """Reduce recorded swipes to friction and forces.

    Find contacts and slides in the record, and subtract the zeros of the sensors.
    """
    from electrovib.core.files import inputs_noted
    from electrovib.data.atomic import check_folder, write_folder
    from electrovib.recordings.swipe import reduce_swipes
    from electrovib.recordings.swipe.reduce import swipe_rows
    from electrovib.view.swipe import FILES, swipe_files

    folder = None if output is None else Path(output)
    with inputs_noted() as inputs:
        found = reduce_swipes(record, channels=channels, speed=speed, trim=trim / 100)
    if folder is not None:
        check_folder(folder, FILES, inputs=inputs, force=force)
    say(*(f"{row.group}, {row.sentence}" for row in swipe_rows(found)))
    for number, each in enumerate(found, start=1):
        name = f"swipe {number}: " if len(found) > 1 else ""
        say(*(f"{name}{text}" for text in each.words))
    if folder is not None:
        texts = swipe_files(found, source=Path(record).name)
        say(*(f"written: {path}" for path in write_folder(folder, texts, FILES, force=force)))
