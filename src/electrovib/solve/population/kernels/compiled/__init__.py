"""Kernels compiled by numba: vectors of fingers, in tiles on several threads."""

from electrovib.solve.population.kernels.compiled.calls import (
    moments,
    name,
    square_moments,
    step,
)

__all__ = [
    "moments",
    "name",
    "square_moments",
    "step",
]
