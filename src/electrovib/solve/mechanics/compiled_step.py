"""One compiled step of Radau's method of order 5 for a skin with bristles, its error and its events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.friction.bristle import strength_at_speed, yielding_rate

if TYPE_CHECKING:
    from collections.abc import Callable

DEFLECTION, DISPLACEMENT, OVER_PLATE, WORK, DAMPER, FRICTION = range(6)
"""Rows of a state [m], [m], [m/s], [J], [J], [J]; solved implicitly for the first, with a fingertip for the first three."""
STAGES = 3
_MOST_ITERATIONS = 80
_SETTLED = 1e-3  # change over the tolerance at which Newton's iteration ends
_CUBE = 3.0 ** (1 / 3)
_REAL = 3 + _CUBE**2 - _CUBE
"""Real eigenvalue of the inverse of the weights (Hairer and Wanner 1996, IV.8)."""
_DIFFERENCE = np.array([-13 - 7 * 6**0.5, -13 + 7 * 6**0.5, -1.0]) / 3
"""Weights of the stages in the embedded error (ibid.)."""
_MOST_LANDINGS = 8
_CLOSED_IN = 200  # halvings of a share of a step: beyond the last bit
ENOUGH = 1e-13
_LOOKS = np.array([0.2, 0.4, 0.6, 0.8, 1.0])


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that only compiled functions call; a division by 0 is infinite, as in arrays."""
    from numba import njit

    # without wrappers for Python, which take most of the compilation time
    alone: dict[str, Any] = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return njit(function, **alone)  # type: ignore[no-any-return]


def compiled_for_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls, and cache it on disk where numba finds a writable folder."""
    from numba import njit

    options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
    try:
        return njit(function, cache=True, **options)  # type: ignore[no-any-return]
    except RuntimeError:
        return njit(function, **options)  # type: ignore[no-any-return]


_level_at = compiled(strength_at_speed)
_deflection_rate = compiled(yielding_rate)


@compiled
def strength_in(course: Any, place: Any, last: Any, time: Any) -> Any:
    """Return the strength [N] at a time [s]; `place` stores the index of the interval."""
    knots, values, slopes = course.knots, course.values, course.slopes
    index = min(place[0], last - 1)
    while index + 1 < last and knots[index + 1] <= time:
        index += 1
    while index > place[1] and knots[index] > time:
        index -= 1
    place[0] = index
    length = knots[index + 1] - knots[index]
    share = (time - knots[index]) / length
    rise = values[index + 1] - values[index]
    early, late = slopes[index] * length - rise, rise - slopes[index + 1] * length
    strength = values[index] + share * (rise + (1 - share) * (early * (1 - share) + late * share))
    return np.hypot(strength, course.floor)


@compiled
def _rates(
    state: Any, strength: Any, speed: Any, touch: Any, direction: Any, law: Any, skin: Any, rates: Any
) -> Any:
    """Compute the rates of all six rows; a mass of 0 stands for a rigid finger, the law's `nearest` is a force [N]."""
    mass, stiffness, damping = skin
    deflection = state[0]
    over_plate = state[2] if mass > 0 else speed
    level = _level_at(over_plate, strength, law.excess, law.stribeck_speed)
    numbers = law.stiffness, law.exponent, law.nearest / strength
    rate = touch * _deflection_rate(deflection, over_plate, level, direction, *numbers)
    held = law.stiffness * deflection
    friction = touch * (held + law.bristle_damping * rate + law.viscous_damping * over_plate)
    relative = speed - over_plate
    hand = stiffness * state[1] + damping * relative if mass > 0 else friction
    rates[0], rates[1] = rate, relative
    rates[2] = (hand - friction) / mass if mass > 0 else 0.0
    rates[3], rates[4] = hand * speed, damping * relative * relative
    rates[5] = friction * over_plate - held * rate


@compiled
def _factor(matrix: Any, pivots: Any) -> Any:
    """Factorise a matrix in place, with pivots."""
    size = len(pivots)
    for column in range(size):
        best = column
        for row in range(column + 1, size):
            if abs(matrix[row, column]) > abs(matrix[best, column]):
                best = row
        pivots[column] = best
        if best != column:
            for other in range(size):
                matrix[column, other], matrix[best, other] = matrix[best, other], matrix[column, other]
        for row in range(column + 1, size):
            factor = matrix[row, column] / matrix[column, column]
            matrix[row, column] = factor
            for other in range(column + 1, size):
                matrix[row, other] -= factor * matrix[column, other]


