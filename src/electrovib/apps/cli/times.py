"""``electrovib times``: times of edges, or friction of swipes, in a record and without a model of the experiment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from electrovib.apps.cli.options import Force, Text, only, option, output
from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from electrovib.recordings.transitions import MeasuredRings, MeasuredTimes

Record: TypeAlias = Annotated[
    str,
    typer.Argument(
        help="Trace file with signals over time, as electrovib import writes it; with --recipe a file of an instrument."
    ),
]
Quantity: TypeAlias = Annotated[
    Text,
    option("Signal whose edges are measured; by default the only one besides --by.", metavar="SIGNAL"),
]
Levels: TypeAlias = Annotated[
    str, typer.Option(metavar="LOW:HIGH", help="Levels in per cent of the range of an edge.")
]
By: TypeAlias = Annotated[
    Text, option("Signal of the drive, whose switching marks the edges.", metavar="SIGNAL")
]
Antiphase: TypeAlias = Annotated[
    bool,
    typer.Option("--antiphase", help="The signal of --by is one of two electrodes driven in antiphase."),
]
Sensor: TypeAlias = Annotated[
    Text,
    option(
        "Sensor that is taken out: natural frequency and quality factor, such as 380Hz:3, or estimated from the edges.",
        metavar="HZ:Q|estimate",
    ),
]
Edges: TypeAlias = Annotated[
    str, typer.Option(metavar="both|rising|falling", help="Edges that are measured.")
]
Exponentials: TypeAlias = Annotated[int, typer.Option(help="Largest number of exponentials, 1 to 4.")]
Window: TypeAlias = Annotated[
    Text, option("Length of the section after an edge, such as '20 ms'.", metavar="TIME")
]
Before: TypeAlias = Annotated[Text, option("Length of the section before an edge.", metavar="TIME")]
Ring: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--ring",
        help="Measure also the oscillation after each impact, or after the last switching of --by.",
    ),
]
Swipes: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--swipes",
        help="Find swipes in a record of a normal and a lateral force instead, and reduce them to friction and forces.",
    ),
]
Recipe: TypeAlias = Annotated[
    Text,
    option(
        "Of --swipes: columns of the file of an instrument, with sensitivities, clock and encoder.",
        metavar="FILE.toml",
    ),
]
Speed: TypeAlias = Annotated[
    Text,
    option(
        "Of --swipes: set sliding speed, such as '40 mm/s', where no motion is recorded.", metavar="SPEED"
    ),
]
Trim: TypeAlias = Annotated[
    float,
    typer.Option(
        metavar="PER_CENT", help="Of --swipes: part of the distance omitted at both ends of a slide."
    ),
]
Folder: TypeAlias = Annotated[
    Text, output("Folder for report.html and times.csv, or swipes.csv.", metavar="DIR")
]


def command(
    context: typer.Context,
    record: Record,
    quantity: Quantity = None,
    levels: Levels = "10:90",
    by: By = None,
    antiphase: Antiphase = False,
    sensor: Sensor = None,
    edges: Edges = "both",
    exponentials: Exponentials = 3,
    window: Window = None,
    before: Before = None,
    ring: Ring = False,
    swipes: Swipes = False,
    recipe: Recipe = None,
    speed: Speed = None,
    trim: Trim = 5.0,
    folder: Folder = None,
    force: Force = False,
) -> None:
    """Measure rise and fall times, or swipes, in a record.

    Report the times with and without the sensor, each with a 95 % interval; with --swipes the friction and the forces of
    contacts and slides, from which the zeros of the sensors are subtracted.
    """
    target = None if folder is None else Path(folder)
    if swipes or recipe:
        only(context, "record swipes recipe speed trim folder", "--swipes")
        _reduce_swipes(record, target, recipe=recipe, speed=speed, trim=trim, force=force)
        return
    only(
        context, "record quantity levels by antiphase sensor edges exponentials window before ring folder",
        "times, but to --swipes",
    )  # fmt: skip
    chosen = _chosen(quantity, by, antiphase=antiphase)
    options = {"levels": _levels(levels), "sensor": sensor, "exponentials": exponentials, "edges": edges}
    spans = {"window": _seconds("--window", window), "before": _seconds("--before", before)}
    _measure(record, target, chosen, options | spans, ring=ring, force=force)


def _measure(
    record: str,
    folder: Path | None,
    chosen: dict[str, Any],
    options: dict[str, Any],
    *,
    ring: bool,
    force: bool,
) -> None:
    """Measure the times of the edges, and the oscillations where they are asked for."""
    from electrovib.core.files import inputs_noted
    from electrovib.data.traces import open_trace
    from electrovib.view.documents import check_answer, save_answer
    from electrovib.view.times import TimesAnswer, rows_of

    with inputs_noted() as inputs:
        trace = open_trace(record)
    if folder is not None:
        check_answer(TimesAnswer, folder, inputs=inputs, force=force)
    rings = _rings(trace, chosen, options["window"]) if ring else None
    found, why = _times(trace, rings, **chosen, **options)
    say(*(f"{row.group}, {row.sentence}" for row in rows_of(found, rings)))
    say(*(text for each in (found, rings) if each is not None for text in each.words), *why)
    if folder is not None:
        answer = TimesAnswer(found=found, rings=rings, source=Path(record).name)
        say(*(f"written: {path}" for path in save_answer(answer, folder, force=force)))


def _reduce_swipes(
    record: str, folder: Path | None, *, recipe: str | None, speed: str | None, trim: float, force: bool
) -> None:
    """Find contacts and slides, and report their friction and forces."""
    from electrovib.core.files import inputs_noted
    from electrovib.recordings.swipe import reduce_swipes
    from electrovib.recordings.swipe.reduce import swipe_rows
    from electrovib.view.documents import check_answer, save_answer
    from electrovib.view.swipe import SwipesAnswer

    with inputs_noted() as inputs:
        found = reduce_swipes(record, channels=recipe, speed=speed, trim=trim / 100)
    if folder is not None:
        check_answer(SwipesAnswer, folder, inputs=inputs, force=force)
    say(*(f"{row.group}, {row.sentence}" for row in swipe_rows(found)))
    for number, each in enumerate(found, start=1):
        name = f"swipe {number}: " if len(found) > 1 else ""
        say(*(f"{name}{text}" for text in each.words))
    if folder is not None:
        answer = SwipesAnswer(swipes=found, source=Path(record).name)
        say(*(f"written: {path}" for path in save_answer(answer, folder, force=force)))


def _rings(trace: Any, chosen: dict[str, Any], window: float | None) -> MeasuredRings:
    from electrovib.recordings.transitions import MeasuredRings, measure_ring, measure_rings

    if chosen["by"] is None:
        return measure_rings(trace, signal=chosen["signal"], window=window)
    return MeasuredRings(rings=(measure_ring(trace, **chosen, window=window),))


def _times(trace: Any, rings: MeasuredRings | None, **options: Any) -> tuple[MeasuredTimes | None, list[str]]:
    """Measure the times; a record that rings needs no edges, and why there are none is stated."""
    from electrovib.core.errors import InputError
    from electrovib.recordings.transitions import measure_times

    try:
        return measure_times(trace, **options), []
    except InputError as error:
        if rings is None:
            raise
        return None, [f"No time between levels: {error.problems[0]}."]


def _chosen(signal: str | None, by: str | None, *, antiphase: bool) -> dict[str, Any]:
    from electrovib.physics.drive.readback import OneOfTwoInAntiphase

    return {"signal": signal, "by": by, "readback": OneOfTwoInAntiphase() if antiphase else None}


def _seconds(option: str, text: str | None) -> float | None:
    from electrovib.recordings.importing.reduction import seconds

    return None if text is None else seconds(option, text)


def _levels(text: str) -> tuple[float, float]:
    from electrovib.core.errors import InputError

    try:
        low, high = (float(part.strip().removesuffix("%")) / 100 for part in text.split(":"))
    except ValueError:
        raise InputError(f"--levels {text}: expected two levels in per cent, such as 10:90") from None
    return low, high
