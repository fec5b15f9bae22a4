"""Checks that distributions share."""

from __future__ import annotations

import math
from typing import Final

from electrovib.core.errors import InputError

_LEAST_KEPT: Final = 1e-6
"""Smallest probability between the ends of a truncated distribution; below it rounding would be seen in its values."""


def bounded(share: float) -> float:
    """Limit a share to the interval from 0 to 1, against rounding."""
    return min(max(share, 0.0), 1.0)


def log_ratio(value: float, to: float) -> float:
    """Return the natural logarithm of a ratio, minus infinity where `value` is 0 or less."""
    if value <= 0:
        return -math.inf
    return math.log(value / to) if math.isfinite(value) else math.inf


def check_kept(kept: float) -> None:
    """Refuse ends between which next to nothing of a distribution lies."""
    if not kept > _LEAST_KEPT:
        raise InputError(
            f"the ends keep a share of {max(kept, 0.0):.2g} of the distribution; expected more of it"
        )


def check_increasing(**numbers: float) -> None:
    """Refuse the second of two named numbers unless it exceeds the first."""
    (first, low), (second, high) = numbers.items()
    if not low < high:
        raise InputError(f"{second} = {high:g}: expected more than {first} = {low:g}")


def check_positive(**numbers: float) -> None:
    """Refuse a named number of 0 or less."""
    for name, number in numbers.items():
        if not number > 0:
            raise InputError(f"{name} = {number:g}: expected more than 0")
