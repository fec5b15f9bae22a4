"""Arrays in, arrays out: what is computed for many fingers at once, in loops compiled by numba."""

from electrovib.solve.population.kernels.percentiles import Histogram, quantiles
from electrovib.solve.population.kernels.stepping import TimeSteps, first_order_hold_many, time_steps
from electrovib.solve.population.kernels.threads import kernel_name

__all__ = [
    "Histogram",
    "TimeSteps",
    "first_order_hold_many",
    "kernel_name",
    "quantiles",
    "time_steps",
]
