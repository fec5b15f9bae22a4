"""How many times show a drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.drive.parts import Linear, Part

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive

FEWEST: Final = 8
"""Samples in a cycle of the drive below which a curve is misleading: the force has two cycles in that time."""
MISSED: Final = 1 / 3
"""Limit of the area between the drive and a line through its samples, over the area between the drive and its mean.
Above it the line is misleading: a pulse between two samples has 1, a square wave with 8 samples a period 1/4."""
ROUNDING: Final = 1e-9
"""Relative excess of a time step that counts as rounding."""


def enough(drive: Drive, start: float, end: float, *, fewest: int, most: int) -> int:
    """Return a number of even times from `start` to `end` [s], both included, that shows a drive.

    It is at least `fewest`, and above `most` where no number up to it shows the drive.
    """
    count = max(fewest, math.ceil(FEWEST * fastest_frequency(drive) * (end - start)) + 1)
    while count <= most and not shows(drive, np.linspace(start, end, count)):
        count = 2 * count - 1
    return count


def shows(drive: Drive, times: Real) -> bool:
    """Return whether a line through given times shows oscillations and straight pieces of a drive.

    That is whether the values at the times, shape (n,), increasing [s], joined by straight lines, follow the
    drive.
    """
    step = float(np.max(np.diff(times)))
    if step * fastest_frequency(drive) * FEWEST > 1 + ROUNDING:
        return False
    straight = [part for part in drive.parts() if isinstance(part, Linear) and not part.is_step]
    return all(_missed(part, times) <= MISSED for part in straight)


def _missed(part: Linear, times: Real) -> float:
    """Return the area between straight pieces and a line through these times [s], over that to their mean [1]."""
    if part.begins_with(times) and np.array_equal(part.before[1 : len(times)], part.after[1 : len(times)]):
        return 0.0
    corners = part.corners(float(times[-1]))[0]
    inside = corners[(corners > times[0]) & (corners < times[-1])]
    every = np.union1d(times, inside)
    after, before = part.value(every)[:-1], part.value_before(every[1:])
    line = np.interp(every, times, part.value(times))
    lengths = np.diff(every)
    mean = float(lengths @ (after + before)) / (2 * float(lengths.sum()))
    whole = float(lengths @ (np.abs(after - mean) + np.abs(before - mean)))
    between = float(lengths @ (np.abs(after - line[:-1]) + np.abs(before - line[1:])))
    return between / whole if whole > 0 else 0.0


def fastest_frequency(drive: Drive) -> float:
    """Return the highest frequency [Hz] of the parts of a drive.

    Of straight pieces it is one over the duration of all of them.
    """
    return max((_fastest_of(part) for part in drive.parts()), default=0.0)


def _fastest_of(part: Part) -> float:
    if not isinstance(part, Linear):
        return part.highest_frequency
    lasts = part.period or float(part.times[-1])
    return 1 / lasts if lasts else 0.0
