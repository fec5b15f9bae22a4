"""Radau's implicit method of order 5 (Hairer and Wanner 1996, IV.8), in even steps and in steps that follow their error.

The three stages are evaluated together, as three columns, and all derivatives of a Jacobian together: on a small system
each evaluation costs about as much as an evaluation of one state.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import ElectrovibError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from electrovib.core.arrays import Real

    Rates: TypeAlias = Callable[[Real, Real], Real]


STAGES = 3
ORDER = 2 * STAGES - 1
"""Order of convergence where the rate is smooth."""
_ROOT = np.sqrt(6.0)
NODES = np.array([(4 - _ROOT) / 10, (4 + _ROOT) / 10, 1.0])
"""Radau IIA, three stages: zeros of x^2 (x - 1)^3 differentiated twice (Hairer and Wanner 1996, IV.5)."""
WEIGHTS = np.array(
    [
        [(88 - 7 * _ROOT) / 360, (296 - 169 * _ROOT) / 1800, (-2 + 3 * _ROOT) / 225],
        [(296 + 169 * _ROOT) / 1800, (88 + 7 * _ROOT) / 360, (-2 - 3 * _ROOT) / 225],
        [(16 - _ROOT) / 36, (16 + _ROOT) / 36, 1 / 9],
    ]
)
"""Integral of each stage's polynomial from the beginning to each node, as a share of the step (the same place)."""
COEFFICIENTS = np.linalg.inv(NODES[:, None] ** np.arange(1, STAGES + 1))
"""Matrix from the increments of the stages to coefficients of powers of the share of a step."""
ERROR = np.array([-13 - 7 * _ROOT, -13 + 7 * _ROOT, -1.0]) / 3
"""Weights of the increments in the embedded error of third order (the same place, IV.8)."""
REAL_ROOT = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
"""Real eigenvalue of the inverse of `WEIGHTS`."""
RATES = np.linalg.inv(WEIGHTS)
"""Matrix from the increments of the stages to the rates at the nodes, times the step."""
_SETTLED, _ROUNDING = 1e-15, 1e-11
"""Changes of the stages over the scale of the states at which an iteration to rounding ends: at once, or once they grow."""
_MOST_ITERATIONS = 12
_MOST_RENEWALS = 3
_MOST_HALVINGS = 24
_FIRST = 0.01
"""Length of the first step that is tried, times the fastest rate: what decays below the tolerance is seen as well."""
_SHORTEST = 10
"""Length of the shortest step, in roundings of its time."""
_FEW_ITERATIONS = 6
"""Most iterations of a step whose error is controlled."""
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


@dataclass(frozen=True, kw_only=True)
class Piece:
    """Collocation polynomial of one step.

    Parameters
    ----------
    start, size : float
        Beginning and length of the step [s].
    before, stages : ndarray
        State at the beginning, shape (states,), and the increments of the three stages, shape (3, states).
    """

    start: float
    size: float
    before: Real
    stages: Real

    @property
    def end(self) -> float:
        """End of the step [s]."""
        return self.start + self.size

    @property
    def state(self) -> Real:
        """State at the end."""
        return np.asarray(self.before + self.stages[-1])

    def __call__(self, time: Real) -> Real:
        """Return the state at times [s], shape (states,) or (states, n)."""
        place = (np.asarray(time) - self.start) / self.size
        added = self.stages.T @ (COEFFICIENTS.T @ np.array([place, place**2, place**3]))
        return np.asarray(self.before.reshape(-1, *[1] * place.ndim) + added)


def factor(matrix: Any) -> tuple[Any, Any]:
    """Return the triangular factors of a small real or complex matrix."""
    from scipy.linalg.lapack import dgetrf, zgetrf

    return (zgetrf if np.iscomplexobj(matrix) else dgetrf)(matrix)[:2]  # type: ignore[no-any-return]


