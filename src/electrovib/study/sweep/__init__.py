"""Sweeps: an experiment at every combination of the values of some parameters."""

from electrovib.study.sweep.ranges import parse_over
from electrovib.study.sweep.run import read_quantities, sweep

__all__ = ["parse_over", "read_quantities", "sweep"]
