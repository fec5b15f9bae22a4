"""Arrays in, arrays out: what is computed for many fingers at once, in loops compiled by numba."""

from importlib.metadata import version

from electrovib.solve.population.kernels.percentiles import Histogram, quantiles
from electrovib.solve.population.kernels.stepping import TimeSteps, first_order_hold_many, time_steps

__all__ = [
    "Histogram",
    "TimeSteps",
    "first_order_hold_many",
    "kernel_name",
    "quantiles",
    "time_steps",
]


def kernel_name() -> str:
    """Return what computes populations, with the version on which the last bits of results depend."""
    return f"numba {version('numba')}"
