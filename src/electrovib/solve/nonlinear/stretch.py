"""The drive between two neighbouring breaks, smooth up to both ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.drive.parts import Tones
from electrovib.physics.drive.pieces import Linear

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Smooth

_SLACK = 16 * float(np.finfo(float).eps)
"""Relative difference of times up to which an output time counts as equal to a break."""


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """Voltage of a drive within an interval where it is smooth: a straight line, tones and formulas.

    Parameters
    ----------
    start, level, slope : float
        Beginning [s], and level [V] and slope [V/s] of the straight line from there.
    parts : tuple of Tones or Smooth
        Parts of the drive that are on.
    """

    start: float
    level: float
    slope: float
    parts: tuple[Tones | Smooth, ...] = ()

    def voltage(self, time: Any) -> tuple[Any, Any]:
        """Return the voltage [V] and its rate of change [V/s], also just before the break that ends the interval."""
        value: Any = self.level + self.slope * (time - self.start)
        rate: Any = self.slope
        for part in self.parts:
            if isinstance(part, Tones):
                wave = np.exp(2j * np.pi * np.multiply.outer(part.frequencies, time))
                value = value + (part.amplitudes @ wave).real
                rate = rate - (2 * np.pi * part.frequencies * part.amplitudes @ wave).imag
            else:
                at = np.asarray(time)
                value, rate = value + part.formula(at), rate + part.derivative(at)
        return value, rate


def snapped(times: Real, breaks: list[float]) -> Real:
    """Set output times that equal a break within rounding to the time of the break, as the drive itself does.

    `times` (n,) [s]; returns `times` (n,) [s].
    """
    if not breaks:
        return times
    marks = np.array(breaks)
    places = np.clip(np.searchsorted(marks, times), 1, max(len(marks) - 1, 1))
    found = times.copy()
    for near in (marks[places - 1], marks[np.minimum(places, len(marks) - 1)]):
        found = np.where(np.abs(times - near) <= _SLACK * times, near, found)
    return found


def stretch_after(drive: Drive, *, time: float, following: float) -> Stretch:
    """Return the drive between two neighbouring breaks."""
    level, slope = 0.0, 0.0
    kept: list[Tones | Smooth] = []
    middle = (time + following) / 2
    for part in drive.parts():
        if isinstance(part, Linear):
            piece = np.array(middle)
            rise = float(part.slope(piece))
            level, slope = level + float(part.value(piece)) - rise * (middle - time), slope + rise
        elif part.start <= middle < part.stop:
            kept.append(part)
    return Stretch(start=time, level=level, slope=slope, parts=tuple(kept))
