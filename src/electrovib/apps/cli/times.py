"""``electrovib times``: times of edges, or friction of swipes, in a record and without a model of the experiment."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import answered
from electrovib.core.deprecation import former_value
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.recordings.transitions.ring import MeasuredRings
    from electrovib.recordings.transitions.times import MeasuredTimes


def times(
    context: typer.Context,
    *,
    record: Annotated[str, typer.Argument()],
    quantity: options.Text = None,
    levels: Annotated[str, typer.Option()] = "10:90",
    by: options.Text = None,
    antiphase: options.Flag = False,
    sensor: options.Text = None,
    edges: Annotated[str, typer.Option()] = "both",
    window: options.Text = None,
    before: options.Text = None,
    ring: options.Flag = False,
    swipes: options.Flag = False,
    channels: Annotated[str | None, typer.Option("--recipe")] = None,
    speed: options.Text = None,
    saved: options.AnswerOptions,
) -> None:
    """Measure rise and fall times, or swipes, in a record.

    Report the times with and without the sensor, each with a 95 % interval; with --swipes the friction and the forces of
    contacts and slides, from which the zeros of the sensors are subtracted.

    Parameters
    ----------
    record
        Trace file with signals over time, as electrovib import writes it; with --recipe a file of an instrument.
    quantity : SIGNAL
        Signal whose edges are measured; by default the only one besides --by.
    levels : LOW:HIGH
        Levels in per cent of the range of an edge.
    by : SIGNAL
        Signal of the drive, whose switching marks the edges.
    antiphase
        The signal of --by is one of two electrodes driven in antiphase.
    sensor : HZ:Q|estimate
        Sensor that is taken out: natural frequency and quality factor, such as 380Hz:3, or estimated from the edges.
    edges : both|rising|falling
        Edges that are measured.
    window : TIME
        Length of the section after an edge, such as '20 ms'.
    before : TIME
        Length of the section before an edge.
    ring
        Measure also the oscillation after each impact, or after the last switching of --by.
    swipes
        Find swipes in a record of a normal and a lateral force instead, and reduce them to friction and forces.
    channels : FILE.toml
        Of --swipes: columns of the file of an instrument, with sensitivities, clock and encoder.
    speed : SPEED
        Of --swipes: set sliding speed, such as '40 mm/s', where no motion is recorded.
    """
    from electrovib.recordings.swipe.reduce import reduce_swipes
    from electrovib.recordings.swipe.result import Swipes
    from electrovib.recordings.transitions.times import MeasuredTimes

    if swipes or channels:
        options.only(context, "record swipes channels speed output all", "--swipes")
        asked = options.given(recording=record, channels=channels, speed=speed)
        answered(Swipes, reduce_swipes, "finding swipes", asked, saved)
        return
    accepted = "record quantity levels by antiphase sensor edges window before ring output all"
    options.only(context, accepted, "times, but to --swipes")
    asked = options.given(
        record=record, quantity=quantity, levels=levels, by=by, antiphase=antiphase, ring=ring
    )
    asked |= options.given(sensor=sensor, edges=edges, window=window, before=before)
    asked |= {"exponentials": former_value("exponentials", 3)}
    answered(MeasuredTimes, _times, "measuring times", asked, saved)


def _times(
    record: str,
    *,
    levels: str,
    quantity: str | None = None,
    by: str | None = None,
    antiphase: bool = False,
    ring: bool = False,
    **options: Any,
) -> "MeasuredTimes | MeasuredRings":
    """Measure times, and oscillations where they are asked for; such a record needs no edges, and why it has none is stated."""
    from electrovib.data.traces import open_trace
    from electrovib.physics.drive.readback import OneOfTwoInAntiphase
    from electrovib.recordings.importing.reduction import seconds
    from electrovib.recordings.transitions.ring import MeasuredRings, measure_ring, measure_rings
    from electrovib.recordings.transitions.times import measure_times

    options |= {name: seconds(f"--{name}", options[name]) for name in ("window", "before") if name in options}
    trace, window = open_trace(record), options.get("window")
    chosen: dict[str, Any] = {"quantity": quantity, "by": by}
    chosen["readback"] = OneOfTwoInAntiphase() if antiphase else None
    rings = None
    if ring and by is None:
        rings = measure_rings(trace, quantity=quantity, window=window)
    elif ring:
        rings = MeasuredRings(rings=(measure_ring(trace, **chosen, window=window),))
    try:
        found = measure_times(trace, levels=_levels(levels), **chosen, **options)
    except InputError as error:
        if rings is None:
            raise
        why = f"No time between levels: {error.problems[0]}."
        return replace(rings, skipped=(why, *rings.skipped))
    return replace(found, rings=rings)


def _levels(text: str) -> tuple[float, float]:
    try:
        low, high = (float(part.strip().removesuffix("%")) / 100 for part in text.split(":"))
    except ValueError:
        raise InputError(f"--levels {text}: expected two levels in per cent, such as 10:90") from None
    if 0 <= low < high <= 0.01:
        meant = f"{1e4 * low:g}:{1e4 * high:g}"
        raise InputError(f"--levels {text}: levels are in per cent; write {meant}")
    return low, high