@compiled
def _solve(matrix: Any, pivots: Any, right: Any) -> Any:
    """Solve in place with the factors."""
    size = len(pivots)
    for row in range(size):
        best = pivots[row]
        right[row], right[best] = right[best], right[row]
    for row in range(size):
        for other in range(row):
            right[row] -= matrix[row, other] * right[other]
    for row in range(size - 1, -1, -1):
        for other in range(row + 1, size):
            right[row] -= matrix[row, other] * right[other]
        right[row] /= matrix[row, row]


@compiled
def _jacobian(state: Any, count: Any, base: Any, given: Any, scale: Any, work: Any, matrix: Any) -> Any:
    """Compute the Jacobian of the implicit rates by forward differences."""
    for index in range(count):
        kept = state[index]
        state[index] = kept + 1.5e-8 * max(scale[index], abs(kept))
        moved = state[index] - kept
        _rates(state, *given, work)
        for row in range(count):
            matrix[row, index] = (work[row] - base[row]) / moved
        state[index] = kept


@compiled
def given_at(time: Any, course: Any, place: Any, stretch: Any, direction: Any, law: Any, skin: Any) -> Any:
    """Return the arguments of the rates at a time [s] that do not depend on the state."""
    begin, length = course.stops[stretch], course.stops[stretch + 1] - course.stops[stretch]
    rise = course.speeds[stretch + 1] - course.speeds[stretch]
    speed = course.speeds[stretch] + rise * ((time - begin) / length)
    strength = strength_in(course, place, course.last[stretch], time)
    return strength, speed, course.touches[stretch], direction, law, skin


@compiled
def _rates_of_stages(
    start: Any,
    size: Any,
    before: Any,
    count: Any,
    moment: Any,
    scale: Any,
    method: Any,
    stages: Any,
    rates: Any,
    slopes: Any,
) -> Any:
    """Compute the rates at the stages, and the Jacobians of the implicit ones."""
    state, work = np.zeros(6), np.empty(6)
    for stage in range(STAGES):
        given = given_at(start + size * method.nodes[stage], *moment)
        for index in range(count):
            state[index] = before[index] + stages[stage, index]
        _rates(state, *given, rates[stage])
        _jacobian(state, count, rates[stage], given, scale, work, slopes[stage])


@compiled
def _newton(
    size: Any, count: Any, method: Any, rates: Any, slopes: Any, stages: Any, matrix: Any, right: Any
) -> Any:
    """Compute matrix and right-hand side of one Newton iteration for all stages."""
    for stage in range(STAGES):
        for index in range(count):
            row = stage * count + index
            right[row] = -stages[stage, index]
            for other in range(STAGES):
                weight = size * method.weights[stage, other]
                right[row] += weight * rates[other, index]
                for column in range(count):
                    matrix[row, other * count + column] = -weight * slopes[other, index, column]
            matrix[row, row] += 1.0


@compiled
def _moved(count: Any, right: Any, before: Any, scale: Any, stages: Any) -> Any:
    """Correct the stages, and return the largest correction over the scale of each state."""
    moved = 0.0
    for row in range(len(right)):
        stage, index = row // count, row % count
        stages[stage, index] += right[row]
        moved = max(moved, abs(right[row]) / (scale[index] + abs(before[index])))
    return moved


@compiled
def collocate(
    start: Any, size: Any, before: Any, count: Any, moment: Any, sizes: Any, method: Any, stages: Any
) -> Any:
    """Solve the stages of one step by Newton's iteration; return whether it converged, and the number of evaluations."""
    total, asked = STAGES * count, 0
    matrix, pivots, right = np.empty((total, total)), np.empty(total, np.int64), np.empty(total)
    rates, slopes = np.empty((STAGES, 6)), np.empty((STAGES, count, count))
    for stage in range(STAGES):
        for row in range(6):
            stages[stage, row] = 0.0
    moved = np.inf
    for _ in range(_MOST_ITERATIONS):
        _rates_of_stages(start, size, before, count, moment, sizes.scale, method, stages, rates, slopes)
        asked += STAGES * (1 + count)
        if moved <= _SETTLED * sizes.tolerance:
            break
        _newton(size, count, method, rates, slopes, stages, matrix, right)
        _factor(matrix, pivots)
        _solve(matrix, pivots, right)
        earlier, moved = moved, _moved(count, right, before, sizes.scale, stages)
        if not moved < np.inf or moved > 2 * earlier:
            return False, asked
    for stage in range(STAGES):
        for row in range(3, 6):
            stages[stage, row] = 0.0
            for other in range(STAGES):
                stages[stage, row] += size * method.weights[stage, other] * rates[other, row]
    return moved <= _SETTLED * sizes.tolerance, asked


@compiled
def state_at(before: Any, stages: Any, share: Any, method: Any, state: Any) -> Any:
    """Compute the state at a share of a step, on the polynomial through its stages."""
    for row in range(6):
        state[row] = before[row]
        power = share
        for order in range(STAGES):
            for stage in range(STAGES):
                state[row] += stages[stage, row] * method.coefficients[order, stage] * power
            power *= share


