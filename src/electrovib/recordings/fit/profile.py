"""Intervals from the profile of the likelihood, for parameters whose symmetric interval does not hold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

_FURTHEST: Final = 1e6
"""Factor between an estimate and a value, or distance in estimates, beyond which an interval counts as open."""
_ACCURACY: Final = 1e-3
"""Accuracy of the end of an interval, relative to its distance from the estimate."""


@dataclass(frozen=True, kw_only=True)
class ProfileInterval:
    """Interval of one parameter from its profile.

    Where the data exclude no value, and `open_below` or `open_above` says so, an end is the bound of the
    parameter, or the last value for which there is a prediction. `evaluations` counts fits of the other
    parameters.
    """

    lower: float
    upper: float
    open_below: bool
    open_above: bool
    evaluations: int


def profile_interval(
    rise: Callable[[float], float],
    best: float,
    *,
    deviation: float,
    bounds: tuple[float, float],
    allowed: float,
    logarithmic: bool = False,
) -> ProfileInterval:
    """Find where the smallest sum of squares at a fixed value of one parameter has risen by an allowed amount.

    `rise` maps a value to the rise above the minimum over the variance of the residuals, infinite where no
    prediction exists; `allowed` is the quantile of chi-squared, or of F, for one parameter. The search begins
    with `deviation`, not finite or 0 where none is known, and goes outwards by factors if `logarithmic`.
    """
    count = 0

    def height(value: float) -> float:
        nonlocal count
        if value == best:
            return -math.sqrt(allowed)
        count += 1
        return math.sqrt(max(rise(value), 0.0)) - math.sqrt(allowed)

    (lower, open_below), (upper, open_above) = (
        _end(height, best, side, deviation, bounds, logarithmic=logarithmic) for side in (-1, 1)
    )
    return ProfileInterval(
        lower=lower, upper=upper, open_below=open_below, open_above=open_above, evaluations=count
    )


def _end(
    height: Callable[[float], float],
    best: float,
    side: int,
    deviation: float,
    bounds: tuple[float, float],
    *,
    logarithmic: bool,
) -> tuple[float, bool]:
    """Go outwards until the profile is above the allowed rise, then divide the last step."""
    bound = bounds[0] if side < 0 else bounds[1]
    known = math.isfinite(deviation) and deviation > 0
    step = min(2 * deviation / abs(best), 1.0) if known and best else 0.1
    by_factor = logarithmic and best > 0

    def moved(units: float) -> float:
        value = (
            best * math.exp(side * step * units)
            if by_factor
            else best + side * units * step * (abs(best) or 1)
        )
        return max(value, bound) if side < 0 else min(value, bound)

    inner, outer = 0.0, 1.0
    while (reached := height(moved(outer))) <= 0:
        if moved(outer) == bound or outer * step > (math.log(_FURTHEST) if by_factor else _FURTHEST):
            return bound, True
        inner, outer = outer, 1.6 * outer
    if not math.isfinite(reached):
        return moved(inner), True
    return moved(_crossing(lambda units: height(moved(units)), inner, outer)), False


def _crossing(height: Callable[[float], float], inner: float, outer: float) -> float:
    """Find where the profile crosses the allowed rise between two distances, in steps."""
    from scipy.optimize import brentq

    return float(brentq(height, inner, outer, xtol=_ACCURACY * outer))
