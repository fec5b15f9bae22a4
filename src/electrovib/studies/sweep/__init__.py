"""Sweeps: an experiment at every combination of the values of some parameters."""

from electrovib.studies.sweep.run import Cases, parse_over, read_quantities, sweep, sweep_cases
from electrovib.studies.sweep.table import Case

__all__ = ["Case", "Cases", "parse_over", "read_quantities", "sweep", "sweep_cases"]