@compiled
def error_of(start: Any, size: Any, before: Any, count: Any, moment: Any, sizes: Any, stages: Any) -> Any:
    """Return the embedded error of a step over the allowed one, filtered a second time if above 1, and the evaluations."""
    rates, work, near = np.empty(6), np.empty(6), before.copy()
    matrix, pivots, error = np.empty((count, count)), np.empty(count, np.int64), np.empty(count)
    given = given_at(start, *moment)
    _rates(near, *given, rates)
    _jacobian(near, count, rates, given, sizes.scale, work, matrix)
    for row in range(count):
        for column in range(count):
            matrix[row, column] = -matrix[row, column]
        matrix[row, row] += _REAL / size
    _factor(matrix, pivots)
    norm = 0.0
    for attempt in range(2):
        for row in range(count):
            error[row] = rates[row]
            for stage in range(STAGES):
                error[row] += _DIFFERENCE[stage] * stages[stage, row] / size
        _solve(matrix, pivots, error)
        norm = 0.0
        for row in range(count):
            largest = max(abs(before[row]), abs(before[row] + stages[-1, row]))
            norm += (error[row] / (sizes.tolerance * (sizes.scale[row] + largest))) ** 2
        norm = np.sqrt(norm / count)
        if attempt == 1 or norm <= 1:
            break
        for row in range(count):
            near[row] += error[row]
        _rates(near, *given, rates)
    return norm, 3 + count


@compiled
def switch(kind: Any, state: Any, strength: Any, direction: Any, side: Any, law: Any, sizes: Any) -> Any:
    """Return a quantity that is above 0 in the mode: speed along its direction, or remaining share of the strength."""
    if kind == 0:
        return direction * state[2] + sizes.turned
    return side * (1 - direction * law.stiffness * state[0] / strength) + sizes.passed / strength


@compiled
def _at_share(
    kind: Any,
    share: Any,
    start: Any,
    size: Any,
    before: Any,
    stages: Any,
    moment: Any,
    side: Any,
    sizes: Any,
    method: Any,
    state: Any,
) -> Any:
    """Return a switch at a share of a step, on the polynomial of the step."""
    course, place, stretch, direction, law, _ = moment
    state_at(before, stages, share, method, state)
    strength = strength_in(course, place, course.last[stretch], start + share * size)
    return switch(kind, state, strength, direction, side, law, sizes)


@compiled
def first_fall(
    start: Any,
    size: Any,
    before: Any,
    stages: Any,
    moment: Any,
    kinds: Any,
    side: Any,
    sizes: Any,
    method: Any,
) -> Any:
    """Return the share of a step at which a switch first falls through 0, and its kind; 2 and -1 if none does."""
    state, low = np.empty(6), 0.0
    best, which = 2.0, -1
    for look in _LOOKS:
        for kind in kinds:
            step = (start, size, before, stages, moment, side, sizes, method, state)
            if _at_share(kind, look, *step) >= 0:
                continue
            above, below = low, look
            for _ in range(_CLOSED_IN):
                middle = (above + below) / 2
                if middle in (above, below):
                    break
                if _at_share(kind, middle, *step) < 0:
                    below = middle
                else:
                    above = middle
            if below < best:
                best, which = below, kind
        if which >= 0:
            break
        low = look
    return best, which


@compiled
def land(
    kind: Any,
    start: Any,
    size: Any,
    whole: Any,
    before: Any,
    count: Any,
    moment: Any,
    side: Any,
    sizes: Any,
    method: Any,
    stages: Any,
) -> Any:
    """Solve a shortened step until a switch is 0 at its end; return its length and the number of evaluations."""
    state, asked, enough = np.empty(6), 0, ENOUGH * moment[0].stops[-1]
    for _ in range(_MOST_LANDINGS):
        converged, more = collocate(start, size, before, count, moment, sizes, method, stages)
        asked += more
        if not converged:
            return -1.0, asked
        step = (start, size, before, stages, moment, side, sizes, method, state)
        end = _at_share(kind, 1.0, *step)
        slope = (end - _at_share(kind, 0.875, *step)) / (0.125 * size)
        if end == 0 or not slope < 0:
            break
        corrected = min(size - end / slope, whole)
        if corrected <= 0 or abs(corrected - size) <= enough:
            break
        size = corrected
    return size, asked


@compiled
def turned(kind: Any, state: Any, strength: Any, direction: Any, side: Any, law: Any) -> Any:
    """Return direction and side of the mode after a switch has fallen through 0."""
    if kind == 1:
        return direction, -side
    left = 1 + direction * law.stiffness * state[0] / strength
    return -direction, 1.0 if left >= 0 else -1.0
