"""The values at which a parameter is tried first, in its natural scale."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

PER_DECADE: Final = 4
"""Values in a decade of a range that spans decades."""
EVEN: Final = 25
"""Values of a range that does not."""
_DECADES: Final = 10.0
"""Ratio of the ends of a range from which on it counts as spanning decades."""
_BELOW: Final = 1e-4
"""Smallest value beside zero over the value in the scenario."""
_SMALLEST: Final = 1e-9
"""Smallest value beside zero over the largest value."""


def first_values(low: float, high: float, begin: float, *, sparse: bool = False) -> Real:
    """Return the increasing values of a parameter at which a quantity is computed first, `begin` among them.

    They are evenly spaced in the logarithm where the range spans a decade, else evenly spaced. A range with
    zero has the value zero and both scales on either side of it, down to 1e-4 of `begin`, or 1e-9 of the
    larger end where that is greater.
    """
    if low >= 0:
        found = _side(low, high, begin, sparse)
    elif high <= 0:
        found = -_side(-high, -low, -begin, sparse)[::-1]
    else:
        found = np.concatenate([-_side(0.0, -low, -begin, sparse)[::-1], _side(0.0, high, begin, sparse)])
    inside = [begin] if low < begin < high else []
    values = np.unique(np.concatenate([found, inside]))
    values[0], values[-1] = low, high
    return np.asarray(values)


def _side(low: float, high: float, begin: float, sparse: bool) -> Real:
    """Return values from `low` >= 0 to `high` > 0."""
    each = 2 if sparse else 1
    even = np.linspace(low, high, 1 + (EVEN - 1) // each)
    if low > 0 and high / low < _DECADES:
        return even
    start = low
    if low == 0:
        size = abs(begin)
        start = max(_SMALLEST * high, _BELOW * size) if 0 < size < high else 1e-6 * high
    count = max(len(even), 1 + math.ceil(PER_DECADE / each * math.log10(high / start)))
    spread = np.geomspace(start, high, count)
    return spread if low > 0 else np.concatenate([[0.0], spread])


def coordinate(first: float, second: float) -> bool:
    """Return whether the logarithm is the natural coordinate between two values: both have the same sign, none is zero."""
    return first * second > 0
