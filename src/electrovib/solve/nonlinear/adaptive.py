"""Steps of Radau's implicit method whose length follows from their error (Hairer and Wanner 1996, IV.8).

The three stages are evaluated together, as three columns, and all derivatives of a Jacobian together: on a small system
each evaluation costs about as much as an evaluation of one state.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.nonlinear.collocation import Piece, factor, jacobian, solve
from electrovib.solve.nonlinear.radau import ERROR, NODES, RATES, REAL_ROOT, STAGES, WEIGHTS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from electrovib.core.arrays import Real
    from electrovib.solve.nonlinear.collocation import Rates

_FIRST = 0.01
"""Length of the first step that is tried, times the fastest rate: what decays below the tolerance is seen as well."""
_SHORTEST = 10
"""Length of the shortest step, in roundings of its time."""
_MOST_ITERATIONS = 6
_ENOUGH = 0.03
"""Largest error of the iteration over that of a step."""
_SAFETY = 0.9
_LEAST, _MOST = 0.2, 5.0
"""Least and largest ratio of successive steps."""
_WORTH = 1.2
"""Least growth of a step for which its matrices are computed again."""
_LEAST_CONTRACTION, _FORGETS = 1e-16, 0.8
"""An estimate of the contraction from earlier steps counts less with each step, so that it is soon measured again."""
_SLOW = 1e-3
"""Contraction of the iteration from which on the Jacobian is renewed."""


def adaptive_steps(
    rate: Rates, state: Real, *, start: float, stop: float, scale: Real, tolerance: float
) -> Iterator[Piece]:
    """Yield steps whose length follows from the error.

    `state`, `scale` (states,).
    """
    steps = _Steps(rate, state, start, scale, tolerance)
    size = steps.first()
    while steps.now < stop:
        size = steps.advance(min(size, stop - steps.now), stop)
        assert steps.piece is not None
        yield steps.piece


class _Steps:
    """State, step and matrices of the method between two steps."""

    def __init__(self, rate: Rates, state: Real, start: float, scale: Real, tolerance: float) -> None:
        self.rate, self.state, self.now, self.scale, self.tolerance = rate, state, start, scale, tolerance
        self.slope = rate(np.array([start]), state[:, None])[:, 0]
        self.piece: Piece | None = None
        self.before: tuple[float, float] | None = None
        self.jacobian: Real | None = jacobian(rate, state, time=start, scale=scale)
        self.matrices: tuple[float, Any, Any] | None = None
        self.contraction = 1.0

    def first(self) -> float:
        """Return the length of the first step to try [s]."""
        assert self.jacobian is not None
        sizes = self.scale + np.abs(self.state)
        rates = np.abs(np.column_stack([self.jacobian * self.scale, self.slope])) / sizes[:, None]
        fastest = float(np.max(rates))
        return _FIRST / fastest if fastest > 0 else np.inf

    def advance(self, size: float, stop: float) -> float:
        """Take a step of this length [s] or shorter, not beyond a stop; return the length to try next [s]."""
        rejected = fresh = False
        while True:
            short = size <= _SHORTEST * np.spacing(self.now) and size < stop - self.now
            if short or not np.all(np.isfinite(self.state)):
                raise ElectrovibError(f"the equations could not be solved beyond {self.now:.6g} s")
            if self.jacobian is None:
                self.jacobian, fresh = jacobian(self.rate, self.state, time=self.now, scale=self.scale), True
                self.matrices, self.contraction = None, 1.0
            stages, iterations = self._stages(size)
            if stages is None:
                if fresh:
                    size /= 2
                else:
                    self.jacobian = None
                continue
            error = self._error(stages, size, rejected=rejected)
            cautious = (2 * _MOST_ITERATIONS + 1) / (2 * _MOST_ITERATIONS + iterations)
            growth = _SAFETY * cautious * self._growth(size, error)
            if error <= 1:
                break
            size, rejected = size * max(_LEAST, growth), True
        end = self.now + size
        end = stop if stop - end <= _SHORTEST * np.spacing(stop) else end  # no step of roundings is left
        self.piece = Piece(start=self.now, size=end - self.now, before=self.state, stages=stages)
        self.before, self.slope = (size, error), RATES[-1] @ stages / size
        self.now, self.state = end, self.piece.state
        if iterations > 2 and self.contraction > _SLOW:
            self.jacobian = None
        elif growth < _WORTH:
            return size
        return size * min(_MOST, growth)

    def _growth(self, size: float, error: float) -> float:
        """Return by which factor a step may grow, from its error and that of the step before."""
        if error == 0:
            return np.inf
        trend = 1.0 if self.before is None else size / self.before[0] * (self.before[1] / error) ** 0.25
        return float(min(1.0, trend) * error**-0.25)

    def _stages(self, size: float) -> tuple[Real | None, int]:
        """Return the increments of the stages, None if the iteration does not converge, and its length."""
        assert self.jacobian is not None
        if self.matrices is None or self.matrices[0] != size:
            one = np.eye(len(self.state))
            whole = np.eye(STAGES * len(one)) - size * np.kron(WEIGHTS, self.jacobian)
            self.matrices = (size, factor(whole), factor(REAL_ROOT / size * one - self.jacobian))
        times = self.now + size * NODES
        stages = np.zeros((STAGES, len(self.state)))
        if self.piece is not None:
            stages = self.piece(times).T - self.state
        weights, last = self.tolerance * (self.scale + np.abs(self.state)), 0.0
        enough = min(_ENOUGH, math.sqrt(self.tolerance))
        self.contraction = max(self.contraction, _LEAST_CONTRACTION) ** _FORGETS
        for count in range(1, _MOST_ITERATIONS + 1):
            rates = self.rate(times, (self.state + stages).T).T
            change = solve(self.matrices[1], (size * (WEIGHTS @ rates) - stages).ravel())
            change = change.reshape(stages.shape)
            moved = _root_mean_square(change / weights)
            if last:
                self.contraction = moved / last
            if not np.isfinite(moved) or (last and self.contraction >= 1):
                break
            stages, last = stages + change, moved
            if moved == 0 or self.contraction * moved < (1 - self.contraction) * enough:
                return stages, count
        self.contraction = 1.0
        return None, count

    def _error(self, stages: Real, size: float, *, rejected: bool) -> float:
        """Return the local error of a step over the tolerance."""
        assert self.matrices is not None
        largest = np.maximum(np.abs(self.state), np.abs(self.state + stages[-1]))
        weights, embedded = self.tolerance * (self.scale + largest), ERROR @ stages / size
        error = solve(self.matrices[2], self.slope + embedded)
        if rejected and _root_mean_square(error / weights) > 1:
            slope = self.rate(np.array([self.now]), (self.state + error)[:, None])[:, 0]
            error = solve(self.matrices[2], slope + embedded)
        return _root_mean_square(error / weights)


def _root_mean_square(values: Real) -> float:
    flat = values.ravel()
    return math.sqrt(float(flat @ flat) / len(flat))
