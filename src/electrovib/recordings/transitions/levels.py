"""Levels of a recorded signal before and after an edge, and its noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.correlated import autocovariance, line

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_CLEAR: Final = 5.0
"""Smallest change of an edge, in standard errors of its levels."""


@dataclass(frozen=True, kw_only=True)
class EdgeLevels:
    """Levels before and after an edge, with standard errors by the correlation of the samples.

    - `noise`: standard deviation of a sample before the edge.
    - `alike`: autocovariance of the noise at lags of 0 to m - 1 samples; `freedom` are the degrees of freedom
      of a variance that is computed from it.
    - `drift`: slope before the edge per second; 0 where it is not significant.
    """

    before: float
    after: float
    before_error: float
    after_error: float
    noise: float
    alike: Real
    freedom: float
    drift: float

    @property
    def change(self) -> float:
        """Level after less level before, in the unit of the signal."""
        return self.after - self.before


def levels_of(time: Real, values: Real, *, edge: float, settled: float) -> EdgeLevels:
    """Compute the levels before the time `edge` and after the time `settled`; 8 samples are needed on either side."""
    before, after = time < edge, time > settled
    if min(np.count_nonzero(before), np.count_nonzero(after)) < 8:
        raise InputError(
            f"the edge at {edge:.6g} s has {np.count_nonzero(before)} samples before it and {np.count_nonzero(after)} after its"
            " transition; 8 on each side are needed: record longer, or give before and window"
        )
    first, first_error, slope, slope_error = line(time=time[before], values=values[before])
    last, last_error, _, _ = line(time=time[after], values=values[after])
    left = values[before] - first
    alike = autocovariance(left, fitted=1)
    if not abs(last - first) > _CLEAR * math.hypot(first_error, last_error):
        raise InputError(
            f"the signal does not change at the edge at {edge:.6g} s: {last - first:.3g} with a standard error of"
            f" {math.hypot(first_error, last_error):.2g}"
        )
    return EdgeLevels(
        before=first, after=last, before_error=first_error, after_error=last_error,
        noise=float(np.std(left)), alike=alike, freedom=_freedom(alike),
        drift=slope if abs(slope) > 3 * slope_error else 0.0,
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
