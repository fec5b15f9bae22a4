"""Compromise between a target of the force and limits that are linear in the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

MOST_UNKNOWNS: Final = 80
"""Most values of the factor that are free; a choice."""
_LEVELS: Final = (1.0, math.sqrt(2 / 3))
"""Factors that are held from the beginning at a start of the search; the second gives the most where a charge is spent."""
_HIGHEST: Final = 3.0
"""Largest factor [1]."""
_ITERATIONS: Final = 150
_PRECISION: Final = 1e-10


@dataclass(frozen=True, kw_only=True)
class Trade:
    """A force that is quadratic in a factor of each sample, with limits that are linear in it.

    Parameters
    ----------
    knots, middles : ndarray, shape (intervals + 1, samples) and (intervals, samples)
        Root of the force at the samples and between them, from the factors [N^(1/2)].
    wanted : ndarray, shape (intervals,)
        Mean force over each interval [N].
    bounded : ndarray, shape (rows, samples)
        Quantities over their limits [1], from the factors: between -1 and 1.
    """

    knots: Real
    middles: Real
    wanted: Real
    bounded: Real

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
        """Return the same for fewer unknowns, of which the factors are linear functions.

        Parameters
        ----------
        spread : ndarray, shape (samples, unknowns)
            Matrix from the unknowns to the factors [1].

        Returns
        -------
        Trade
            Of the unknowns.
        """
        return Trade(
            knots=self.knots @ spread,
            middles=self.middles @ spread,
            wanted=self.wanted,
            bounded=self.bounded @ spread,
        )


def best_factor(trade: Trade, scale: float) -> Real:
    """Return the factor of the amplitude at each sample that follows the target best within the limits.

    Parameters
    ----------
    trade : Trade
        Target and limits, of which at least one prevents the target.
    scale : float
        Multiple of the target that is within the limits [1], below 1.

    Returns
    -------
    factor : ndarray, shape (samples,)
        Amplitude over that of the target [1], 0 or more.

    Notes
    -----
    Sequential quadratic programming (SLSQP of SciPy) over straight lines between at most 80 values of the factor. It begins
    with the scaled target and with factors that are held as long as the limits allow; the best result is scaled back by its
    rounding beyond the limits.
    """
    from scipy.optimize import minimize

    size = trade.knots.shape[1]
    count = min(size, MOST_UNKNOWNS)
    places = np.linspace(0, size - 1, count)
    spread = np.array([np.interp(np.arange(size), places, row) for row in np.eye(count)]).T
    small = trade.reduced(spread)
    rows = np.concatenate([-small.bounded, small.bounded])
    rows = rows[np.any(rows != 0, axis=1)]
    constraint = {"type": "ineq", "fun": lambda s: 1 + rows @ s, "jac": lambda _: rows}
    starts = [np.full(count, math.sqrt(scale)), *(_held(small, level) for level in _LEVELS)]
    best = min(starts, key=small.misfit)
    for start in starts:
        found = minimize(
            small.misfit,
            start,
            jac=small.slope,
            method="SLSQP",
            bounds=[(0.0, _HIGHEST)] * count,
            constraints=[constraint],
            options={"maxiter": _ITERATIONS, "ftol": _PRECISION},
        ).x
        found = np.maximum(found, 0.0)
        best = min(best, found * min(1.0, math.sqrt(small.scale(found))), key=small.misfit)
    return np.asarray(spread @ best)


def _held(trade: Trade, level: float) -> Real:
    """Return a factor that is held at a level [1] from the beginning as long as the limits allow, and is 0 after it."""
    count = trade.knots.shape[1]
    places = np.arange(count)
    fitting = 0
    for most in range(count + 1):
        if trade.scale(np.where(places < most, level, 0.0)) < 1:
            break
        fitting = most
    return np.where(places < fitting, level, 0.0)
