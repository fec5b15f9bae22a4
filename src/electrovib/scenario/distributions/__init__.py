"""Probability distributions of parameters."""

from electrovib.scenario.distributions.base import Distribution, Truncated
from electrovib.scenario.distributions.bounded import LogUniform, Triangular, Uniform
from electrovib.scenario.distributions.measured import Empirical
from electrovib.scenario.distributions.normal import LogNormal, Normal

__all__ = [
    "Distribution",
    "Empirical",
    "LogNormal",
    "LogUniform",
    "Normal",
    "Triangular",
    "Truncated",
    "Uniform",
]
