"""Reduction of a spectrum of the bound permittivity to non-negative Debye terms."""

from electrovib.solve.stack.prony.fit import PronyFit as PronyFit
from electrovib.solve.stack.prony.fit import fit_debye as fit_debye
from electrovib.solve.stack.prony.fit import fit_debye_table as fit_debye_table
