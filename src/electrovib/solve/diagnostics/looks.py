"""When to look at a solution for its largest values, whatever times are asked for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.pieces import Linear

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive

PER_CYCLE = 64
"""Looks at each cycle of the drive's fastest oscillation; a parabola through three of them meets a largest value to 1e-6."""
MOST_OSCILLATIONS = 250
"""Of one stretch of time that are looked at throughout; of more, half as many at either end and scattered looks."""
_GOLDEN = (5**0.5 - 1) / 2
"""Multiples of it fall evenly, and on no beat of any oscillation."""
FEW_CORNERS = 60
"""After so many corners, the first and the last, a decay is looked for on a logarithmic scale."""
MOST_CORNERS = 10_000
"""At which there is a look at all; beyond it, at an even choice of them."""
AFTER = np.append(1e-9, np.geomspace(1e-6, 1.0, 73)[:-1])
"""Looks between one corner and the next, as a share of the time between them."""
BEFORE = 1 - np.array([1e-6, 1e-9])
"""Looks just before a corner, as a share of the same."""
FIRST_CYCLES = 20
"""Cycles of a repeating drive that are all looked at from rest; after them a growing choice, and the last."""


def looks(drive: Drive, *, end: float, settled: bool, beside: float = 0.0, seen: Real | None = None) -> Real:
    """Choose times at which a linear response can be largest.

    Parameters
    ----------
    drive : Drive
        Off before time 0, unless the state is settled.
    end : float
        Last time that counts [s].
    settled : bool
        The response repeats with the drive: one period says all.
    beside : float
        Highest frequency of anything else that moves [Hz].
    seen : ndarray, optional
        Output times [s]. Of a measured drive whose samples are all among them only the first and last are looked at;
        `PeakRecord.just_before` looks at the largest values.

    Returns
    -------
    ndarray
        Increasing, from 0 on and up to the end, or up to the period of a settled drive [s].

    Notes
    -----
    Corners of the drive, times just before them and on a logarithmic scale after them, and `PER_CYCLE` looks at
    each cycle of its fastest oscillation. From rest the response to a repeating drive comes closer to its periodic
    state from cycle to cycle, so that later cycles are looked at by choice.
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
    )  # a jump of the first cycle may be the switch alone
    count = int(np.ceil(end / period))
    later = np.geomspace(FIRST_CYCLES, max(count, FIRST_CYCLES + 1), FIRST_CYCLES).astype(int)
    cycles = np.unique(np.concatenate([np.arange(min(count, FIRST_CYCLES)), later, [count - 2, count - 1]]))
    cycles = cycles[(cycles >= 0) & (cycles < count)]
    found = np.concatenate(
        [_stretch(drive, 0.0, period, beside), (within + cycles[:, None] * period).ravel(), [end]]
    )
    return np.unique(found[found <= end])


def shows_every_sample(drive: Drive, times: Real) -> bool:
    """Tell whether times are the samples of a measured drive, too many to look just before each.

    Parameters
    ----------
    drive : Drive
        Any.
    times : ndarray, shape (n,)
        Increasing [s].

    Returns
    -------
    bool
        Never for a formula.
    """
    parts = drive.parts()
    return (
        len(times) > MOST_CORNERS
        and len(parts) == 1
        and isinstance(parts[0], Linear)
        and parts[0].begins_with(times)
    )


def _near_the_ends(drive: Drive, end: float, beside: float) -> Real:
    """Looks between the first and between the last samples of a drive."""
    corners, half = drive.corners(end)[0], FEW_CORNERS // 2
    corners = np.append(0.0, corners)
    spans = [corners[: half + 1], corners[-half - 1 :]]
    shares = np.concatenate([AFTER, BEFORE])
    found = [(each[:-1, None] + np.diff(each)[:, None] * shares).ravel() for each in spans]
    return np.unique(np.concatenate([*found, *_oscillating(beside, 0.0, end)]))


def count_looks(drive: Drive, *, end: float, settled: bool, beside: float = 0.0) -> int:
    """Tell at most how many times `looks` chooses, without choosing them.

    Parameters
    ----------
    drive, end, settled, beside
        As for `looks`: a Drive, s, bool, Hz.

    Returns
    -------
    int
        About as many, or more.
    """
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
    """Looks between two times, both included."""
    corners = drive.corners(end)[0]
    corners = np.unique(np.concatenate([[start], corners[(corners > start) & (corners <= end)], [end]]))
    if len(corners) > MOST_CORNERS:
        corners = corners[np.unique(np.linspace(0, len(corners) - 1, MOST_CORNERS).astype(int))]
    spans = np.diff(corners)
    near = np.arange(len(spans))
    near = near[(near < FEW_CORNERS // 2) | (near >= len(spans) - FEW_CORNERS // 2)]
    found = [corners]
    found += [(corners[:-1, None] + spans[:, None] * BEFORE).ravel()]
    found += [(corners[near, None] + spans[near, None] * AFTER).ravel()]
    return np.unique(np.concatenate([*found, *_oscillating(drive.highest_frequency + beside, start, end)]))


def _oscillating(frequency: float, start: float, end: float) -> list[Real]:
    cycles = (end - start) * frequency
    if cycles <= MOST_OSCILLATIONS:
        return [np.linspace(start, end, int(np.ceil(cycles * PER_CYCLE)) + 1)]
    count, share = MOST_OSCILLATIONS * PER_CYCLE // 2, MOST_OSCILLATIONS / 2 / cycles * (end - start)
    scattered = np.asarray(start + (end - start) * (np.arange(count) * _GOLDEN % 1), dtype=float)
    return [np.linspace(start, start + share, count), scattered, np.linspace(end - share, end, count)]
