"""One step of Radau's implicit method, solved to rounding, for fixed steps and for steps that end at an event."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.nonlinear.radau import COEFFICIENTS, NODES, STAGES, WEIGHTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from electrovib.core.arrays import Real

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
        powers = place ** np.arange(1, STAGES + 1).reshape(-1, *[1] * place.ndim)
        added = np.tensordot(self.stages.T @ COEFFICIENTS.T, powers, axes=1)
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
    rate: Callable[[float, Real], Real],
    state: Real,
    *,
    start: float,
    size: float,
    scale: Real,
    halvings: int = 0,
) -> tuple[Piece, ...] | None:
    """Advance the state by one step, which is halved where Newton's iteration does not converge.

    Parameters
    ----------
    rate : callable
        Rate of change of the state, a function of time [s] and state.
    start : float
        Beginning of the step [s].
    state : ndarray, shape (states,)
        State at the beginning.
    size : float
        Length of the step [s].
    scale : ndarray, shape (states,)
        Magnitude of each state, above 0.
    halvings : int
        How often the step has been halved already.

    Returns
    -------
    pieces : tuple of Piece or None
        Successive steps; None where the iteration does not converge after all halvings.
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


def _collocate(
    rate: Callable[[float, Real], Real], start: float, state: Real, size: float, scale: Real
) -> Piece | None:
    """Solve all stages by Newton's iteration with a Jacobian that is renewed where it converges slowly."""
    times = start + size * NODES
    stages = np.zeros((STAGES, len(state)))
    at = state
    for _ in range(_MOST_RENEWALS):
        matrix = np.eye(stages.size) - size * np.kron(WEIGHTS, jacobian(rate, at, time=start, scale=scale))
        factors = factor(matrix)
        last = np.inf
        for _ in range(_MOST_ITERATIONS):
            rates = np.array([rate(time, state + stage) for time, stage in zip(times, stages, strict=True)])
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


def jacobian(rate: Callable[[float, Real], Real], state: Real, *, time: float, scale: Real) -> Real:
    """Compute the Jacobian of a rate by forward differences.

    Parameters
    ----------
    rate : callable
        Rate of change of the state, a function of time [s] and state.
    time : float
        Time [s].
    state, scale : ndarray, shape (states,)
        State at which it is evaluated, and the magnitude of each state.

    Returns
    -------
    jacobian : ndarray, shape (states, states)
        Derivative of each rate by each state, accurate to half the digits.
    """
    steps = np.sqrt(np.finfo(float).eps) * np.maximum(scale, np.abs(state))
    base = rate(time, state)
    columns = []
    for index, step in enumerate(steps.tolist()):
        moved = state.copy()
        moved[index] += step
        columns.append((rate(time, moved) - base) / (moved[index] - state[index]))
    return np.transpose(columns)


def steps_to(
    rate: Callable[[float, Real], Real], state: Real, *, start: float, size: float, scale: Real
) -> tuple[Piece, ...]:
    """Advance the state by one step, or raise an error.

    Parameters
    ----------
    rate : callable
        Rate of change of the state, a function of time [s] and state.
    start, size : float
        Beginning and length of the step [s].
    state, scale : ndarray, shape (states,)
        State at the beginning, and the magnitude of each state.

    Returns
    -------
    pieces : tuple of Piece
        The step, or its parts where it was halved.

    Raises
    ------
    ElectrovibError
        If the iteration does not converge after all halvings.
    """
    pieces = march(rate, state, start=start, size=size, scale=scale)
    if pieces is None:
        raise ElectrovibError(f"the equations could not be solved beyond {start:.6g} s")
    return pieces


def adaptive_steps(
    rate: Callable[[float, Real], Real],
    state: Real,
    *,
    start: float,
    stop: float,
    scale: Real,
    tolerance: float,
) -> Iterator[tuple[float, Real, Callable[[Real], Real]]]:
    """Yield steps whose length follows from the error: the end of each, the state there, and its polynomial.

    Parameters
    ----------
    rate : callable
        Rate of change of the state, a function of time [s] and state.
    start, stop : float
        Beginning and end [s].
    state, scale : ndarray, shape (states,)
        State at the beginning, and the magnitude of each state.
    tolerance : float
        Local error of a step: relative, and absolute against the scale.

    Yields
    ------
    tuple of (float, ndarray, callable)
        End of a step [s], state there, polynomial of times [s].

    Raises
    ------
    ElectrovibError
        If no step is small enough for the tolerance.
    """
    from scipy.integrate import Radau

    solver = Radau(
        rate,
        start,
        state,
        stop,
        rtol=tolerance,
        atol=tolerance * scale,
        jac=lambda time, now: jacobian(rate, now, time=time, scale=scale),
    )
    solver.lu, solver.solve_lu = (
        factor,
        solve,
    )  # the checks of scipy's own take several times longer than a small system
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise ElectrovibError(f"the equations could not be solved beyond {solver.t:.6g} s: {message}")
        yield float(solver.t), solver.y, solver.dense_output()


def even_steps(
    rate: Callable[[float, Real], Real], state: Real, *, start: float, stop: float, scale: Real, step: float
) -> Iterator[tuple[float, Real, Callable[[Real], Real]]]:
    """Yield steps of one length, the given one or slightly less, without control of the error.

    Parameters
    ----------
    rate : callable
        Rate of change of the state, a function of time [s] and state.
    start, stop : float
        Beginning and end [s].
    state, scale : ndarray, shape (states,)
        State at the beginning, and the magnitude of each state.
    step : float
        Largest length of a step [s].

    Yields
    ------
    tuple of (float, ndarray, callable)
        End of a step [s], state there, polynomial of times [s].
    """
    count = max(1, int(np.ceil((stop - start) / step * (1 - 1e-9))))
    bounds = np.linspace(start, stop, count + 1).tolist()
    for before, after in itertools.pairwise(bounds):
        taken = steps_to(rate, state, start=before, size=after - before, scale=scale)
        state = taken[-1].state
        for piece in taken:
            yield after if piece is taken[-1] else piece.end, piece.state, piece
