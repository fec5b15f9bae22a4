"""Times at which a recorded edge passes levels, without any model of its form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.correlated import autocovariance, line

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_REACH: Final = 0.08
"""Fraction of the change by which the signal differs from a level within the section fitted there."""
_FLAT: Final = 0.05
"""Smallest slope at a passage over the mean slope of the edge; where it is less, a longer section is fitted."""
_FEWEST: Final = 5
"""Fewest samples of a section through which a parabola is fitted."""
_CLEAR: Final = 5.0
"""Smallest change of an edge, in standard errors of its levels."""


@dataclass(frozen=True, kw_only=True)
class EdgeLevels:
    """Levels before and after an edge.

    Parameters
    ----------
    before, after : float
        Means, in the unit of the signal.
    before_error, after_error : float
        Their standard errors, with the correlation of the samples.
    noise : float
        Standard deviation of a sample before the edge.
    alike : ndarray, shape (m,)
        Autocovariance of the noise at lags of 0 to m - 1 samples.
    drift : float
        Slope before the edge, in the unit of the signal per second; 0 where it is not significant.
    """

    before: float
    after: float
    before_error: float
    after_error: float
    noise: float
    alike: Real
    drift: float

    @property
    def change(self) -> float:
        """Level after less level before, in the unit of the signal."""
        return self.after - self.before


@dataclass(frozen=True, kw_only=True)
class Passages:
    """Passages of one edge through two levels.

    Parameters
    ----------
    first, last : float
        Times at which the lower and the upper fraction of the change is reached [s].
    first_error, last_error : float
        Their standard errors by the noise [s].
    time : float
        Time between them [s].
    standard_error : float
        Of that time, with the uncertainty of both levels [s].
    interpolated : bool
        Whether a passage lies between two samples alone, because too few samples lie near the level.
    """

    first: float
    last: float
    first_error: float
    last_error: float
    time: float
    standard_error: float
    interpolated: bool


def levels_of(time: Real, values: Real, *, edge: float, settled: float) -> EdgeLevels:
    """Compute the levels before an edge and after its transition.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Times [s], of this edge alone.
    values : ndarray, shape (n,)
        Signal in any unit.
    edge : float
        Time before which the signal has its first level [s].
    settled : float
        Time after which it has its last level [s].

    Returns
    -------
    EdgeLevels
        With standard errors.

    Raises
    ------
    InputError
        If fewer than 8 samples lie on a side, or if the levels do not differ.
    """
    before, after = time < edge, time > settled
    if min(np.count_nonzero(before), np.count_nonzero(after)) < 8:
        raise InputError(
            f"the edge at {edge:.6g} s has {np.count_nonzero(before)} samples before it and {np.count_nonzero(after)} after its"
            " transition; 8 on each side are needed: record longer, or give before and window"
        )
    first, first_error, slope, slope_error = line(time=time[before], values=values[before])
    last, last_error, _, _ = line(time=time[after], values=values[after])
    left = values[before] - first
    if not abs(last - first) > _CLEAR * math.hypot(first_error, last_error):
        raise InputError(
            f"the signal does not change at the edge at {edge:.6g} s: {last - first:.3g} with a standard error of"
            f" {math.hypot(first_error, last_error):.2g}"
        )
    return EdgeLevels(
        before=first, after=last, before_error=first_error, after_error=last_error,
        noise=float(np.std(left)), alike=autocovariance(left, fitted=1),
        drift=slope if abs(slope) > 3 * slope_error else 0.0,
    )  # fmt: skip


def passages(
    time: Real, values: Real, levels: EdgeLevels, *, fractions: tuple[float, float], edge: float
) -> Passages:
    """Find when an edge passes two fractions of its change.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Times [s], increasing.
    values : ndarray, shape (n,)
        Signal in any unit.
    levels : EdgeLevels
        Levels between which it changes.
    fractions : tuple of float
        Fractions of the change from the level before, increasing, between 0 and 1.
    edge : float
        Time after which the passage of half of the change is searched [s].

    Returns
    -------
    Passages
        Last passage through the lower fraction before half of the change, and first passage through the upper one after it.

    Raises
    ------
    InputError
        If the signal does not pass the levels.

    Notes
    -----
    Around each passage a parabola is fitted to the samples for which the signal is within 8 % of the change from the level;
    where fewer than five lie there, two neighbouring samples are interpolated. The standard error of a passage is that of
    the fitted value over the slope.
    """
    progress = (values - levels.before) / levels.change
    noise_share = levels.noise / abs(levels.change)
    smooth = _smoothed(progress, noise_share, longest=_rough(progress, fractions) // 8)
    started = np.flatnonzero((smooth > 0.5) & (time >= edge))
    if not started.size or started[0] == 0:
        raise InputError(
            f"the signal does not pass half of its change after {edge:.6g} s; give a longer window"
        )
    middle = int(started[0])
    below = np.flatnonzero(smooth[:middle] <= fractions[0])
    above = np.flatnonzero(smooth[middle:] >= fractions[1])
    if not below.size or not above.size:
        raise InputError(
            f"the edge near {time[middle]:.6g} s does not pass {fractions[0]:.0%} and {fractions[1]:.0%} of its change within"
            " the window"
        )
    low, high = int(below[-1]), middle + int(above[0])
    rough = max(float(time[high] - time[low]), float(time[1] - time[0]))
    first = _passage(time, progress, smooth, at=low, level=fractions[0], rough=rough, span=fractions)
    last = _passage(time, progress, smooth, at=high - 1, level=fractions[1], rough=rough, span=fractions)
    noise = levels.alike / levels.change**2
    errors = [each.error(noise) for each in (first, last)]
    # an error of the level before shifts the passage at fraction c by (1 - c), one of the level after by c, over the slope
    of_before = (1 - fractions[1]) / last.slope - (1 - fractions[0]) / first.slope
    of_after = fractions[1] / last.slope - fractions[0] / first.slope
    of_levels = math.hypot(of_before * levels.before_error, of_after * levels.after_error) / abs(
        levels.change
    )
    return Passages(
        first=first.time, last=last.time, first_error=errors[0], last_error=errors[1],
        time=last.time - first.time, standard_error=math.hypot(*errors, of_levels),
        interpolated=first.interpolated or last.interpolated,
    )  # fmt: skip


def _rough(progress: Real, fractions: tuple[float, float]) -> int:
    """Count the samples between two fractions of the change, with noise about them."""
    middle = int(np.argmax(progress > 0.5))
    return int(
        np.count_nonzero(progress[:middle] > fractions[0]) + np.argmax(progress[middle:] > fractions[1])
    )


def _smoothed(progress: Real, noise: float, *, longest: int) -> Real:
    """Average over as many samples as bring white noise below 1 % of the change, but not over more than `longest`."""
    count = (min(int((noise / 0.01) ** 2), longest) - 1) // 2 * 2 + 1
    if count <= 1:
        return progress
    padded = np.pad(progress, count // 2, mode="edge")
    return np.convolve(padded, np.full(count, 1 / count), mode="valid")


@dataclass(frozen=True, kw_only=True)
class _Passage:
    """A passage, with the slope there and the weights of the samples in the fitted value."""

    time: float
    slope: float
    weights: Real
    interpolated: bool

    def error(self, alike: Real) -> float:
        """Return the standard error [s] for noise of an autocovariance."""
        from scipy.linalg import matmul_toeplitz

        size = len(self.weights)
        lags = np.pad(alike[:size], (0, max(0, size - len(alike))))
        return math.sqrt(max(float(self.weights @ matmul_toeplitz(lags, self.weights)), 0.0)) / abs(
            self.slope
        )


def _passage(
    time: Real,
    progress: Real,
    smooth: Real,
    *,
    at: int,
    level: float,
    rough: float,
    span: tuple[float, float],
) -> _Passage:
    """Refine a passage between the samples `at` and `at` + 1."""
    share = (level - smooth[at]) / (smooth[at + 1] - smooth[at])
    step = float(time[at + 1] - time[at])
    here, mean = float(time[at] + share * step), (span[1] - span[0]) / rough
    found, half = None, _REACH / mean
    for _ in range(6):
        part = np.abs(time - here) <= half
        if np.count_nonzero(part) < _FEWEST:
            found = None
            break
        basis = ((time[part] - here) / half)[:, None] ** np.arange(3)
        weights = np.linalg.pinv(basis)
        value, first, second = weights @ progress[part]
        if not first / half > _FLAT * mean:
            half *= 2
            continue
        # root of the parabola near its centre, by two Newton steps
        shift = 0.0
        for _ in range(2):
            shift -= (value + first * shift + second * shift**2 - level) / (
                first + 2 * second * shift or first
            )
        shift = min(max(shift, -1.0), 1.0)
        found = _Passage(
            time=here + shift * half, slope=float(first / half), interpolated=False,
            weights=weights[0] + shift * weights[1] + shift**2 * weights[2],
        )  # fmt: skip
        here, half = found.time, min(max(_REACH / found.slope, half / 2), 2 * half)
    if found is not None:
        return found
    # the two samples are those that pass the level, so that their own slope is too steep
    ends = max(at - 1, 0), min(at + 2, len(time) - 1)
    slope = max(float((smooth[ends[1]] - smooth[ends[0]]) / (time[ends[1]] - time[ends[0]])), _FLAT * mean)
    return _Passage(
        time=float(time[at] + share * step),
        slope=slope,
        weights=np.array([1 - share, share]),
        interpolated=True,
    )
