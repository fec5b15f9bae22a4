"""Kernels compiled by numba: vectors of fingers, in tiles on several threads."""

from electrovib.solve.population.kernels.compiled.calls import (
    moments,
    name,
    secular,
    square_moments,
    step,
)

__all__ = [
    "moments",
    "name",
    "secular",
    "square_moments",
    "step",
]
