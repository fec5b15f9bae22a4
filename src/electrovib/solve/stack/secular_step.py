"""The formulas of one step towards a root of a sum of poles, for arrays and for numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable


def step_with(where: Callable[..., Any]) -> Callable[..., Any]:
    """Return the formulas of one step, for arrays or numbers among which `where` chooses.

    The step goes to the zero of weight/t + level + strength/(t - pole). The pole is the other end of the bracket;
    level and strength are fitted to value and slope of the poles other than the origin. Without another end, all poles
    are on one side: then the level is kept, and the pole is fitted.
    """

    def step(
        distance: Any,
        low: Any,
        high: Any,
        weight: Any,
        level: Any,
        neighbour: Any,
        others: Any,
        steepness: Any,
        size: Any,
        turn: Any,
        tolerance: Any,
        noise: Any,
    ) -> Any:
        rest = others + level
        product = weight + distance * rest
        flat = steepness == 0
        fitted = where(flat, distance, others / where(flat, 1 + 0 * distance, steepness))
        apart = where(neighbour == 0, fitted, distance - neighbour)
        # in terms of the sums at the present distance, so that no terms cancel at the root
        linear = steepness * distance - rest - product / apart
        square = linear * linear + 4 * product * (steepness - rest / apart)
        usable = (linear > 0) & (square >= 0)
        divisor = where(usable, linear + np.sqrt(where(square > 0, square, 0 * square)), 1 + 0 * linear)
        change = 2 * product / divisor
        low, high = where(product > 0, distance, low), where(product < 0, distance, high)
        done = usable & (abs(change) <= tolerance * distance)
        done = done | (abs(product) <= noise * size) | (high - low <= noise * low)
        target = distance + change
        near = usable & (8 * abs(change) <= distance)
        # bisection replaces a large step in every third turn, and later any step in every other, to shrink the bracket
        inside = usable & (target > low) & (target < high) & (near | (turn % 3 != 2))
        inside = inside & ((turn <= 24) | (turn % 2 != 0))
        following = where(inside, target, np.sqrt(low) * np.sqrt(high))
        return where(near, target, distance), done, following, low, high

    return step
