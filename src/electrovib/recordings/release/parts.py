"""Parts of the analysis of a release: end of the drive, turning points, damped sines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.transitions import modes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.recordings.transitions.modes import RingSection

_STANDS_OUT = 3.0
"""Smallest distance of a turning point from the level, in standard deviations of the noise."""


@dataclass(frozen=True)
class Extremum:
    """A turning point of the force."""

    time: float
    force: float


def drive_end(*, time: NDArray[np.float64], voltage: NDArray[np.float64], name: str = "voltage") -> float:
    """Return the mean time of the last sample above half of the largest magnitude of a drive and of the next one."""
    on, peak = _on(voltage)
    if peak == 0 or len(on) == len(time):
        raise InputError(
            f"{name}: lies between {voltage.min():g} and {voltage.max():g} and is never switched on and off; is it the"
            " right column?"
        )
    if on[-1] == len(time) - 1:
        raise InputError(f"{name}: the drive is still on at the last sample, so the record holds no release")
    return float(time[on[-1]] + time[on[-1] + 1]) / 2


def _on(voltage: NDArray[np.float64]) -> tuple[NDArray[np.intp], float]:
    """Return the samples at which the drive is on, and its magnitude."""
    size = np.abs(voltage)
    # a median, because the read-back may have spikes
    peak = float(np.quantile(size[size >= size.max() / 2], 0.5))
    return np.flatnonzero(size > peak / 2), peak


def find_extrema(
    stamps: NDArray[np.float64],
    force: NDArray[np.float64],
    *,
    start: float,
    period: float,
    level: float,
    scatter: float,
    end: float,
) -> list[Extremum]:
    """Find the turning points after a release, on alternate sides of the level, as far as they exceed the noise `scatter`."""
    before = force[stamps < 0]
    side = -1.0 if np.mean(before[-20:]) > level else 1.0
    place, reach, found = start, (0.2, 0.9), []
    while place + reach[1] * period < end:
        part = np.flatnonzero((stamps > place + reach[0] * period) & (stamps < place + reach[1] * period))
        if len(part) < 5:
            break
        top = float(stamps[part[int(np.argmax(side * force[part]))]])
        extremum = _parabola(stamps, force, top, period / 8)
        if extremum is None or side * (extremum.force - level) < _STANDS_OUT * scatter:
            break
        found.append(extremum)
        place, side, reach = extremum.time, -side, (0.25, 0.8)
    return found


def _parabola(
    stamps: NDArray[np.float64], force: NDArray[np.float64], top: float, half: float
) -> Extremum | None:
    for _ in range(3):
        near = np.abs(stamps - top) <= half
        if np.count_nonzero(near) < 4:
            return None
        square, slope, level = np.polyfit((stamps[near] - top) / half, force[near], 2)
        if square == 0:
            return None
        shift = float(np.clip(-slope / (2 * square), -1, 1))
        top += shift * half
    return Extremum(float(top), float(level - slope**2 / (4 * square)))


def damped_sine(
    stamps: NDArray[np.float64], force: NDArray[np.float64], *, start: float, end: float
) -> RingSection | None:
    """Fit a damped sine about a level to a section of a record; None if it holds fewer than 12 samples."""
    part = (stamps >= start) & (stamps <= end)
    return modes.damped_sine(stamps[part], force[part], start=start) if np.count_nonzero(part) >= 12 else None
