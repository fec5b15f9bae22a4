"""Probability distributions of parameters."""

from electrovib.scenario.distributions.normal import (
    Distribution,
    Empirical,
    LogNormal,
    LogUniform,
    Normal,
    Triangular,
    Truncated,
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
