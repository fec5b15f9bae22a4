"""Sensitivity of a quantity to the parameters of a space: Sobol indices and elasticities."""

from electrovib.studies.sensitivity.analysis import InputIndices, Sensitivity, sensitivity

__all__ = ["InputIndices", "Sensitivity", "sensitivity"]
