"""Sweeps: an experiment at every combination of the values of some parameters."""

from electrovib.study.sweep.asked import read_quantities
from electrovib.study.sweep.ranges import parse_over
from electrovib.study.sweep.run import Cases, sweep, sweep_cases
from electrovib.study.sweep.table import Case

__all__ = ["Case", "Cases", "parse_over", "read_quantities", "sweep", "sweep_cases"]
