"""Probability distributions of parameters: general, truncated, and groups of values."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


_LEAST_KEPT: Final = 1e-6
"""Smallest probability between the ends of a truncated distribution; below it rounding would be seen in its values."""


def bounded(share: float) -> float:
    """Limit a share to the interval from 0 to 1, against rounding."""
    return min(max(share, 0.0), 1.0)


def log_ratio(value: float, to: float) -> float:
    """Return the natural logarithm of a ratio, minus infinity where `value` is 0 or less."""
    if value <= 0:
        return -math.inf
    return math.log(value / to) if math.isfinite(value) else math.inf


def check_kept(kept: float) -> None:
    """Refuse ends between which next to nothing of a distribution lies."""
    if not kept > _LEAST_KEPT:
        raise InputError(
            f"the ends keep a share of {max(kept, 0.0):.2g} of the distribution; expected more of it"
        )


def check_increasing(**numbers: float) -> None:
    """Refuse the second of two named numbers unless it exceeds the first."""
    (first, low), (second, high) = numbers.items()
    if not low < high:
        raise InputError(f"{second} = {high:g}: expected more than {first} = {low:g}")


def check_positive(**numbers: float) -> None:
    """Refuse a named number of 0 or less."""
    for name, number in numbers.items():
        if not number > 0:
            raise InputError(f"{name} = {number:g}: expected more than 0")


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

    def truncated(self, low: float, high: float) -> Distribution:
        """Return the same distribution with the nearer of the ends."""
        return Truncated(distribution=self.distribution, low=max(low, self.low), high=min(high, self.high))


@dataclass(frozen=True, kw_only=True)
class Normal(Distribution):
    """Normal distribution."""

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        check_positive(deviation=self.deviation)

    def value(self, share: Real) -> Real:
        """Invert the cumulative distribution."""
        from scipy.special import ndtri

        return np.asarray(self.mean + self.deviation * ndtri(share))

    def share(self, value: float) -> float:
        """Evaluate the cumulative distribution."""
        return 0.5 * math.erfc((self.mean - value) / (self.deviation * math.sqrt(2)))

    def share_above(self, value: float) -> float:
        """Evaluate the complement by symmetry."""
        return self.share(2 * self.mean - value)


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

    def truncated(self, low: float, high: float) -> Empirical:
        """Return the measured values between the ends, the ends included."""
        check_increasing(low=low, high=high)
        kept = tuple(each for each in self.values if low <= each <= high)
        check_kept(float(len(kept)))
        return Empirical(values=kept)
