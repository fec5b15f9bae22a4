"""Parts of the analysis of a release: end of the drive, turning points, damped sines, levels by least squares."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.correlated import autocovariance, covariance

if TYPE_CHECKING:
    from numpy.typing import NDArray

_STANDS_OUT = 3.0
"""Smallest distance of a turning point from the level, in standard deviations of the noise."""


@dataclass(frozen=True)
class Extremum:
    """A turning point of the force."""

    time: float
    force: float


@dataclass(frozen=True, kw_only=True)
class Decay:
    """A damped sine about a level, from the time `start` on, with standard uncertainties by the correlated residuals."""

    start: float
    frequency: float
    quality: float
    frequency_uncertainty: float
    quality_uncertainty: float
    misfit: float

    def to_dict(self) -> dict[str, float]:
        """Return plain numbers for JSON."""
        return asdict(self)


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


def levels_and_misfit(
    *, shape: NDArray[np.float64], force: NDArray[np.float64], stamps: NDArray[np.float64]
) -> tuple[float, float, float, NDArray[np.float64], NDArray[np.float64]]:
    """Fit the two levels of a shape, 1 before the release and 0 long after it, to a force.

    Returns the levels at 1 and 0, the misfit as in `Release`, infinite if the force does not change, model
    less force, and model.
    """
    centred = shape - shape.mean()
    square = float(centred @ centred)
    slope = float(centred @ force) / square if square else 0.0
    after = float(force.mean()) - slope * float(shape.mean())
    model = after + slope * shape
    residual = model - force
    since = stamps >= 0
    moved = float(np.sqrt(np.mean((force[since] - after) ** 2)))
    misfit = float(np.sqrt(np.mean(residual[since] ** 2))) / moved if moved else np.inf
    return after + slope, after, misfit, residual, model


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
) -> Decay | None:
    """Fit a damped sine about a level to a section of a record; None if it holds fewer than 12 samples."""
    from scipy.optimize import least_squares

    part = (stamps >= start) & (stamps <= end)
    time, values = stamps[part] - start, force[part]
    if len(time) < 12:
        return None

    def model(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        frequency, rate = np.exp(logs)
        wave = np.exp((2j * np.pi * frequency - rate) * time)
        basis = np.column_stack([wave.real, wave.imag, np.ones_like(time)])
        return np.asarray(basis @ np.linalg.lstsq(basis, values, rcond=None)[0])

    def residual(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        return model(logs) - values

    slow, fast = 1 / time[-1], 1 / (4 * float(np.median(np.diff(time))))
    grid = [
        np.log([f, np.pi * f / q]) for f in np.geomspace(1.05 * slow, fast / 1.05, 40) for q in (1.5, 4.0)
    ]
    begin = min(grid, key=lambda logs: float(np.sum(residual(logs) ** 2)))
    bounds = (np.log([slow, slow / 100]), np.log([fast, 20 * fast]))
    found = least_squares(residual, begin, bounds=bounds)
    frequency, rate = (float(value) for value in np.exp(found.x))
    left = residual(found.x)
    # amplitudes and level are fitted for each frequency and rate, so the Jacobian contains their effect
    alike = covariance(jacobian=found.jac, autocovariance=autocovariance(left, fitted=5))
    quality = float(np.pi * frequency / rate)
    of_quality = float(alike[0, 0] + alike[1, 1] - 2 * alike[0, 1])
    return Decay(
        start=start,
        frequency=frequency,
        quality=quality,
        frequency_uncertainty=frequency * float(np.sqrt(alike[0, 0])),
        quality_uncertainty=quality * float(np.sqrt(max(of_quality, 0.0))),
        misfit=float(np.sqrt(np.mean(left**2))),
    )
