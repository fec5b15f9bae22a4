"""``electrovib times``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.terminal import say

if TYPE_CHECKING:
    from electrovib.recordings.transitions import MeasuredRings, MeasuredTimes

Record: TypeAlias = Annotated[
    str, typer.Argument(help="Trace file with signals over time, as electrovib import writes it.")
]
Measured: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="SIGNAL", help="Signal whose edges are measured; by default the only one besides --by."
    ),
]
Fractions: TypeAlias = Annotated[
    str, typer.Option(metavar="LOW:HIGH", help="Levels in per cent of the range of an edge.")
]
By: TypeAlias = Annotated[
    str | None, typer.Option(metavar="SIGNAL", help="Signal of the drive, whose switching marks the edges.")
]
Antiphase: TypeAlias = Annotated[
    bool,
    typer.Option("--antiphase", help="The signal of --by is one of two electrodes driven in antiphase."),
]
TakenOut: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="HZ:Q|estimate",
        help="Sensor that is taken out: natural frequency and quality factor, such as 380Hz:3, or estimated from the edges.",
    ),
]
Edges: TypeAlias = Annotated[
    str, typer.Option(metavar="both|rising|falling", help="Edges that are measured.")
]
Exponentials: TypeAlias = Annotated[int, typer.Option(help="Largest number of exponentials, 1 to 4.")]
Window: TypeAlias = Annotated[
    str | None, typer.Option(metavar="TIME", help="Length of the section after an edge, such as '20 ms'.")
]
Before: TypeAlias = Annotated[
    str | None, typer.Option(metavar="TIME", help="Length of the section before an edge.")
]
Ring: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--ring", help="Measure also the oscillation after each impact, or after the last switching of --by."
    ),
]
Folder: TypeAlias = Annotated[
    str | None, typer.Option("--output", "-o", metavar="DIR", help="Folder for report.html and times.csv.")
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("times")(command)


def command(
    record: Record,
    signal: Measured = None,
    levels: Fractions = "10:90",
    by: By = None,
    antiphase: Antiphase = False,
    sensor: TakenOut = None,
    edges: Edges = "both",
    exponentials: Exponentials = 3,
    window: Window = None,
    before: Before = None,
    ring: Ring = False,
    output: Folder = None,
    force: Force = False,
) -> None:
    """Measure rise and fall times of recorded edges.

    Report them with and without the sensor, each with a 95 % interval.
    """
    from pathlib import Path

    from electrovib.core.files import inputs_noted
    from electrovib.data.atomic import check_folder, write_folder
    from electrovib.data.traces import open_trace
    from electrovib.recordings.transitions.table import time_rows
    from electrovib.view.times import FILES, times_files

    chosen = _chosen(signal, by, antiphase=antiphase)
    spans: dict[str, Any] = {"window": _seconds("--window", window), "before": _seconds("--before", before)}
    fractions = _levels(levels)
    with inputs_noted() as inputs:
        trace = open_trace(record)
    if output is not None:
        check_folder(Path(output), FILES, inputs=inputs, force=force)
    wanted: Any = edges  # checked there
    rings = _rings(trace, chosen, spans["window"]) if ring else None
    found, why = _times(
        trace,
        rings,
        levels=fractions,
        sensor=sensor,
        exponentials=exponentials,
        edges=wanted,
        **chosen,
        **spans,
    )
    say(*(f"{row.group}, {row.sentence}" for row in time_rows(found, rings)))
    say(*(text for each in (found, rings) if each is not None for text in each.words), *why)
    if output is not None:
        texts = times_files(found, rings, source=Path(record).name)
        say(*(f"written: {path}" for path in write_folder(Path(output), texts, FILES, force=force)))


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
    from electrovib.recordings.importing.steps import seconds

    return None if text is None else seconds(option, text)


def _levels(text: str) -> tuple[float, float]:
    from electrovib.core.errors import InputError

    try:
        low, high = (float(part.strip().removesuffix("%")) / 100 for part in text.split(":"))
    except ValueError:
        raise InputError(f"--levels {text}: expected two levels in per cent, such as 10:90") from None
    return low, high
