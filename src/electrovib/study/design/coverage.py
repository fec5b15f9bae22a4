"""Share of a sample that fulfils a condition, as a function of one variable, with confidence intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

CONFIDENCE: Final = 0.95
"""Of every interval."""
ROUNDED: Final = 1e-9
"""Part of one member of the sample that counts as rounding."""


@dataclass(frozen=True)
class Covered:
    """Values of a variable at which each member of a sample fulfils a condition: closed intervals.

    `starts`, `ends` and `members`, shape (intervals,), give their ends and the member to which each belongs;
    those of one member are disjoint. `count` includes members without an interval.
    """

    starts: Real
    ends: Real
    members: NDArray[np.intp]
    count: int

    def number_at(self, at: float) -> int:
        """Return how many members fulfil the condition at a value of the variable."""
        return int(np.count_nonzero((self.starts <= at) & (at <= self.ends)))

    def steps(self) -> tuple[Real, Real, NDArray[np.intp]]:
        """Return the pieces on which the same members fulfil the condition: starts, ends and numbers of members."""
        edges = np.unique(np.concatenate([self.starts, self.ends]))
        if not len(edges):
            return np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.intp)
        begun = np.searchsorted(np.sort(self.starts), edges, side="right")
        finished = np.searchsorted(np.sort(self.ends), edges, side="left")
        after = begun - np.searchsorted(np.sort(self.ends), edges, side="right")
        starts = np.concatenate([edges, edges[:-1]])
        ends = np.concatenate([edges, edges[1:]])
        numbers = np.concatenate([begun - finished, after[:-1]])
        order = np.lexsort((ends, starts))
        return starts[order], ends[order], numbers[order]

    def where(self, least: int) -> list[tuple[float, float]]:
        """Return the intervals of the variable on which at least so many members fulfil the condition."""
        starts, ends, numbers = self.steps()
        found: list[tuple[float, float]] = []
        for start, end, number in zip(starts.tolist(), ends.tolist(), numbers.tolist(), strict=True):
            if number < least:
                continue
            if found and start <= found[-1][1]:
                found[-1] = found[-1][0], max(found[-1][1], end)
            else:
                found.append((start, end))
        return found

    def best(self) -> tuple[float, int]:
        """Return the value at which the most members fulfil the condition, NaN without any interval, and their number."""
        starts, ends, numbers = self.steps()
        if not len(numbers):
            return math.nan, 0
        most = int(np.max(numbers))
        places = np.flatnonzero(numbers == most)
        place = places[int(np.argmax(ends[places] - starts[places]))]
        low, high = float(starts[place]), float(ends[place])
        return (math.sqrt(low * high) if low > 0 else (low + high) / 2), most

    def resampled(self, chosen: NDArray[np.intp]) -> Covered:
        """Return the intervals of a sample drawn from this one with replacement, whose members are `chosen` (count,)."""
        times = np.bincount(chosen, minlength=self.count)[self.members]
        return Covered(
            np.repeat(self.starts, times),
            np.repeat(self.ends, times),
            np.repeat(self.members, times),
            len(chosen),
        )


def needed(share: float, count: int) -> int:
    """Return the smallest number of members that is at least a share of them, one at least."""
    return max(1, math.ceil(share * count - ROUNDED))


def clopper_pearson(number: int, count: int) -> tuple[float, float]:
    """Return the exact 95 % confidence interval of a probability, from quantiles of the beta distribution."""
    from scipy.stats import beta

    tail = (1 - CONFIDENCE) / 2
    low = 0.0 if number == 0 else float(beta.ppf(tail, number, count - number + 1))
    high = 1.0 if number == count else float(beta.ppf(1 - tail, number + 1, count - number))
    return low, high


def quantile_ranks(share: float, count: int) -> tuple[int, int]:
    """Return the ranks of the order statistics between which a quantile lies with a probability of at least 95 %.

    They are 0 and count + 1 where the sample is too small. The number of members below the quantile is
    binomial, whatever the distribution; the probability is exact for a continuous one.
    """
    from scipy.stats import binom

    tail = (1 - CONFIDENCE) / 2
    return int(binom.ppf(tail, count, share)), int(binom.ppf(1 - tail, count, share)) + 1
