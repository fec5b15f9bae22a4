"""Probability distributions of parameters."""

from electrovib.scenario.distributions.base import Distribution, Truncated
from electrovib.scenario.distributions.normal import (
    Empirical,
    LogNormal,
    LogUniform,
    Normal,
    Triangular,
    Uniform,
)

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
