"""Distributions of measured values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.scenario.distributions.base import Distribution
from electrovib.scenario.distributions.checks import check_increasing, check_kept

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class Empirical(Distribution):
    """Distribution of measured values, all equally likely."""

    values: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse an empty list."""
        if not self.values:
            raise InputError("values: expected at least one measured value")

    def value(self, share: Real) -> Real:
        """Return the measured value at this fraction of the sorted list."""
        ordered = np.sort(np.asarray(self.values, dtype=float))
        return np.asarray(ordered[np.minimum((share * len(ordered)).astype(int), len(ordered) - 1)])

    def share(self, value: float) -> float:
        """Count the values that do not exceed this one."""
        return sum(each <= value for each in self.values) / len(self.values)

    def share_above(self, value: float) -> float:
        """Count the values that exceed this one."""
        return sum(each > value for each in self.values) / len(self.values)

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest measured value."""
        return min(self.values), max(self.values)

    def truncated(self, low: float, high: float) -> Empirical:
        """Return the measured values between the ends, the ends included."""
        check_increasing(low=low, high=high)
        kept = tuple(each for each in self.values if low <= each <= high)
        check_kept(float(len(kept)))
        return Empirical(values=kept)
