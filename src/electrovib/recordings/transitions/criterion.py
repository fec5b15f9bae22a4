"""Choice of a form by an information criterion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, TypeVar

if TYPE_CHECKING:
    from collections.abc import Mapping

Name = TypeVar("Name")

SUPPORTED: Final = 2.0
"""Difference of the criterion up to which a form has substantial support (Burnham and Anderson 2002)."""


def chosen_form(criterion: Mapping[Name, float]) -> Name:
    """Choose the first form, from the simplest on, whose criterion is at most 2 above the lowest."""
    lowest = min(criterion.values())
    return next(
        name for name, value in criterion.items() if value <= lowest + SUPPORTED or not math.isfinite(lowest)
    )


def above_lowest(criterion: Mapping[str, float]) -> dict[str, float]:
    """Return the differences of a criterion from the lowest, dimensionless."""
    lowest = min(criterion.values())
    return {name: value - lowest if math.isfinite(lowest) else 0.0 for name, value in criterion.items()}
