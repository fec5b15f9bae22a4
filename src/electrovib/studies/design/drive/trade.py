"""Compromise between a target of the force and limits that are linear in the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real

MOST_UNKNOWNS: Final = 80
"""Most values of the factor that are free; a choice."""
_LEVELS: Final = (1.0, math.sqrt(2 / 3))
"""Factors that are held from the beginning at a start of the search; the second gives the most where a charge is spent."""
_FEW_UNKNOWNS: Final = 16
"""Values of the factor up to which a search is quick, so that many of them are made."""
_PRIMES: Final = (2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0)
_EVEN: Final = 5
"""Starts that fill the range of the factor evenly."""
_AGREES: Final = 1.01
_HIGHEST: Final = 3.0
"""Largest factor [1]."""
_ITERATIONS: Final = 150
_PRECISION: Final = 1e-10


@dataclass(frozen=True, kw_only=True)
class Trade:
    """A force that is quadratic in a factor of each sample, with limits that are linear in it.

    From the factors, `knots` and `middles` give the root of the force at the samples and between them
    [N^(1/2)], and `bounded` quantities over their limits, between -1 and 1; `wanted` is the mean force over
    each interval.
    """

    knots: Real
    middles: Real
    wanted: Real
    bounded: Real

    @property
    def size(self) -> int:
        """Number of factors."""
        return int(self.knots.shape[1])

    def scale(self, factor: Real) -> float:
        """Return the largest multiple of the force of a factor that the limits allow [1]; infinite without limits."""
        reached = float(np.max(np.abs(self.bounded @ factor), initial=0.0))
        return 1 / reached**2 if reached else math.inf

    def means(self, factor: Real) -> Real:
        """Return the mean force over each interval [N] for factors at the samples [1]."""
        at, between = (self.knots @ factor) ** 2, (self.middles @ factor) ** 2
        return np.asarray((at[:-1] + 4 * between + at[1:]) / 6)

    def misfit(self, factor: Real) -> float:
        """Return the sum of squares of the departures over that of the target [1]."""
        return float(np.sum((self.means(factor) - self.wanted) ** 2) / np.sum(self.wanted**2))

    def slope(self, factor: Real) -> Real:
        """Return the derivative of `misfit` by the factors [1]."""
        at, between = self.knots @ factor, self.middles @ factor
        off = 2 * (self.means(factor) - self.wanted) / np.sum(self.wanted**2) / 6
        ends = np.append(off, 0.0) + np.append(0.0, off)
        return np.asarray(2 * ((ends * at) @ self.knots + (4 * off * between) @ self.middles))

    def reduced(self, spread: Real) -> Trade:
        """Return the same for fewer unknowns, from which `spread` (samples, unknowns) gives the factors."""
        return Trade(
            knots=self.knots @ spread,
            middles=self.middles @ spread,
            wanted=self.wanted,
            bounded=self.bounded @ spread,
        )


@dataclass(frozen=True, kw_only=True)
class BestFactor:
    """Factor of the amplitude at each sample with the smallest misfit, and how many of the searches agree on it."""

    factor: Real
    searches: int
    agreeing: int


def best_factor(trade: Trade, scale: float) -> BestFactor:
    """Return the factor of the amplitude at each sample that follows the target best within the limits.

    The misfit has local minima: parts of the target compete for the same charge and voltage. Sequential
    quadratic programming over at most 16 values of the factor therefore begins at several points, the same at
    each call: the scaled target, factors that are held from the beginning as long as the limits allow, in one
    quarter of the time or to the end, and 5 points that fill the range evenly. With more samples it is
    repeated over at most 80 values, from the first three starts and the best result for few values.
    """
    factor, misfits = _best(trade, scale, _FEW_UNKNOWNS, _further_starts)
    if len(factor) > _FEW_UNKNOWNS:
        factor, _ = _best(trade, scale, MOST_UNKNOWNS, lambda many: [_at_even_places(factor, many.size)])
    agreeing = int(np.sum(misfits <= _AGREES * np.min(misfits)))
    return BestFactor(factor=factor, searches=len(misfits), agreeing=agreeing)


def _best(trade: Trade, scale: float, most: int, further: Callable[[Trade], list[Real]]) -> tuple[Real, Real]:
    """Return the best factor that has so many free values at most, and the root misfit that each search has reached.

    Searches begin at the scaled target, at factors that are held from the beginning as long as the limits
    allow, and at further starts.
    """
    spread = _spread(trade.size, min(trade.size, most))
    few = trade.reduced(spread)
    starts = [np.full(few.size, math.sqrt(scale)), *(_held(few, level) for level in _LEVELS), *further(few)]
    found = [_searched(few, start) for start in starts]
    best = min((*found, *(_within(few, start) for start in starts)), key=few.misfit)
    return np.asarray(spread @ best), np.sqrt([few.misfit(each) for each in found])


def _at_even_places(values: Real, count: int) -> Real:
    places = np.linspace(0, len(values) - 1, count)
    return np.interp(places, np.arange(len(values)), values)


def _spread(size: int, count: int) -> Real:
    """Return the matrix from values at even places to straight lines between them, shape (size, count)."""
    places = np.linspace(0, size - 1, count)
    return np.array([np.interp(np.arange(size), places, row) for row in np.eye(count)]).T


def _within(trade: Trade, factor: Real) -> Real:
    """Return a factor scaled back into the limits."""
    return np.asarray(factor * min(1.0, math.sqrt(trade.scale(factor))))


def _searched(trade: Trade, start: Real) -> Real:
    """Return the local minimum of the misfit that a search from a start finds within the limits."""
    from scipy.optimize import minimize

    rows = np.concatenate([-trade.bounded, trade.bounded])
    rows = rows[np.any(rows != 0, axis=1)]
    found = minimize(
        trade.misfit,
        start,
        jac=trade.slope,
        method="SLSQP",
        bounds=[(0.0, _HIGHEST)] * len(start),
        constraints=[{"type": "ineq", "fun": lambda s: 1 + rows @ s, "jac": lambda _: rows}],
        options={"maxiter": _ITERATIONS, "ftol": _PRECISION},
    ).x
    return _within(trade, np.maximum(found, 0.0))


def _further_starts(trade: Trade) -> list[Real]:
    """Return factors that are held for a part of the time, and factors that fill the range evenly, within the limits."""
    count = trade.size
    share = (np.arange(count) + 0.5) / count
    parts = [(share > quarter / 4) & (share < (quarter + 1) / 4) for quarter in range(4)]
    parts += [share > 0.5, share > 0.25]
    # multiples of square roots of primes fill the range without repeating
    even = [(number * np.sqrt(_PRIMES[:count])) % 1.0 for number in range(1, _EVEN + 1)]
    return [_within(trade, np.asarray(each, dtype=float)) for each in (*parts, *even)]


def _held(trade: Trade, level: float) -> Real:
    """Return a factor that is held at a level [1] from the beginning as long as the limits allow, and is 0 after it."""
    held = level * np.tri(trade.size + 1, trade.size, -1)
    fits = np.max(np.abs(held @ trade.bounded.T), axis=1, initial=0.0) <= 1
    return np.asarray(held[np.argmin(np.append(fits, False)) - 1])
