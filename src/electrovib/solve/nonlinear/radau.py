"""Radau's implicit method of order 5, with steps whose length follows from their error (Hairer and Wanner 1996, IV.8).

These functions call nothing of a system but `rates`, so that they run in Python for any `System`, and compiled for skins
with bristles (`solve/mechanics/compiled.py`). The three stages are evaluated together, as three columns, and all
derivatives of a Jacobian together: on a small system each evaluation costs about as much as an evaluation of one state.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

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
INTEGRALS = np.ascontiguousarray(WEIGHTS.T)
FROM_POWERS = np.ascontiguousarray(np.linalg.inv(NODES[:, None] ** np.arange(1, STAGES + 1)).T)
"""Weights of the increments of the stages in the polynomial of a step, by power of the share of the step."""
_DIFFERENCE = np.array([[-13 - 7 * _ROOT], [-13 + 7 * _ROOT], [-1.0]]) / 3
"""Weights of the increments in the embedded error of third order (the same place, IV.8)."""
_REAL_ROOT = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
"""Real eigenvalue of the inverse of `WEIGHTS`."""
LAST_RATE = np.linalg.inv(WEIGHTS)[-1:].T.copy()
"""Weights of the increments in the rate at the end, times the step."""

GOES_ON, DONE, UNSOLVED, CHATTERS = range(4)
"""Status of an integration."""
_MOVED = float(np.sqrt(np.finfo(float).eps))
"""Difference for a derivative, over the state."""
_FIRST = 0.01
"""Length of the first step that is tried, times the fastest rate: what decays below the tolerance is seen as well."""
_SHORTEST = 10
"""Length of the shortest step, in roundings of its time."""
_ENOUGH = 0.03
"""Largest error of the iteration over that of a step."""
_MOST_ITERATIONS, _MOST_RENEWALS = 6, 3
_SETTLED, _ROUNDING = 1e-15, 1e-11
"""Corrections over the states at which an iteration to rounding ends, and below which it may end for growing again."""
_SAFETY = 0.9
_LEAST, _MOST = 0.2, 5.0
"""Least and largest ratio of successive steps."""
_WORTH = 1.2
"""Least growth of a step for which its matrices are computed again."""
_ALIKE = 1e-6
"""Relative difference of steps below which the matrices of one serve the iteration of the other."""
_LEAST_CONTRACTION, _FORGETS = 1e-16, 0.8
"""An estimate of the contraction from earlier steps counts less with each step, so that it is soon measured again."""
_SLOW = 1e-3
"""Contraction of the iteration from which on the Jacobian is renewed."""


class Piece(NamedTuple):
    """One step: its start and length [s], the state before it, and the increments of the stages, shape (states, 3)."""

    start: float
    size: float
    before: Real
    stages: Real


class Task(NamedTuple):
    """What is integrated how far.

    Parameters
    ----------
    stops, breaks : ndarray, shape (n,)
        Times at which a step ends, from 0 to the last [s], and whether a smooth interval ends there.
    times : ndarray
        Output times [s].
    scale : ndarray, shape (states,)
        Magnitude of each state.
    tolerance, step : float
        Local error over state and scale [1]; a fixed length of the steps, or 0 [s].
    """

    stops: Real
    breaks: Any
    times: Real
    scale: Real
    tolerance: float
    step: float


class Progress(NamedTuple):
    """State of an integration between two steps, changed in place: arrays, and numbers as attributes of `at`."""

    at: Any
    state: Real
    slope: Real
    stages: Real
    jacobian: Real
    inverse: Real
    filter: Real


def progress_from(state: Real) -> Progress:
    """Return the beginning of an integration at time 0."""
    count = len(state)
    numbers = dict.fromkeys(("time", "latest", "wanted", "taken", "error", "factored", "contraction"), 0.0)
    counts = dict.fromkeys(("filled", "steps", "tries", "events"), 0) | {"following": 1, "status": GOES_ON}
    flags = {"arrived": True, "restarts": False, "is_known": False}
    at = SimpleNamespace(**numbers, **counts, **flags)
    square, all_stages = (count, count), (STAGES * count, STAGES * count)
    stages, slope = np.zeros((count, STAGES)), np.zeros(count)
    return Progress(at, state.copy(), slope, stages, np.zeros(square), np.zeros(all_stages), np.zeros(square))


def product(first: Real, second: Real) -> Real:
    """Return the product of two matrices."""
    return first @ second


def added(state: Real, increments: Real) -> Real:
    """Return the states (states, n) from one state and n increments."""
    return state.reshape((-1, 1)) + increments


def put(target: Real, source: Real) -> None:
    """Write one array into another of the same shape."""
    target[...] = source


def rates(system: Any, states: Real, mode: Any, times: Real) -> Real:
    """Return the rates of change of n states (states, n) at n times [s]."""
    found: Real = system.rates(states, mode, times=times)
    return found


def states_on(piece: Piece, shares: Real) -> Real:
    """Return the states (states, n) at shares of a step (n,), on the polynomial through its stages."""
    powers = np.stack((shares, shares**2, shares**3))
    return piece.before.reshape((-1, 1)) + product(piece.stages, product(FROM_POWERS, powers))


def restart(system: Any, mode: Any, progress: Progress, task: Task) -> None:
    """Begin a smooth interval: the next step does not depend on the steps before."""
    at, state = progress.at, progress.state
    until = task.stops[at.following]
    at.latest = np.nextafter(until, at.time)
    put(progress.slope, rates(system, state.reshape((-1, 1)), mode, np.full(1, at.time)).ravel())
    put(progress.jacobian, _jacobian(system, mode, state, at.time, task.scale))
    at.is_known, at.factored, at.contraction, at.taken = True, 0.0, 1.0, 0.0
    if task.step > 0:
        at.wanted = (until - at.time) / max(1.0, np.ceil((until - at.time) / task.step * (1 - 1e-9)))
        return
    fastest = 0.0
    for row in range(len(state)):
        quickest = abs(progress.slope[row])
        for column in range(len(state)):
            quickest = max(quickest, abs(progress.jacobian[row, column]) * task.scale[column])
        fastest = max(fastest, quickest / (task.scale[row] + abs(state[row])))
    at.wanted = _FIRST / fastest if fastest > 0 else np.inf


def next_piece(system: Any, mode: Any, progress: Progress, task: Task) -> Piece:
    """Return a step whose error is allowed, at most to the next stop, and set the length of the one after it."""
    at, state = progress.at, progress.state
    stop, rejected, fresh = task.stops[at.following], False, False
    while True:
        size = min(at.wanted, stop - at.time)
        if (size <= _SHORTEST * np.spacing(at.time) and size < stop - at.time) or np.any(~np.isfinite(state)):
            at.status = UNSOLVED
            return Piece(at.time, 0.0, state, progress.stages)
        if not at.is_known:
            put(progress.jacobian, _jacobian(system, mode, state, at.time, task.scale))
            at.is_known, at.factored, at.contraction, fresh = True, 0.0, 1.0, True
        at.tries += 1
        stages, count = _stages(system, mode, progress, task, size)
        if count == 0:
            at.wanted, at.is_known = (size / 2 if fresh else at.wanted), fresh
            continue
        error = _error(system, mode, progress, task, size, stages, rejected)
        cautious = (2 * _MOST_ITERATIONS + 1) / (2 * _MOST_ITERATIONS + count)
        growth = _SAFETY * cautious * _growth(at, size, error)
        if error <= 1:
            break
        at.wanted, rejected = size * max(_LEAST, growth), True
    if count > 2 and at.contraction > _SLOW:
        at.is_known = False
    elif growth < _WORTH:
        growth = 1.0
    if task.step == 0 and (
        growth < 1 or at.wanted <= size
    ):  # a step that a stop shortens does not limit the next
        at.wanted = size * min(_MOST, growth)
    at.error = error
    end = at.time + size
    whole = stop - at.time if stop - end <= _SHORTEST * np.spacing(stop) else size
    return Piece(at.time, whole, state.copy(), stages)


def _growth(at: Any, size: float, error: float) -> float:
    """Return by which factor a step may grow, from its error and that of the step before."""
    if error == 0:
        return np.inf
    trend = 1.0 if at.taken == 0 else size / at.taken * (at.error / error) ** 0.25
    return float(min(1.0, trend) * error**-0.25)


def _stages(system: Any, mode: Any, progress: Progress, task: Task, size: float) -> tuple[Real, int]:
    """Return the increments of the stages, and the number of iterations, 0 where they do not converge."""
    at, state = progress.at, progress.state
    if task.step > 0:
        return to_rounding(system, mode, Piece(at.time, size, state, progress.stages), at.latest, task.scale)
    if abs(at.factored - size) > _ALIKE * size:
        put(progress.inverse, inverse_of_stages(progress.jacobian, size))
        put(progress.filter, inverse_of(_REAL_ROOT / size * np.eye(len(state)) - progress.jacobian))
        at.factored = size
    stages = np.zeros(progress.stages.shape)
    if at.taken > 0:
        on = Piece(at.time, at.taken, np.zeros(len(state)), progress.stages)
        stages = added(-progress.stages[:, -1], states_on(on, 1 + size / at.taken * NODES))
    weights = task.tolerance * (task.scale + np.abs(state))
    enough, contraction = (
        min(_ENOUGH, math.sqrt(task.tolerance)),
        max(at.contraction, _LEAST_CONTRACTION) ** _FORGETS,
    )
    guess = Piece(at.time, size, state, stages)
    stages, count, at.contraction = _iterated(
        system, mode, guess, at.latest, progress.inverse, weights, enough, 0.0, contraction
    )
    return stages, count


def to_rounding(system: Any, mode: Any, piece: Piece, latest: float, scale: Real) -> tuple[Real, int]:
    """Solve a step as exactly as numbers allow; return its increments and the iterations, 0 where they do not converge."""
    stages, weights, near = np.zeros(piece.stages.shape), scale + np.abs(piece.before), piece.before
    for _ in range(_MOST_RENEWALS):
        inverse = inverse_of_stages(_jacobian(system, mode, near, piece.start, scale), piece.size)
        guess = Piece(piece.start, piece.size, piece.before, stages)
        stages, count, _contraction = _iterated(
            system, mode, guess, latest, inverse, weights, _SETTLED, _ROUNDING, 1.0
        )
        if count > 0 or not np.all(np.isfinite(stages)):
            return stages, count
        near = piece.before + stages[:, 0]
    return stages, 0


def _iterated(
    system: Any,
    mode: Any,
    guess: Piece,
    latest: float,
    inverse: Real,
    weights: Real,
    enough: float,
    rounding: float,
    contraction: float,
) -> tuple[Real, int, float]:
    """Iterate the stages after Newton; return them, the iterations, 0 if they do not converge, and their contraction."""
    times, stages, last = np.minimum(guess.start + guess.size * NODES, latest), guess.stages, 0.0
    for count in range(1, (2 if rounding > 0 else 1) * _MOST_ITERATIONS + 1):
        found = rates(system, added(guess.before, stages), mode, times)
        change = correction(guess.size, found, stages, inverse)
        moved = root_mean_square(change, weights)
        if last > 0:
            contraction = moved / last
        grows = last > 0 and contraction >= 1
        if not math.isfinite(moved) or (grows and moved > rounding):
            break
        stages, last = stages + change, moved
        if grows or moved == 0 or contraction * moved < (1 - contraction) * enough:
            return stages, count, contraction
    return stages, 0, 1.0


def correction(size: float, found: Real, stages: Real, inverse: Real) -> Real:
    """Return Newton's correction of the stages from the rates at the stages."""
    missing = size * (found @ INTEGRALS) - stages
    change: Real = (inverse @ missing.ravel()).reshape(stages.shape)
    return change