def solve(factors: tuple[Any, Any], right: Any) -> Any:
    """Solve with these factors for one right-hand side."""
    from scipy.linalg.lapack import dgetrs, zgetrs

    return (zgetrs if np.iscomplexobj(factors[0]) else dgetrs)(*factors, right)[0]


def march(
    rate: Rates,
    state: Real,
    *,
    start: float,
    size: float,
    scale: Real,
    halvings: int = 0,
) -> tuple[Piece, ...] | None:
    """Advance the state by one step, which is halved where Newton's iteration does not converge.

    `state` (states,), `scale` (states,).
    """
    piece = _collocate(rate, start, state, size, scale)
    if piece is not None or halvings >= _MOST_HALVINGS:
        return None if piece is None else (piece,)
    first = march(rate, state, start=start, size=size / 2, scale=scale, halvings=halvings + 1)
    if first is None:
        return None
    second = march(
        rate, first[-1].state, start=start + size / 2, size=size / 2, scale=scale, halvings=halvings + 1
    )
    return None if second is None else first + second


def _collocate(rate: Rates, start: float, state: Real, size: float, scale: Real) -> Piece | None:
    """Solve all stages by Newton's iteration with a Jacobian that is renewed where it converges slowly."""
    times = start + size * NODES
    stages = np.zeros((STAGES, len(state)))
    at = state
    for _ in range(_MOST_RENEWALS):
        matrix = np.eye(stages.size) - size * np.kron(WEIGHTS, jacobian(rate, at, time=start, scale=scale))
        factors = factor(matrix)
        last = np.inf
        for _ in range(_MOST_ITERATIONS):
            rates = rate(times, (state + stages).T).T
            change = solve(factors, (size * WEIGHTS @ rates - stages).ravel()).reshape(stages.shape)
            moved = float(np.max(np.abs(change) / (scale + np.abs(state))))
            if not np.isfinite(moved) or moved > 2 * last > _ROUNDING:
                break
            stages = stages + change
            if moved <= _SETTLED or last <= moved <= _ROUNDING:
                return Piece(start=start, size=size, before=state, stages=stages)
            last = moved
        if not np.all(np.isfinite(stages)):
            return None
        at = state + stages[0]
    return None


def jacobian(rate: Rates, state: Real, *, time: float, scale: Real) -> Real:
    """Compute the Jacobian of a rate by forward differences.

    `state`, `scale` (states,); returns `jacobian` (states, states).
    """
    steps = np.sqrt(np.finfo(float).eps) * np.maximum(scale, np.abs(state))
    moved = state[:, None] + np.diag(steps)
    found = rate(np.full(len(state) + 1, time), np.column_stack([moved, state]))
    return np.asarray((found[:, :-1] - found[:, -1:]) / (np.diag(moved) - state))


def steps_to(rate: Rates, state: Real, *, start: float, size: float, scale: Real) -> tuple[Piece, ...]:
    """Advance the state by one step, or raise an error.

    `state`, `scale` (states,).
    """
    pieces = march(rate, state, start=start, size=size, scale=scale)
    if pieces is None:
        raise ElectrovibError(f"the equations could not be solved beyond {start:.6g} s")
    return pieces


def even_steps(
    rate: Rates, state: Real, *, start: float, stop: float, scale: Real, step: float
) -> Iterator[Piece]:
    """Yield steps of one length, the given one or slightly less, without control of the error.

    `state`, `scale` (states,).
    """
    count = max(1, int(np.ceil((stop - start) / step * (1 - 1e-9))))
    bounds = np.linspace(start, stop, count + 1).tolist()
    for before, after in itertools.pairwise(bounds):
        taken = steps_to(rate, state, start=before, size=after - before, scale=scale)
        state = taken[-1].state
        yield from taken


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
            cautious = (2 * _FEW_ITERATIONS + 1) / (2 * _FEW_ITERATIONS + iterations)
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
        for count in range(1, _FEW_ITERATIONS + 1):
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
