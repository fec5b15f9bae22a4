"""Rate of change of a drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.pieces import Linear

if TYPE_CHECKING:
    from electrovib.physics.drive.base import Drive

_ROUNDED = 1e-9
"""Height of a step over the bound of the drive, below which it is rounding."""


def slew_of(drive: Drive, end: float, *, from_rest: bool = True) -> float:
    """Return the largest absolute rate of change of a drive up to `end` [s], in V/s, or in A/s of a current drive.

    It is infinite where the drive is discontinuous, also at time 0 if it starts `from_rest` at another value
    than 0. It is exact for straight pieces; of tones and formulas the bound 2 pi f times the amplitude is
    used.
    """
    parts = drive.parts()
    smallest = _ROUNDED * sum(part.bound() for part in parts)
    if from_rest and abs(float(drive.voltage(0.0))) > smallest:
        return math.inf
    if np.any(np.abs(drive.corners(end)[1]) > smallest):
        return math.inf
    total = 0.0
    for part in parts:
        if isinstance(part, Linear):
            inside = part.times[:-1] < end
            total += float(np.max(np.abs(part.slopes()[:-1][inside]), initial=0.0))
        else:
            total += 2 * math.pi * part.highest_frequency * part.bound()
    return total
