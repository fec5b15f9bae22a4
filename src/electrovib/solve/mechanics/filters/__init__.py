"""Linear filters of mechanics and sensors, with real poles and conjugate pairs."""

from electrovib.solve.mechanics.filters.declared import (
    cascade,
    first_order,
    high_pass,
    of_stages,
    relaxing,
    second_order,
)
from electrovib.solve.mechanics.filters.filter import Filter
from electrovib.solve.mechanics.filters.follow import filtered, filtered_linear

__all__ = [
    "Filter",
    "cascade",
    "filtered",
    "filtered_linear",
    "first_order",
    "high_pass",
    "of_stages",
    "relaxing",
    "second_order",
]
