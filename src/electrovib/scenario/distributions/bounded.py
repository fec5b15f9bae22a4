"""Distributions between two ends: uniform, log-uniform, triangular."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.scenario.distributions.base import Distribution
from electrovib.scenario.distributions.checks import bounded, check_increasing, check_positive, log_ratio

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class Uniform(Distribution):
    """Uniform distribution between two ends."""

    low: float
    high: float

    def __post_init__(self) -> None:
        check_increasing(low=self.low, high=self.high)

    def value(self, share: Real) -> Real:
        """Interpolate linearly between the ends."""
        return np.asarray(self.low + (self.high - self.low) * share)

    def share(self, value: float) -> float:
        """Invert the interpolation."""
        return bounded((value - self.low) / (self.high - self.low))

    def share_above(self, value: float) -> float:
        """Invert the interpolation from the upper end."""
        return bounded((self.high - value) / (self.high - self.low))

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends."""
        return self.low, self.high


@dataclass(frozen=True, kw_only=True)
class LogUniform(Distribution):
    """Distribution whose logarithm is uniform between two positive ends."""

    low: float
    high: float

    def __post_init__(self) -> None:
        check_positive(low=self.low)
        check_increasing(low=self.low, high=self.high)

    def value(self, share: Real) -> Real:
        """Interpolate linearly between the ends in the logarithm."""
        return np.asarray(self.low * (self.high / self.low) ** share)

    def share(self, value: float) -> float:
        """Invert the interpolation."""
        return bounded(log_ratio(value, self.low) / math.log(self.high / self.low))

    def share_above(self, value: float) -> float:
        """Invert the interpolation from the upper end."""
        return bounded(-log_ratio(value, self.high) / math.log(self.high / self.low))

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends."""
        return self.low, self.high


@dataclass(frozen=True, kw_only=True)
class Triangular(Distribution):
    """Triangular distribution: the density falls linearly from the most likely value to both ends."""

    low: float
    likely: float
    high: float

    def __post_init__(self) -> None:
        if not self.low <= self.likely <= self.high or self.low == self.high:
            raise InputError(
                f"low = {self.low:g}, likely = {self.likely:g}, high = {self.high:g}: expected them in this order"
            )

    def value(self, share: Real) -> Real:
        """Invert the two parabolas of the cumulative distribution."""
        width, rise = self.high - self.low, self.likely - self.low
        rising = self.low + np.sqrt(share * width * rise)
        falling = self.high - np.sqrt((1 - share) * width * (self.high - self.likely))
        return np.asarray(np.where(share * width < rise, rising, falling))

    def share(self, value: float) -> float:
        """Evaluate the two parabolas."""
        return self._below(value) if value <= self.likely else 1 - self._above(value)

    def share_above(self, value: float) -> float:
        """Evaluate the two parabolas from the upper end."""
        return self._above(value) if value > self.likely else 1 - self._below(value)

    def _below(self, value: float) -> float:
        if value <= self.low:
            return 0.0
        return (value - self.low) ** 2 / ((self.high - self.low) * (self.likely - self.low))

    def _above(self, value: float) -> float:
        if value >= self.high:
            return 0.0
        return (self.high - value) ** 2 / ((self.high - self.low) * (self.high - self.likely))

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends."""
        return self.low, self.high