def _jacobian(system: Any, mode: Any, state: Real, time: float, scale: Real) -> Real:
    """Compute the Jacobian of the rates (states, states) by forward differences."""
    size = len(state)
    states, steps = np.empty((size, size + 1)), np.empty(size)
    for column in range(size + 1):
        put(states[:, column], state)
    for index in range(size):
        states[index, index] += _MOVED * max(scale[index], abs(state[index]))
        steps[index] = states[index, index] - state[index]
    return differences(rates(system, states, mode, np.full(size + 1, time)), steps)


def differences(found: Real, steps: Real) -> Real:
    """Return the derivatives (states, states) from the rates at the moved states and, last, at the state itself."""
    slopes: Real = (found[:, :-1] - found[:, -1:]) / steps
    return slopes


def inverse_of_stages(jacobian: Real, size: float) -> Real:
    """Return the inverse of Newton's matrix of all stages (3 states, 3 states)."""
    return inverse_of(np.eye(STAGES * len(jacobian)) - size * np.kron(jacobian, WEIGHTS))


def inverse_of(matrix: Real) -> Real:
    """Return the inverse; NaN where there is none, so that no iteration with it converges."""
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=float)
    except np.linalg.LinAlgError:
        return np.full(matrix.shape, np.nan)


def _error(
    system: Any, mode: Any, progress: Progress, task: Task, size: float, stages: Real, rejected: bool
) -> float:
    """Return the local error of a step over the tolerance; 0 for steps of a fixed length."""
    if task.step > 0:
        return 0.0
    at, state = progress.at, progress.state
    largest = np.maximum(np.abs(state), np.abs(state + stages[:, -1]))
    weights, embedded = task.tolerance * (task.scale + largest), product(stages, _DIFFERENCE) / size
    error = product(progress.filter, added(progress.slope, embedded))
    if rejected and root_mean_square(error, weights) > 1:
        slope = rates(system, added(state, error), mode, np.full(1, at.time))
        error = product(progress.filter, added(slope.ravel(), embedded))
    return root_mean_square(error, weights)


def root_mean_square(values: Real, weights: Real) -> float:
    """Return the root mean square of n columns over the weights (states,)."""
    flat = (values / weights.reshape((-1, 1))).ravel()
    return math.sqrt(np.dot(flat, flat) / len(flat))
