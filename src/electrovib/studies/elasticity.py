"""Elasticities: the relative change of one number over the relative change of a parameter, at one point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import ElectrovibError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

STEP: Final = 1e-2
"""Relative change of a parameter; the error of the difference is of the order of its fourth power."""
_WEIGHTS: Final = {1: 2 / 3, 2: -1 / 12}
"""Weights of the differences over one and over two steps on both sides, which make it of that order."""


@dataclass(frozen=True, kw_only=True)
class Elasticity:
    """Relative change of a number for a small relative change of a parameter, at one point.

    `at` is the value of the parameter in `unit`; `value` is d ln number / d ln parameter, NaN where the
    parameter or the number is 0, or the range of the parameter ends there.
    """

    path: str
    at: float
    unit: str
    value: float


def slope(quantity: Callable[[Mapping[str, float]], float], at: Mapping[str, float], path: str) -> float:
    """Return dq / d ln p of a quantity q by one parameter p, in the unit of q; NaN where it cannot be computed."""
    if at[path] == 0:
        return math.nan

    def ahead(steps: int) -> float:
        return quantity({**at, path: at[path] * math.exp(steps * STEP)})

    try:
        return sum(weight * (ahead(steps) - ahead(-steps)) for steps, weight in _WEIGHTS.items()) / STEP
    except ElectrovibError:  # the range of the parameter ends here
        return math.nan
