"""Normal and log-normal distributions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.scenario.distributions.base import Distribution
from electrovib.scenario.distributions.checks import (
    bounded,
    check_increasing,
    check_kept,
    check_positive,
    log_ratio,
)

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class Normal(Distribution):
    """Normal distribution, truncated and renormalised where ends are given."""

    mean: float
    deviation: float
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        """Refuse a deviation of 0 or less, ends in the wrong order, and ends that keep next to nothing."""
        check_positive(deviation=self.deviation)
        check_increasing(low=self.low, high=self.high)
        check_kept(self._kept)

    @property
    def _kept(self) -> float:
        below, above = self._tails
        return 1 - below - above

    @property
    def _tails(self) -> tuple[float, float]:
        return self._below(self.low), self._below(2 * self.mean - self.high)

    def _below(self, value: float) -> float:
        return 0.5 * math.erfc((self.mean - value) / (self.deviation * math.sqrt(2)))

    def value(self, share: Real) -> Real:
        """Invert the cumulative distribution between the ends."""
        from scipy.special import ndtri

        found = self.mean + self.deviation * ndtri(self._tails[0] + self._kept * share)
        return np.asarray(np.clip(found, self.low, self.high))

    def share(self, value: float) -> float:
        """Evaluate the cumulative distribution between the ends."""
        return bounded((self._below(value) - self._tails[0]) / self._kept)

    def share_above(self, value: float) -> float:
        """Evaluate the complement by symmetry."""
        return bounded((self._below(2 * self.mean - value) - self._tails[1]) / self._kept)

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends, infinite unless given."""
        return self.low, self.high

    def truncated(self, low: float, high: float) -> Normal:
        """Return a normal distribution with the nearer of the ends."""
        nearer = max(low, self.low), min(high, self.high)
        return Normal(mean=self.mean, deviation=self.deviation, low=nearer[0], high=nearer[1])


@dataclass(frozen=True, kw_only=True)
class LogNormal(Distribution):
    """Log-normal distribution: two thirds of all values lie between median/factor and median times factor."""

    median: float
    factor: float

    def __post_init__(self) -> None:
        """Refuse a median of 0 or less, and a factor of 1 or less."""
        check_positive(median=self.median)
        check_increasing(one=1.0, factor=self.factor)

    def value(self, share: Real) -> Real:
        """Invert the cumulative distribution of the logarithm."""
        from scipy.special import ndtri

        return np.asarray(self.median * self.factor ** ndtri(share))

    def share(self, value: float) -> float:
        """Evaluate the cumulative distribution of the logarithm."""
        scale = math.log(self.factor) * math.sqrt(2)
        return 0.5 * math.erfc(-log_ratio(value, self.median) / scale)

    def share_above(self, value: float) -> float:
        """Evaluate the complement of the cumulative distribution of the logarithm."""
        scale = math.log(self.factor) * math.sqrt(2)
        return 0.5 * math.erfc(log_ratio(value, self.median) / scale)

    @property
    def ends(self) -> tuple[float, float]:
        """From 0 to infinity."""
        return 0.0, math.inf
