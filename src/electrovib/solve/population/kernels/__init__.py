"""Arrays in, arrays out: what is computed for many fingers at once, in loops that numba compiles where it is installed."""

from electrovib.solve.population.kernels.kernel import kernel as kernel
from electrovib.solve.population.kernels.kernel import kernel_name as kernel_name
from electrovib.solve.population.kernels.percentiles import Histogram as Histogram
from electrovib.solve.population.kernels.percentiles import quantiles as quantiles
