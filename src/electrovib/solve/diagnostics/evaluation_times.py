"""Evaluation times at which the largest values of a solution are sought, whatever the output times are."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive

PER_CYCLE = 64
"""Evaluation times in a cycle of the fastest oscillation of the drive; a parabola through three has the peak to 1e-6."""
MOST_OSCILLATIONS = 250
"""Cycles of one interval that are all evaluated; of more, half as many at either end, and scattered times between."""
_GOLDEN = (5**0.5 - 1) / 2
"""Multiples of it modulo 1 are evenly distributed and in step with no oscillation."""
FEW_CORNERS = 60
"""Number of corners, the first and the last ones, that are followed by times on a logarithmic scale."""
MOST_CORNERS = 10_000
"""Corners that are all evaluated; of more, an even choice."""
AFTER = np.append(1e-9, np.geomspace(1e-6, 1.0, 73)[:-1])
"""Evaluation times after a corner, as fractions of the time to the next one."""
BEFORE = 1 - np.array([1e-6, 1e-9])
"""Evaluation times just before a corner, as fractions of the time since the previous one."""
FIRST_CYCLES = 20
"""First cycles of a periodic drive from rest that are all evaluated; of the later ones a thinning choice, and the last two."""


def evaluation_times(
    drive: Drive, *, end: float, settled: bool, beside: float = 0.0, seen: Real | None = None
) -> Real:
    """Return times at which a linear response can be largest.

    They are the corners of the drive, times just before them and on a logarithmic scale after them, and
    `PER_CYCLE` times in each cycle of its fastest oscillation. From rest the response to a periodic drive
    approaches its periodic state, so that of the later cycles a choice suffices.
    """
    period = drive.period
    if seen is not None and shows_every_sample(drive, seen):
        return _near_the_ends(drive, end, beside)
    if period is None or (end <= period and not settled):
        return _stretch(drive, 0.0, end, beside)
    if settled:
        return _stretch(drive, 0.0, period, beside)
    within = (
        _stretch(drive, period, 2 * period, beside) - period
    )  # a discontinuity in the first cycle may come from switching on alone
    count = int(np.ceil(end / period))
    later = np.geomspace(FIRST_CYCLES, max(count, FIRST_CYCLES + 1), FIRST_CYCLES).astype(int)
    cycles = np.unique(np.concatenate([np.arange(min(count, FIRST_CYCLES)), later, [count - 2, count - 1]]))
    cycles = cycles[(cycles >= 0) & (cycles < count)]
    found = np.concatenate(
        [_stretch(drive, 0.0, period, beside), (within + cycles[:, None] * period).ravel(), [end]]
    )
    return np.unique(found[found <= end])


def around_kinks(kinks: Real, end: float) -> Real:
    """Return times just before and after changes between the regimes of an amplifier with limits, as around corners.

    `kinks` (n,) [s].

    The current into a capacitance is discontinuous there, and a parabola through both sides would not be its largest value.
    """
    if not len(kinks):
        return kinks
    since, until = np.diff(kinks, prepend=0.0), np.diff(kinks, append=end)
    few = _first_and_last(len(kinks))
    after = (kinks[few, None] + until[few, None] * AFTER).ravel()
    moments = np.unique(np.concatenate([kinks - AFTER[0] * since, kinks, kinks + AFTER[0] * until, after]))
    return np.asarray(moments[moments <= end])


def shows_every_sample(drive: Drive, times: Real) -> bool:
    """Return whether times are the samples of a measured drive, and too many to evaluate just before each.

    `times` (n,) [s].
    """
    parts = drive.parts()
    return len(times) > MOST_CORNERS and len(parts) == 1 and parts[0].begins_with(times)


def _near_the_ends(drive: Drive, end: float, beside: float) -> Real:
    """Return evaluation times between the first and between the last samples of a drive [s]."""
    corners, half = drive.corners(end)[0], FEW_CORNERS // 2
    corners = np.append(0.0, corners)
    spans = [corners[: half + 1], corners[-half - 1 :]]
    shares = np.concatenate([AFTER, BEFORE])
    found = [(each[:-1, None] + np.diff(each)[:, None] * shares).ravel() for each in spans]
    return np.unique(np.concatenate([*found, *_oscillating(beside, 0.0, end)]))


def count_evaluation_times(drive: Drive, *, end: float, settled: bool, beside: float = 0.0) -> int:
    """Return an upper estimate of the number of times that `evaluation_times` returns."""
    period, cycles = drive.period, 1
    if period is not None and (settled or end > period):
        cycles = 1 if settled else min(math.ceil(end / period), 2 * FIRST_CYCLES + 2) + 1
        end = period
    corners = min(drive.count_corners(end) + 2, MOST_CORNERS)
    oscillations = (drive.highest_frequency + beside) * end
    if oscillations > MOST_OSCILLATIONS:
        oscillations = 1.5 * MOST_OSCILLATIONS
    near = min(corners, FEW_CORNERS) * len(AFTER)
    return math.ceil(cycles * (corners * (1 + len(BEFORE)) + near + oscillations * PER_CYCLE)) + 1


def _stretch(drive: Drive, start: float, end: float, beside: float) -> Real:
    """Return evaluation times between two times, both included [s]."""
    corners = drive.corners(end)[0]
    corners = np.unique(np.concatenate([[start], corners[(corners > start) & (corners <= end)], [end]]))
    if len(corners) > MOST_CORNERS:
        corners = corners[np.unique(np.linspace(0, len(corners) - 1, MOST_CORNERS).astype(int))]
    spans = np.diff(corners)
    near = _first_and_last(len(spans))
    found = [corners]
    found += [(corners[:-1, None] + spans[:, None] * BEFORE).ravel()]
    found += [(corners[near, None] + spans[near, None] * AFTER).ravel()]
    return np.unique(np.concatenate([*found, *_oscillating(drive.highest_frequency + beside, start, end)]))


def _first_and_last(count: int) -> NDArray[np.intp]:
    """Return the indices of the corners that are followed by times on a logarithmic scale."""
    indices = np.arange(count)
    return indices[(indices < FEW_CORNERS // 2) | (indices >= count - FEW_CORNERS // 2)]


def _oscillating(frequency: float, start: float, end: float) -> list[Real]:
    cycles = (end - start) * frequency
    if cycles <= MOST_OSCILLATIONS:
        return [np.linspace(start, end, int(np.ceil(cycles * PER_CYCLE)) + 1)]
    count, share = MOST_OSCILLATIONS * PER_CYCLE // 2, MOST_OSCILLATIONS / 2 / cycles * (end - start)
    scattered = np.asarray(start + (end - start) * (np.arange(count) * _GOLDEN % 1), dtype=float)
    return [np.linspace(start, start + share, count), scattered, np.linspace(end - share, end, count)]
