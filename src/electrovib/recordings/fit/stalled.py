"""The end of a search that moves along a combination of parameters that the data do not determine."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.recordings.fit.identifiability import identifiability

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real

STEPS: Final = 50
"""Successive accepted steps whose common gain is judged; searches that converge take fewer."""
GAIN: Final = 0.01
"""Decrease of the sum of squares over these steps, in variances of a residual, below which it is none: the estimate that the
search would reach is no more likely than the present one by a factor of exp(0.005)."""


@dataclass
class Stall:
    """Judgement, at each accepted step of a search, whether further steps can change the result.

    `variance` is that of the weighted residuals; None takes their scatter at the present step.
    """

    variance: float | None
    zeros: Sequence[str] = ()
    _squares: list[float] = field(default_factory=list, init=False)

    def is_reached(self, values: Mapping[str, float], residual: Real, derivatives: Real) -> bool:
        """Record an accepted step, and state whether the search has stalled there.

        It has where the last steps together have decreased the sum of squares by less than `GAIN` variances
        while a combination of the unknowns is not determined.
        """
        squares = float(residual @ residual)
        self._squares.append(squares)
        variance = squares / max(residual.size - len(values), 1) if self.variance is None else self.variance
        if len(self._squares) <= STEPS or not np.isfinite(derivatives).all():
            return False
        if not 0 <= self._squares[-1 - STEPS] - squares < GAIN * variance:
            return False
        return bool(identifiability(derivatives / np.sqrt(variance), values, zeros=self.zeros).undetermined)


class StalledError(Exception):
    """Carries the values at which a search has stalled through the library that searches."""

    def __init__(self, values: Mapping[str, float]) -> None:
        super().__init__("the search has stalled")
        self.values = dict(values)
