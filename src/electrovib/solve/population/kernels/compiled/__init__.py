"""Kernels compiled by numba: vectors of fingers, in tiles on several threads."""

from electrovib.solve.population.kernels.compiled.calls import (
    moments,
    name,
    square_moments,
    step,
)
from electrovib.solve.population.kernels.compiled.interval_calls import (
    add_counts,
    count_squares,
    square_order_statistics,
)
from electrovib.solve.population.kernels.compiled.sweeps import (
    cole_cole,
    count,
    mean_square,
    octaves,
    order_statistics,
    transfer,
)

__all__ = [
    "add_counts",
    "cole_cole",
    "count",
    "count_squares",
    "mean_square",
    "moments",
    "name",
    "octaves",
    "order_statistics",
    "square_moments",
    "square_order_statistics",
    "step",
    "transfer",
]
