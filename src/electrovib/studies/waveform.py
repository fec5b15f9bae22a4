"""A drive as evenly spaced samples, with ramps at either end and the largest error of what is played between them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, refuse
from electrovib.core.unchangeable import Unchangeable
from electrovib.core.units import format_quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.extremes import extremes
from electrovib.physics.drive.parts import CYCLE_SAMPLES, MOST_SAMPLES, Linear

LARGEST_ERROR: Final = 0.01
"""Error over the largest voltage [1] above which a waveform is refused, by default; a choice."""
MOST_POINTS: Final = 2_000_000
"""Most samples of a waveform; a choice."""
ZERO: Final = 1e-9
"""Share of the largest voltage below which a first or last sample is 0 V with a rounding error."""
_ROUNDED: Final = 1e-9
"""Difference of a product of time and rate from a whole number that counts as rounding."""
_STEPS: Final = (1, 2, 5)
_FINER: Final = 0.25
"""Share of the allowed error at which the search for a rate ends."""


@dataclass(frozen=True, kw_only=True)
class Waveform(Unchangeable):
    """Evenly spaced samples of a drive, as they are played or written, at `rate` per second.

    With `held` an instrument holds each sample until the next; else straight lines join them. `error` is the
    largest absolute difference from the drive at any time up to the last, between the samples too [V].
    """

    times: Real
    voltages: Real
    rate: float
    held: bool
    peak: float
    error: float

    @property
    def share(self) -> float:
        """Error over the largest voltage of the drive [1]; 0 for a drive of 0 V."""
        return self.error / self.peak if self.peak else (math.inf if self.error else 0.0)

    @property
    def between(self) -> str:
        """What is between two samples, in words."""
        return "each sample held until the next" if self.held else "straight lines between the samples"

    def with_voltages(self, voltages: Real, drive: Drive, end: float) -> Waveform:
        """Return the waveform with the voltages that a format can hold, and their error up to the time `end`."""
        error = sampling_error(drive, self.times, voltages, held=self.held, end=end)
        return replace(self, voltages=voltages, error=error)

    def refuse_above(self, largest_error: float) -> None:
        """Raise an error if the error of the waveform over its largest voltage exceeds `largest_error`."""
        if self.share <= largest_error:
            return
        raise InputError(
            f"the waveform differs from the drive by up to {format_quantity(self.error, 'V', digits=3)},"
            f" {100 * self.share:.3g} % of its largest voltage ({len(self.times)} samples at"
            f" {format_quantity(self.rate, 'Hz', digits=6)}, {self.between}), and {100 * largest_error:.3g} % is allowed."
            " Nothing was written. Take a higher rate, a shorter time, or edges instead of discontinuities"
        )


def waveform(
    drive: Drive,
    *,
    end: float | None = None,
    rate: float | None = None,
    rates: Iterable[float] | None = None,
    held: bool = False,
    largest_error: float = LARGEST_ERROR,
    most_points: int = MOST_POINTS,
    ramp: float | None = None,
) -> Waveform:
    """Sample a drive evenly, at a given rate or at the lowest one whose error is a quarter of that allowed.

    Rates to choose from are by default 1, 2 and 5 times a power of ten, adjusted so that the last sample is
    at the end. With a `ramp` a sample after the end is that of the drive, otherwise 0 V. A discontinuity is
    refused where samples are joined by straight lines.
    """
    last = drive.duration if end is None else end
    _check(drive, last, rate, largest_error, most_points)
    peak = drive.largest(last)
    if not held:
        _refuse_discontinuities(drive, last, peak)
    if rate is not None:
        return _at(drive, rate, last, held=held, peak=peak, ramp=ramp)
    found = None
    for each in rates if rates is not None else _rates(drive, last, most_points):
        if _count(each, last) > most_points and found is not None:
            break
        if _count(each, last) > most_points:
            why = f"{_count(each, last)} samples at {each:g} Hz for {last:g} s are more than {most_points}; take a shorter time"
            raise InputError(why, path="rate")
        found = _at(drive, each, last, held=held, peak=peak, ramp=ramp)
        if found.share <= _FINER * largest_error:
            break
    assert found is not None
    return found


def sampling_error(drive: Drive, times: Real, voltages: Real, *, held: bool, end: float) -> float:
    """Return the largest absolute difference of a drive and its samples at any time up to `end`.

    It is exact for straight pieces and one tone, never too small for others: the difference is a sum of
    closed forms, whose extremes `Drive.extremes` brackets. At a discontinuity both sides count.
    """
    before = -voltages if not held else -np.append(0.0, voltages[:-1])
    before[0] = 0.0
    parts = [part.until(end) if isinstance(part, Linear) else part for part in drive.parts()]
    parts.append(Linear(times, before, -voltages))
    cycles = max((part.highest_frequency for part in parts), default=0.0) * end
    windows = max(1, math.ceil(4 * cycles * CYCLE_SAMPLES * len(parts) / MOST_SAMPLES))
    edges = np.linspace(0.0, end, windows + 1)
    found = [
        extremes(parts, first, last)
        for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ]
    return max(0.0, *(max(-low, high) for low, high in found))


def refuse_unless_zero_at_both_ends(drive: Drive, end: float) -> None:
    """Refuse a drive that an instrument could not begin and end at 0 V."""
    small = ZERO * drive.largest(end)
    problems = []
    for when, time in (("first", 0.0), ("last", end)):
        value = float(drive.voltage(time))
        if abs(value) > small:
            problems.append(
                f"the {when} sample, at {format_quantity(time, 's', digits=6)}, is {format_quantity(value, 'V', digits=4)}:"
                " what an instrument plays begins and ends at 0 V. Nothing was written. Give the drive edges from and to 0 V,"
                " end it after whole periods with time.duration, or add ramps with --ramp"
            )
    refuse(problems)


def _check(drive: Drive, end: float, rate: float | None, largest_error: float, most_points: int) -> None:
    if drive.quantity != "voltage":
        raise InputError("prescribes a current, and a waveform is a voltage", path="drive")
    _check_positive("largest_error", largest_error, "a number above 0")
    _check_positive("end", end, "a time above 0 s")
    if rate is None:
        return
    _check_positive("rate", rate, "a frequency above 0 Hz")
    if not 2 <= _count(rate, end) <= most_points:
        why = f"gives {_count(rate, end)} samples for {end:g} s, and 2 to {most_points} are allowed"
        raise InputError(why, path="rate", value=f"{rate:g}")


def _check_positive(name: str, value: float, what: str) -> None:
    if not 0 < value < math.inf:
        raise InputError(f"must be {what}", path=name, value=str(value))


def _refuse_discontinuities(drive: Drive, end: float, peak: float) -> None:
    times, heights = drive.corners(end)
    steps = np.flatnonzero(np.abs(heights) > ZERO * peak)
    if len(steps):
        first = steps[0]
        raise InputError(
            f"the drive has {len(steps)} discontinuities, the first of {format_quantity(float(heights[first]), 'V', digits=4)} at"
            f" {format_quantity(float(times[first]), 's', digits=4)}: straight lines between samples differ from it by the whole"
            " height. Nothing was written. Give the drive the edge time of the real source"
        )


def _count(rate: float, end: float) -> int:
    """Count the samples up to the end, and the one after it where none is at the end."""
    return math.ceil(end * rate * (1 - _ROUNDED)) + 1


def _rates(drive: Drive, end: float, most_points: int) -> list[float]:
    """Return rates of 1, 2 and 5 times a power of ten, then that of the most points; each with a sample at the end."""
    lowest = max(10 / end, 8 * drive.highest_frequency)
    highest = (most_points - 1) / end
    decade = math.floor(math.log10(lowest))
    nice = [step * 10.0**power for power in range(decade, decade + 15) for step in _STEPS]
    inside = [rate for rate in nice if lowest <= rate <= highest]
    fitting = [(_count(rate, end) - 1) / end for rate in inside]
    close = [
        rate if abs(own - rate) <= _ROUNDED * rate else own for rate, own in zip(inside, fitting, strict=True)
    ]
    return [rate for rate in close if _count(rate, end) <= most_points] + [highest]


def _at(drive: Drive, rate: float, end: float, *, held: bool, peak: float, ramp: float | None) -> Waveform:
    times = np.arange(_count(rate, end)) / rate
    if abs(times[-1] - end) <= _ROUNDED / rate:
        times[-1] = end
    if ramp is not None:
        end = float(times[-1])
    voltages = np.where(times <= end, drive.voltage(np.minimum(times, end)), 0.0)
    for place in (0, -1):
        if abs(voltages[place]) <= ZERO * peak:
            voltages[place] = 0.0
    error = sampling_error(drive, times, voltages, held=held, end=end)
    found = Waveform(times=times, voltages=voltages, rate=rate, held=held, peak=peak, error=error)
    return found if ramp is None else ramped(found, ramp)


def ramped(waveform: Waveform, ramp: float) -> Waveform:
    """Multiply a waveform by an envelope that rises linearly from 0 to 1 and falls back to 0 at its end.

    With samples s and envelope e, the straight line between two products departs from the product of two
    straight lines by at most |ds de|/4; a held product departs from s e(t) by at most |s de|. Either is added
    to the error.
    """
    last = len(waveform.times) - 1
    _check_positive("ramp", ramp, "a time above 0 s")
    count = max(1, round(ramp * waveform.rate))
    if 2 * count > last:
        why = f"two ramps do not fit into {float(waveform.times[-1]):g} s; take a shorter ramp"
        raise InputError(why, path="ramp", value=f"{ramp:g}")
    envelope = envelope_of(last, count)
    voltages = np.where(envelope == 0, 0.0, waveform.voltages * envelope)
    steps = np.abs(np.diff(envelope))
    sizes = np.abs(waveform.voltages[:-1]) if waveform.held else np.abs(np.diff(waveform.voltages)) / 4
    return replace(waveform, voltages=voltages, error=waveform.error + float(np.max(sizes * steps)))


def envelope_of(last: int, count: int) -> Real:
    """Return the envelope (last + 1,) of a waveform from 0 to 1, with `count` intervals of either ramp."""
    places = np.arange(last + 1)
    return np.minimum(1.0, np.minimum(places, last - places) / count)
