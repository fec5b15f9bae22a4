"""The same experiment at every combination of some parameters' values."""

from electrovib.study.sweep.ranges import parse_over
from electrovib.study.sweep.run import read_quantities, sweep

__all__ = ["parse_over", "read_quantities", "sweep"]
