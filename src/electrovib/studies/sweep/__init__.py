"""Sweeps: an experiment at every combination of the values of some parameters."""

from electrovib.studies.sweep.run import parse_over as parse_over
from electrovib.studies.sweep.run import read_quantities as read_quantities
from electrovib.studies.sweep.run import sweep as sweep
from electrovib.studies.sweep.run import sweep_cases as sweep_cases
from electrovib.studies.sweep.table import Case as Case
