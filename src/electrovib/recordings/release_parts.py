"""Pieces of a ringing: the end of the drive, turning points, damped sines, levels by least squares."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.correlated import autocovariance, covariance

if TYPE_CHECKING:
    from numpy.typing import NDArray

_STANDS_OUT = 3.0
"""A turning point is this many times the scatter away from the level."""


@dataclass(frozen=True)
class Extremum:
    """A turning point.

    Parameters
    ----------
    time, force : float
        s and N.
    """

    time: float
    force: float


@dataclass(frozen=True, kw_only=True)
class Decay:
    """A damped sine about a level.

    Parameters
    ----------
    start : float
        First sample that was fitted [s].
    frequency, quality : float
        Of the damped oscillation [Hz], and its quality factor [1].
    frequency_uncertainty, quality_uncertainty : float
        Standard uncertainty of the fit, with neighbouring residuals counted as alike.
    misfit : float
        rms of what is left [N].
    """

    start: float
    frequency: float
    quality: float
    frequency_uncertainty: float
    quality_uncertainty: float
    misfit: float

    def to_dict(self) -> dict[str, float]:
        """Give plain numbers for JSON."""
        return asdict(self)


def drive_end(*, time: NDArray[np.float64], voltage: NDArray[np.float64], name: str = "voltage") -> float:
    """Find when a drive falls for the last time below half of its largest magnitude.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s.
    voltage : ndarray, shape (n,)
        V, as read back; or 1 while it is on.
    name : str
        Of that column, for messages.

    Returns
    -------
    float
        s: half way between the last sample above half and the next one; the fall lies between the two.

    Raises
    ------
    InputError
        If there is no drive, or it does not end.
    """
    on, peak = _on(voltage)
    if peak == 0 or len(on) == len(time):
        raise InputError(
            f"{name}: lies between {voltage.min():g} and {voltage.max():g} and never goes on and off; is it the"
            " right column?"
        )
    if on[-1] == len(time) - 1:
        raise InputError(f"{name}: the drive is still on at the last sample, so nothing lets go")
    return float(time[on[-1]] + time[on[-1] + 1]) / 2


def _on(voltage: NDArray[np.float64]) -> tuple[NDArray[np.intp], float]:
    """Give the samples at which the drive is on, and its size."""
    size = np.abs(voltage)
    # of a read-back with spikes, the size is that of the upper part of what is on
    peak = float(np.quantile(size[size >= size.max() / 2], 0.5))
    return np.flatnonzero(size > peak / 2), peak


def levels_and_misfit(
    *, shape: NDArray[np.float64], force: NDArray[np.float64], stamps: NDArray[np.float64]
) -> tuple[float, float, float, NDArray[np.float64], NDArray[np.float64]]:
    """Fit the levels at 1 and at 0 of a shape to a force.

    Parameters
    ----------
    shape : ndarray, shape (n,)
        1 before, 0 long after [1].
    force : ndarray, shape (n,)
        N.
    stamps : ndarray, shape (n,)
        s after the end of the drive.

    Returns
    -------
    tuple
        Level at 1 and at 0 [N]; rms of the residual over rms of the force about its last level, both from the
        end of the drive on [1]; residual and model [N].
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
    """Find turning points after a release, one side after the other, until they sink into the scatter.

    Parameters
    ----------
    stamps : ndarray, shape (n,)
        s.
    force : ndarray, shape (n,)
        N.
    start, end : float
        Where to begin and to stop [s].
    period : float
        About how long an oscillation lasts [s].
    level, scatter : float
        Force that it dies away to, and standard deviation of the noise [N].

    Returns
    -------
    list of Extremum
        Each the top of a parabola through the samples within an eighth of a period.
    """
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
    """Fit a damped sine about a level to a part of a record.

    Parameters
    ----------
    stamps : ndarray, shape (n,)
        s.
    force : ndarray, shape (n,)
        N.
    start, end : float
        Part to be fitted [s].

    Returns
    -------
    Decay or None
        None where fewer than 12 samples are left.
    """
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
    # amplitudes and level are fitted anew for each frequency and rate, so their part is in these slopes already
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
