"""Arrays in, arrays out: what is computed for many fingers at once, in loops compiled by numba."""

from importlib.metadata import version

from electrovib.solve.population.kernels.percentiles import Histogram as Histogram
from electrovib.solve.population.kernels.percentiles import quantiles as quantiles
from electrovib.solve.population.kernels.stepping import TimeSteps as TimeSteps
from electrovib.solve.population.kernels.stepping import first_order_hold_many as first_order_hold_many
from electrovib.solve.population.kernels.stepping import time_steps as time_steps


def kernel_name() -> str:
    """Return what computes populations, with the version on which the last bits of results depend."""
    return f"numba {version('numba')}"
