"""Distributions in general, and truncated ones."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.scenario.distributions.checks import bounded, check_increasing, check_kept

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


class Distribution(ABC):
    """Probability distribution of the values of a parameter, in its SI unit."""

    @abstractmethod
    def value(self, share: Real) -> Real:
        """Return the values, shape (n,), in the SI unit of the parameter at cumulative probabilities above 0 and below 1."""

    @abstractmethod
    def share(self, value: float) -> float:
        """Return the probability of values that do not exceed a given one."""

    @abstractmethod
    def share_above(self, value: float) -> float:
        """Return the probability of values that exceed a given one, without cancellation where it is small."""

    @property
    @abstractmethod
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value that can occur, in the SI unit of the parameter; infinite if unbounded."""

    def truncated(self, low: float, high: float) -> Distribution:
        """Return the distribution of the values between two ends, which may be infinite, renormalised."""
        return Truncated(distribution=self, low=low, high=high)


@dataclass(frozen=True, kw_only=True)
class Truncated(Distribution):
    """Another distribution between two ends, renormalised."""

    distribution: Distribution
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        """Refuse ends in the wrong order, and ends that keep next to nothing."""
        check_increasing(low=self.low, high=self.high)
        check_kept(self._kept)

    @property
    def _kept(self) -> float:
        return 1 - self.distribution.share(self.low) - self.distribution.share_above(self.high)

    def value(self, share: Real) -> Real:
        """Invert the cumulative distribution between the ends."""
        found = self.distribution.value(self.distribution.share(self.low) + self._kept * share)
        return np.asarray(np.clip(found, self.low, self.high))

    def share(self, value: float) -> float:
        """Evaluate the cumulative distribution between the ends."""
        return bounded((self.distribution.share(value) - self.distribution.share(self.low)) / self._kept)

    def share_above(self, value: float) -> float:
        """Evaluate the complement between the ends."""
        above = self.distribution.share_above
        return bounded((above(value) - above(self.high)) / self._kept)

    @property
    def ends(self) -> tuple[float, float]:
        """The nearer of these ends and those of the distribution."""
        low, high = self.distribution.ends
        return max(low, self.low), min(high, self.high)

    def truncated(self, low: float, high: float) -> Distribution:
        """Return the same distribution with the nearer of the ends."""
        return Truncated(distribution=self.distribution, low=max(low, self.low), high=min(high, self.high))
