"""Probability distributions of parameters."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError


class Distribution(ABC):
    """Probability distribution of the values of a parameter, in its SI unit."""

    @abstractmethod
    def value(self, share: Real) -> Real:
        """Return quantiles.

        Parameters
        ----------
        share : ndarray, shape (n,)
            Cumulative probability, dimensionless, above 0 and below 1.

        Returns
        -------
        value : ndarray, shape (n,)
            Values that are not exceeded with this probability, in the SI unit of the parameter.
        """

    @property
    @abstractmethod
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value that can occur, in the SI unit of the parameter; infinite if unbounded."""


@dataclass(frozen=True, kw_only=True)
class Uniform(Distribution):
    """Uniform distribution between two ends."""

    low: float
    high: float

    def __post_init__(self) -> None:
        """Refuse ends in the wrong order."""
        _increasing(low=self.low, high=self.high)

    def value(self, share: Real) -> Real:
        """Interpolate linearly between the ends."""
        return np.asarray(self.low + (self.high - self.low) * share)

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
        """Refuse ends in the wrong order, or at 0."""
        _positive(low=self.low)
        _increasing(low=self.low, high=self.high)

    def value(self, share: Real) -> Real:
        """Interpolate linearly between the ends in the logarithm."""
        return np.asarray(self.low * (self.high / self.low) ** share)

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends."""
        return self.low, self.high


@dataclass(frozen=True, kw_only=True)
class Normal(Distribution):
    """Normal distribution, truncated and renormalised where ends are given."""

    mean: float
    deviation: float
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        """Refuse a deviation of 0 or less, and ends in the wrong order."""
        _positive(deviation=self.deviation)
        _increasing(low=self.low, high=self.high)

    def value(self, share: Real) -> Real:
        """Invert the cumulative distribution between the ends."""
        from scipy.special import ndtr, ndtri

        below, up_to = (ndtr((end - self.mean) / self.deviation) for end in self.ends)
        found = self.mean + self.deviation * ndtri(below + (up_to - below) * share)
        return np.asarray(np.clip(found, self.low, self.high))

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends, infinite unless given."""
        return self.low, self.high


@dataclass(frozen=True, kw_only=True)
class LogNormal(Distribution):
    """Log-normal distribution: two thirds of all values lie between median/factor and median times factor."""

    median: float
    factor: float

    def __post_init__(self) -> None:
        """Refuse a median of 0 or less, and a factor of 1 or less."""
        _positive(median=self.median)
        _increasing(one=1.0, factor=self.factor)

    def value(self, share: Real) -> Real:
        """Invert the cumulative distribution of the logarithm."""
        from scipy.special import ndtri

        return np.asarray(self.median * self.factor ** ndtri(share))

    @property
    def ends(self) -> tuple[float, float]:
        """From 0 to infinity."""
        return 0.0, math.inf


@dataclass(frozen=True, kw_only=True)
class Triangular(Distribution):
    """Triangular distribution: the density falls linearly from the most likely value to both ends."""

    low: float
    likely: float
    high: float

    def __post_init__(self) -> None:
        """Refuse numbers in the wrong order."""
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

    @property
    def ends(self) -> tuple[float, float]:
        """The two ends."""
        return self.low, self.high


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

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest measured value."""
        return min(self.values), max(self.values)


def _increasing(**numbers: float) -> None:
    (first, low), (second, high) = numbers.items()
    if not low < high:
        raise InputError(f"{second} = {high:g}: expected more than {first} = {low:g}")


def _positive(**numbers: float) -> None:
    for name, number in numbers.items():
        if not number > 0:
            raise InputError(f"{name} = {number:g}: expected more than 0")
