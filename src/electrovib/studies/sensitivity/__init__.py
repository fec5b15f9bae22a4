"""Sensitivity of a quantity to the parameters of a space: Sobol indices and elasticities."""

from electrovib.studies.sensitivity.analysis import sensitivity
from electrovib.studies.sensitivity.result import InputIndices, Sensitivity

__all__ = ["InputIndices", "Sensitivity", "sensitivity"]
