"""Means and variances over fingers, in fixed blocks that are merged in the order of their index."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from electrovib.core.arrays import Real


@dataclass
class Sums:
    """Number, mean and sum of squared deviations of the fingers merged so far, at every sample.

    Parameters
    ----------
    count : int
        Number of fingers.
    mean : ndarray, shape (n,)
        Mean over the fingers, in the unit of the signal.
    squares : ndarray, shape (n,)
        Sum of the squared deviations from the mean, in the squared unit of the signal.

    Notes
    -----
    Merging follows T. F. Chan, G. H. Golub and R. J. LeVeque (1979): no difference of large sums is taken. The same
    blocks merged in the same order give the same bits, whatever process computed them.
    """

    count: int
    mean: Real
    squares: Real

    @classmethod
    def empty(cls, samples: int) -> Sums:
        """Return the sums over no finger."""
        return cls(0, np.zeros(samples), np.zeros(samples))

    def merge(self, other: Sums) -> None:
        """Add the fingers of another block, which follow those merged so far."""
        if not self.count:
            self.count, self.mean, self.squares = other.count, other.mean.copy(), other.squares.copy()
            return
        whole = self.count + other.count
        difference = other.mean - self.mean
        self.mean += difference * (other.count / whole)
        self.squares += other.squares + difference * difference * (self.count * (other.count / whole))
        self.count = whole

    def copy(self) -> Sums:
        """Return a copy that later merges do not change."""
        return Sums(self.count, self.mean.copy(), self.squares.copy())

    @property
    def variance(self) -> Real:
        """Variance of the population, estimated without bias: over the count less one; NaN for a single finger."""
        return self.squares / (self.count - 1) if self.count > 1 else np.full(self.squares.shape, np.nan)


@dataclass
class Counts:
    """Numbers of fingers, at every sample, that exceed thresholds or have no known value.

    Parameters
    ----------
    above : ndarray of int, shape (thresholds, n)
        Fingers whose signal exceeds the threshold at the sample.
    anywhere : ndarray of int, shape (thresholds,)
        Fingers whose signal exceeds the threshold at some sample.
    unknown : ndarray of int, shape (n,)
        Fingers whose signal is NaN at the sample.
    """

    above: np.ndarray
    anywhere: np.ndarray
    unknown: np.ndarray = field()

    @classmethod
    def of(cls, values: Real, thresholds: tuple[float, ...]) -> Counts:
        """Count the fingers of an array of shape (fingers, n)."""
        above = np.zeros((len(thresholds), values.shape[1]), np.int64)
        anywhere = np.zeros(len(thresholds), np.int64)
        for place, threshold in enumerate(thresholds):
            exceeded = values > threshold
            above[place] = exceeded.sum(axis=0)
            anywhere[place] = exceeded.any(axis=1).sum()
        return cls(above, anywhere, np.isnan(values).sum(axis=0))

    @classmethod
    def empty(cls, thresholds: int, samples: int) -> Counts:
        """Return the counts of no finger."""
        return cls(
            np.zeros((thresholds, samples), np.int64),
            np.zeros(thresholds, np.int64),
            np.zeros(samples, np.int64),
        )

    def merge(self, other: Counts) -> None:
        """Add the counts of other fingers."""
        self.above += other.above
        self.anywhere += other.anywhere
        self.unknown += other.unknown

    def copy(self) -> Counts:
        """Return a copy that later merges do not change."""
        return Counts(self.above.copy(), self.anywhere.copy(), self.unknown.copy())


def sums_of(values: Real) -> Sums:
    """Compute mean and sum of squared deviations of one block of fingers.

    Parameters
    ----------
    values : ndarray, shape (fingers, n)
        Signal of at most 1024 fingers.

    Returns
    -------
    sums : Sums
        Of these fingers.
    """
    mean = values.mean(axis=0)
    deviation = values - mean
    return Sums(len(values), mean, np.einsum("ij,ij->j", deviation, deviation))
