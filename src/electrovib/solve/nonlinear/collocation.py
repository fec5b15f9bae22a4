"""One step of Radau's implicit method, solved to rounding, for fixed steps and for steps that end at an event."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.nonlinear.radau import COEFFICIENTS, NODES, STAGES, WEIGHTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from electrovib.core.arrays import Real

    Rates: TypeAlias = Callable[[Real, Real], Real]

_SETTLED = 1e-15
_ROUNDING = 1e-11
_MOST_ITERATIONS = 12
_MOST_RENEWALS = 3
_MOST_HALVINGS = 24


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
