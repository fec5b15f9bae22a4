"""Sensitivity of a quantity to the parameters of a space: Sobol indices and elasticities."""

from electrovib.study.sensitivity.analysis import analyse
from electrovib.study.sensitivity.result import Elasticity, InputIndices, Sensitivity

__all__ = ["Elasticity", "InputIndices", "Sensitivity", "analyse"]
