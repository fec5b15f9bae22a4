"""Levels of a recorded edge and the times at which it passes fractions of its change, without any model of its form."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.interval import autocovariance, covariance, line, student, through

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_REACH: Final = 0.1
"""Fraction of the change by which the signal differs from a level within the section fitted there."""
_FLAT: Final = 0.05
"""Smallest slope at a passage over the mean slope of the edge; where it is less, a longer section is fitted."""
_SLOPE_ERROR: Final = 0.1
"""Relative standard error of the slope beyond which the section is lengthened."""
_LONGER: Final = 1.6
"""Largest factor by which it is."""
_FEWEST: Final = 5
"""Fewest samples of a section through which a parabola is fitted."""


@dataclass(frozen=True, kw_only=True)
class Passages:
    """Passages of one edge through two levels, with standard errors by the noise.

    `first` and `last` are the times at which the lower and the upper fraction of the change is reached; the
    `standard_error` of the time between them includes the uncertainty of both levels. `interpolated` says
    that a passage lies between two samples alone, because too few lie near the level; `lower` is the lower end of
    the time if the level after is that of the record.
    """

    first: float
    last: float
    time: float
    standard_error: float
    freedom: float
    interpolated: bool
    lower: float


def passages(
    time: Real, values: Real, levels: EdgeLevels, *, fractions: tuple[float, float], edge: float
) -> Passages:
    """Find when an edge passes two fractions of its change: last the lower before half of it, first the upper after it.

    Around each passage a parabola is fitted to the samples for which the signal is within 10 % of the change
    from the level, or to a section up to 1.6 times as long where the noise leaves the slope uncertain by more
    than 10 %. Squares are weighted so that they fall to 0 at both ends of the section, which otherwise would
    be selected by the noise of its outermost samples. Where fewer than five samples lie there, two
    neighbouring ones are interpolated. The standard error of a passage is that of the fitted value over the
    slope.
    """
    progress = (values - levels.before) / levels.change
    # white noise is averaged to below 1 % of the change, but not over more than an eighth of the edge
    middle = int(np.argmax(progress > 0.5))
    between = np.count_nonzero(progress[:middle] > fractions[0]) + np.argmax(progress[middle:] > fractions[1])
    count = (min(int((levels.noise / levels.change / 0.01) ** 2), int(between) // 8) - 1) // 2 * 2 + 1
    smooth = progress
    if count > 1:
        padded = np.pad(progress, count // 2, mode="edge")
        smooth = np.convolve(padded, np.full(count, 1 / count), mode="valid")
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
    noise = levels.alike / levels.change**2
    first, last = (
        _passage(time, progress, smooth, at=at, level=level, rough=rough, span=fractions, noise=noise)
        for at, level in zip((low, high - 1), fractions, strict=True)
    )
    errors = [each.error(noise) for each in (first, last)]
    # an error of the level before shifts the passage at fraction c by (1 - c), one of the level after by c, over the slope
    of_before = (1 - fractions[1]) / last.slope - (1 - fractions[0]) / first.slope
    of_after = fractions[1] / last.slope - fractions[0] / first.slope
    errors.append(of_before * levels.before_error / abs(levels.change))
    taken = last.time - first.time
    return Passages(
        first=first.time, last=last.time, time=taken, freedom=levels.freedom,
        standard_error=math.hypot(*errors, of_after * levels.after_error / abs(levels.change)),
        interpolated=first.interpolated or last.interpolated,
        lower=max(taken - student(levels.freedom) * math.hypot(*errors), 0.0),
    )  # fmt: skip


def _slope(first: float, second: float) -> float:
    """Return the slope at the centre of a section of -1 to 1, of which the parabola has the coefficients `first` and `second`.

    A third derivative y''' adds y'''/18 to `first` for squares weighted by (1 - x^2)^2. It is taken as that of an exponential,
    y''^2/y', without which the slope of a decelerating edge is too large, and the standard error of its passage too small.
    """
    return first - min((2 / 9) * second**2 / first, first / 2)


@dataclass(frozen=True, kw_only=True)
class _Passage:
    """A passage, with the slope there and the weights of the samples in the fitted value."""

    time: float
    slope: float
    weights: Real
    interpolated: bool

    def error(self, alike: Real) -> float:
        """Return the standard error [s] for noise of an autocovariance."""
        return _weighted_error(self.weights, alike) / abs(self.slope)


def _weighted_error(weights: Real, alike: Real) -> float:
    """Return the standard error of a weighted sum of samples with noise of an autocovariance."""
    return math.sqrt(max(float(through(weights, alike)), 0.0))


def _passage(
    time: Real,
    progress: Real,
    smooth: Real,
    *,
    at: int,
    level: float,
    rough: float,
    span: tuple[float, float],
    noise: Real,
) -> _Passage:
    """Refine a passage between the samples `at` and `at` + 1."""
    share = (level - smooth[at]) / (smooth[at + 1] - smooth[at])
    step = float(time[at + 1] - time[at])
    here, mean = float(time[at] + share * step), (span[1] - span[0]) / rough
    found, half = None, rough / 2
    for _ in range(6):
        part = np.abs(time - here) <= half
        if np.count_nonzero(part) < _FEWEST:
            found = None
            break
        place = (time[part] - here) / half
        taper = 1 - place**2
        weights = np.linalg.pinv(taper[:, None] * place[:, None] ** np.arange(3)) * taper
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
            time=here + shift * half, slope=_slope(float(first), float(second)) / half, interpolated=False,
            weights=weights[0] + shift * weights[1] + shift**2 * weights[2],
        )  # fmt: skip
        # the standard error of a slope falls with the power 3/2 of the length of the section
        wanted = _REACH / found.slope
        unsure = _weighted_error(weights[1], noise) / first * (half / wanted) ** 1.5
        wanted *= min(max((unsure / _SLOPE_ERROR) ** (2 / 3), 1.0), _LONGER)
        here, half = found.time, min(max(wanted, half / 2), 2 * half)
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


_ROUNDING: Final = 1e-12
"""Change before an edge over that of the edge, below which it is rounding."""
_CLEAR: Final = 5.0
"""Smallest change of an edge, in standard errors of its levels."""


@dataclass(frozen=True, kw_only=True)
class EdgeLevels:
    """Levels before and after an edge, with standard errors by the correlation of the samples.

    - `noise`: standard deviation of a sample before the edge.
    - `alike`: autocovariance of the noise at lags of 0 to m - 1 samples; `freedom` are the degrees of freedom
      of a variance that is computed from it.
    - `drift`: slope before the edge per second; 0 where it is not significant.
    - `begun`: whether the record begins within the edge, and its first sample is taken as the level before.
    """

    before: float
    after: float
    before_error: float
    after_error: float
    noise: float
    alike: Real
    freedom: float
    drift: float
    begun: bool = False

    @property
    def change(self) -> float:
        """Level after less level before, in the unit of the signal."""
        return self.after - self.before


def levels_of(time: Real, values: Real, *, edge: float, settled: float) -> EdgeLevels:
    """Compute the levels before the time `edge` and after the time `settled`; 8 samples are needed on either side."""
    before, after = time < edge, time > settled
    if min(np.count_nonzero(before), np.count_nonzero(after)) < 8:
        raise InputError(
            f"the edge has {np.count_nonzero(before)} samples before it and {np.count_nonzero(after)} after its"
            " transition; 8 on each side are needed: record longer, or give before and window"
        )
    first, first_error, slope, slope_error = line(time=time[before], values=values[before])
    last, last_error, creep, creep_error = line(time=time[after], values=values[after])
    if abs(creep) > 3 * creep_error:  # which is judged by itself: `creeps`
        beside = values[after] - last - creep * (time[after] - time[after].mean())
        last_error = _weighted_error(np.full(beside.size, 1 / beside.size), autocovariance(beside, fitted=2))
    rounding = _ROUNDING * abs(last - first) / float(np.ptp(time[before]))
    left = values[before] - first
    alike = autocovariance(left, fitted=1)
    if not abs(last - first) > _CLEAR * math.hypot(first_error, last_error):
        raise InputError(
            f"the signal does not change at the edge: {last - first:.3g} with a standard error of"
            f" {math.hypot(first_error, last_error):.2g}"
        )
    return EdgeLevels(
        before=first, after=last, before_error=first_error, after_error=last_error,
        noise=float(np.std(left)), alike=alike, freedom=_freedom(alike),
        drift=slope if abs(slope) > max(3 * slope_error, rounding) else 0.0,
    )  # fmt: skip


def levels_from_the_first(time: Real, values: Real, levels: EdgeLevels, *, edge: float) -> EdgeLevels:
    """Take the first sample of a record that begins within an edge as the level before; noise is what a line leaves."""
    before = time < edge
    mean, _, slope, _ = line(time=time[before], values=values[before])
    left = values[before] - mean - slope * (time[before] - time[before].mean())
    noise = float(np.std(left))
    return replace(
        levels, before=float(values[0]), before_error=noise, noise=noise, alike=autocovariance(left, fitted=2),
        drift=0.0, begun=True,
    )  # fmt: skip


def _freedom(alike: Real) -> float:
    """Return the degrees of freedom of the variance of a slow average of noise, from as many samples as there are lags.

    The variance s of the innovations and the coefficients a1 and a2 of the autoregression are estimates. The relative variance
    of s/(1 + a1 + a2)^2 is (2 + 8 s/((r0 + r1) (1 + a1 + a2)^2))/n to first order in 1/n, with autocovariances r.
    """
    if not alike[0] > abs(alike[1]):
        return math.inf
    both = np.linalg.solve([[alike[0], alike[1]], [alike[1], alike[0]]], -alike[1:3])
    power, gain = float(alike[0] + both @ alike[1:3]), float(1 + both.sum()) ** 2
    spread = (2 + 8 * power / float(alike[0] + alike[1]) / gain) / len(alike)
    return max(2 / spread, 1.0)


_CREEP: Final = 0.05
"""Part of the change by which a signal that has settled changes at most while the time since the edge grows by a factor of e."""
_REMAINING: Final = 0.1
"""Largest part of the change that may be left at the end of a record."""
_CERTAIN: Final = 2.0


def creeps(since: Real, progress: Real) -> bool:
    """Tell whether a progress, over times since an edge, goes on at the end by more than what is left if it settles.

    By a parabola in the logarithm of the time over the last half, because a logarithm of time is what never settles: a slope s
    and a power p of the time, by which the slope falls, leave s/p.
    """
    late = since > since[-1] / 2
    place = np.log(since[late] / since[-1])
    jacobian = np.vander(place, 3, increasing=True)
    found = np.linalg.lstsq(jacobian, progress[late], rcond=None)[0]
    alike = autocovariance(progress[late] - jacobian @ found, fitted=3)
    error = math.sqrt(max(float(covariance(jacobian=jacobian, autocovariance=alike)[1, 1]), 0.0))
    slope, falls = float(found[1]), -2 * float(found[2])
    return slope - _CERTAIN * error > _CREEP and slope**2 > _REMAINING * falls
