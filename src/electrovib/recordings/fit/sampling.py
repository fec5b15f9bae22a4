"""How a posterior distribution is sampled: seed, length of the chains and their number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from electrovib.core.errors import InputError

FEWEST: Final = 20
"""Least length of a chain."""


@dataclass(frozen=True, kw_only=True)
class Sampling:
    """How a posterior distribution is sampled.

    Parameters
    ----------
    seed : int
        Of the random numbers, 0 or more; the same seed gives the same samples.
    steps : int
        Length of each chain, at least 20.
    walkers : int, optional
        Number of chains, even and at least twice the number of unknowns; by default four times that.
    progress : callable, optional
        Called with the steps done and all steps; sampling ends with an error when it returns True.
    """

    seed: int
    steps: int = 2000
    walkers: int | None = None
    progress: Callable[[int, int], bool | None] | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be sampled, before anything is computed."""
        if self.steps < FEWEST:
            raise InputError(f"steps = {self.steps}: expected at least {FEWEST}")
        if not 0 <= self.seed < 2**32:
            raise InputError(f"seed = {self.seed}: expected a whole number from 0 to {2**32 - 1}")
