"""The distinct steps of a time grid, and the weights of a relaxing mode for one step."""

from __future__ import annotations

from math import factorial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Real

BLOCK: Final = 1024
"""Fingers whose sums are formed together; blocks are merged in the order of their index."""
COMPENSATED: Final = 512
"""Steps of equal duration after which the rounding of the decay per step is compensated."""
SMALLEST: Final = 1e-200
"""Smallest scale of a state: it replaces the 0 of a mode that the drive does not excite."""
_ROUNDING: Final = 4 * float(np.finfo(float).eps)
_SERIES: Final = [1.0 / factorial(order) for order in range(2, 20)]


class TimeSteps(NamedTuple):
    """Steps of a time grid, equal ones counted once.

    Parameters
    ----------
    kind : ndarray of int, shape (n - 1,)
        Index of the duration of each step.
    duration : ndarray, shape (kinds,)
        Distinct durations, increasing [s].
    """

    kind: Indices
    duration: Real


def time_steps(time: ArrayLike) -> TimeSteps:
    """Return the distinct steps of a time grid; differences that are equal up to the rounding of the times count as one.

    `time` (n,) [s].

    The duration of a group of steps is their mean, so that rounding does not accumulate over the grid.
    """
    times = np.ascontiguousarray(time, np.float64)
    if times.ndim != 1 or not times.size:
        raise InputError(f"time has shape {times.shape}: expected one row of times, at least one.")
    steps = np.diff(times)
    if not (np.isfinite(times).all() and (steps >= 0.0).all()):
        raise InputError(
            "time has a value that is not finite or lies before the one preceding it: sort the times."
        )
    if not steps.size:
        return TimeSteps(np.zeros(0, np.intp), np.zeros(0))
    distinct, kind, counts = np.unique(steps, return_inverse=True, return_counts=True)
    slack = _ROUNDING * float(np.max(np.abs(times)))
    group, first = np.zeros(distinct.size, np.intp), distinct[0]
    for place in np.flatnonzero(np.diff(distinct, prepend=distinct[0]) > 0).tolist():
        new = distinct[place] - first > slack or (first == 0.0)
        group[place] = group[place - 1] + new
        first = distinct[place] if new else first
    total = np.bincount(group, distinct * counts) / np.bincount(group, counts)
    return TimeSteps(group[kind.reshape(-1)].astype(np.intp), total)


class StepWeights(NamedTuple):
    """Weights that advance ``s' = -rate s + residue v`` exactly by one step of a straight drive.

    Parameters
    ----------
    decay : ndarray, shape of the rates
        Factor of the state [-].
    earlier, later : ndarray, shape of the rates
        Weight of the drive at the beginning and at the end of the step, over the residue [s].
    """

    decay: Real
    earlier: Real
    later: Real


def step_weights(rates: Real, duration: float) -> StepWeights:
    """Return the weights of one step for relaxing modes.

    With u = rate h and q = 1/2! + u/3! + u^2/4! + ...::      decay = exp(-u),  mean = (1 - exp(-u))/u,
    earlier = h (mean - exp(-u))/u = h exp(-u) q  and later = h mean - earlier. For u < 1 they follow from the
    series q, whose terms are all positive, since exp(u) = 1 + u + u^2 q and mean = (1 + u q) exp(-u); no
    difference cancels. A rate of 0 integrates the drive by the trapezoidal rule.
    """
    u = np.asarray(rates, np.float64) * duration
    small = np.minimum(u, 1.0)
    series = np.full_like(small, _SERIES[-1])
    for term in _SERIES[-2::-1]:
        series = series * small + term
    near = 1.0 / (1.0 + small * (1.0 + small * series))
    far, large = np.exp(-u), np.maximum(u, 1.0)
    is_small = u < 1.0
    decay = np.where(is_small, near, far)
    mean = np.where(is_small, (1.0 + small * series) * near, (1.0 - far) / large)
    earlier = np.where(is_small, near * series, (mean - far) / large)
    return StepWeights(decay, duration * earlier, duration * (mean - earlier))


def decay_correction(rates: Real, duration: float, decay: Real) -> Real:
    """Return the exact decay over `COMPENSATED` steps divided by that of as many rounded factors.

    A slow mode would lose digits by the rounding of its decay, of which the state takes the power of the
    number of steps: after 1e6 steps up to 1e-10.
    """
    u = np.asarray(rates, np.float64) * duration
    slow = u < 0.1
    excess = np.where(slow, u + np.log1p(np.where(slow, decay - 1.0, 0.0)), 0.0)
    return np.asarray(np.exp(-COMPENSATED * excess))
