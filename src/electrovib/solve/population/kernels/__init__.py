"""Arrays in, arrays out: what is computed for many fingers at once, in numpy or compiled by numba."""

from electrovib.solve.population.kernels.choice import kernel_name
from electrovib.solve.population.kernels.histogram import Histogram
from electrovib.solve.population.kernels.moments import (
    Moments,
    block_moments,
    merged,
    moments,
    square_moments_many,
)
from electrovib.solve.population.kernels.over_frequency import (
    cole_cole_over_frequency,
    mean_square_over_frequency,
    transfer_over_frequency,
)
from electrovib.solve.population.kernels.quantiles import quantiles, square_quantiles
from electrovib.solve.population.kernels.stepping import first_order_hold_many
from electrovib.solve.population.kernels.time_steps import BLOCK

__all__ = [
    "BLOCK",
    "Histogram",
    "Moments",
    "block_moments",
    "cole_cole_over_frequency",
    "first_order_hold_many",
    "kernel_name",
    "mean_square_over_frequency",
    "merged",
    "moments",
    "quantiles",
    "square_moments_many",
    "square_quantiles",
    "transfer_over_frequency",
]
