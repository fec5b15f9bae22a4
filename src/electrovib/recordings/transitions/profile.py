"""Interval of the time of an exponential from the increase of the sum of squares."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.recordings.transitions.estimate import Interval, none
from electrovib.recordings.transitions.forms import EXPONENTIAL
from electrovib.recordings.transitions.separable import Separable, Whitening

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.recordings.fit.estimate import LeastSquaresEstimate
    from electrovib.recordings.transitions.problem import EdgeProblem


def profile_of_time(problem: EdgeProblem, estimate: LeastSquaresEstimate, error: float) -> Interval:
    """Find the times between levels with which an exponential fits as well; from 0 where an instantaneous change does."""
    from scipy.stats import t

    factor = EXPONENTIAL.time_between({"time_constant": 1.0}, problem.fractions)
    best = estimate.values["time_constant"]
    allowed = float(t.ppf(0.975, estimate.degrees_of_freedom)) ** 2 * estimate.variance
    allowed *= problem.separable(EXPONENTIAL).inflation(estimate, "start", Whitening())
    free = problem.free(EXPONENTIAL)
    lowest, highest = free["time_constant"].lower, free["time_constant"].upper
    others = {name: each for name, each in free.items() if name != "time_constant"}

    def excess(fall: float) -> float:
        part = problem.separable(EXPONENTIAL, free=others)
        fixed = Separable(
            columns=lambda at: part.columns({**at, "time_constant": fall}),
            data=part.data, free=others, names=part.names, ranges=part.ranges,
        )  # fmt: skip
        # a longer fall starts earlier by about as much
        start = {**estimate.values, "start": estimate.values["start"] + best - fall}
        return fixed.solve([start, estimate.values]).sum_of_squares - estimate.sum_of_squares - allowed

    lower = 0.0 if excess(lowest) <= 0 else _root(excess, lowest, best)
    if excess(highest) <= 0:
        return none(best * factor, "any time constant fits as well")
    upper = _root(excess, highest, best)
    return Interval(
        value=best * factor, lower=lower * factor, upper=upper * factor, standard_error=error,
        method="profile of the time constant in one edge",
    )  # fmt: skip


def _root(excess: Callable[[float], float], outside: float, inside: float) -> float:
    """Bisect between a time constant that fits worse and one that fits as well, in their logarithms."""
    for _ in range(14):
        middle = math.sqrt(outside * inside)
        if excess(middle) > 0:
            outside = middle
        else:
            inside = middle
    return math.sqrt(outside * inside)
