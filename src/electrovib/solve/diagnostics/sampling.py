"""Diagnostic of output times that are too far apart to show the drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Part
from electrovib.physics.drive.pieces import Linear

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
MOST: Final = 4_000_000
"""Samples beyond which no number of even times is advised."""


def sampling(drive: Drive, times: Real) -> list[Diagnostic]:
    """Return a warning where output values are exact but a line through them does not follow the result.

    Parameters
    ----------
    drive : Drive
        Drive of the scenario.
    times : ndarray, shape (n,)
        Output times, increasing [s].

    Returns
    -------
    list of Diagnostic
        One warning with the number of samples that suffices, or none.
    """
    if len(times) < 2 or _shows(drive, times):
        return []
    step, fastest = float(np.max(np.diff(times))), _fastest(drive)
    start, end = float(times[0]), float(times[-1])
    needed = max(len(times), math.ceil(FEWEST * fastest * (end - start)) + 1)
    while needed <= MOST and not _shows(drive, np.linspace(start, end, needed)):
        needed = 2 * needed - 1
    changes = f"varies at {format_quantity(fastest, 'Hz')}"
    if step * fastest * FEWEST <= 1 + ROUNDING:
        changes = "has pieces that lie between them"
    advice = f"time.samples = {needed} would show it"
    if drive.time_stamps is not None:
        advice = "omit time.samples: the times of the measured drive show it"
    elif needed > MOST:
        advice = f"more than {MOST} samples would be needed: request numbers with --quantity, or a shorter time.duration"
    text = (
        f"the output times are {format_quantity(step, 's')} apart, but the drive {changes}: the values are exact at each"
        f" time, and a line between them is misleading; {advice}"
    )
    return [Diagnostic("sampling", "warning", text, float(needed), float(len(times)), "1")]


def _shows(drive: Drive, times: Real) -> bool:
    """Return whether a line through these times [s] shows oscillations and straight pieces of a drive."""
    step = float(np.max(np.diff(times)))
    if step * _fastest(drive) * FEWEST > 1 + ROUNDING:
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


def _fastest(drive: Drive) -> float:
    """Return the highest frequency of the parts [Hz]; for straight pieces, one over the duration of all of them."""
    return max((_fastest_of(part) for part in drive.parts()), default=0.0)


def _fastest_of(part: Part) -> float:
    if not isinstance(part, Linear):
        return part.highest_frequency
    lasts = part.period or float(part.times[-1])
    return 1 / lasts if lasts else 0.0
