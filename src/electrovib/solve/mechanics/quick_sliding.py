"""Stick-slip motion of a skin with bristles, the equations of `sliding` in compiled steps of Radau's method of order 5.

Compiled functions share `given`, the constant `Given`, and `memory`, the numbers that change from step to step.
"""

from __future__ import annotations

import inspect
import zlib
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.physics.friction import bristle
from electrovib.physics.friction.bristle import strength_at_speed, yielding_rate
from electrovib.solve.mechanics import between, skin
from electrovib.solve.mechanics.between import cubic
from electrovib.solve.mechanics.skin import DEFLECTION, KINDS, OVER_PLATE, let_go, rates_of_skin
from electrovib.solve.meter import Meter
from electrovib.solve.nonlinear import integrate
from electrovib.solve.nonlinear.integrate import MOST_EVENTS, NODES, WEIGHTS
from electrovib.solve.recursion.compiling import inner, is_compiled, outer

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.friction.bristle import Bristles

DONE, UNSOLVED, CHATTERS, GOES_ON = range(4)
"""Status at the end of a call."""
NOW, STRETCH, KNOT, FILLED, WANTED, DIRECTION, SIDE, STEPS, ASKED, EVENTS, STATUS = range(11)
"""Numbers of `memory`: time [s], indices of stretch, knot and output, next step [s], mode, counts, status."""
ASKED_IN_STEP = 20  # evaluations of the rate in a usual step; more where steps are rejected
STEPS_PER_CALL = 100_000 if is_compiled() else 1_000
"""Steps in one call, some tenths of a second: between calls the run can be interrupted and reports its progress."""
_SMALLEST_STEP = 1e-15
_STAGES = 3
_COEFFICIENTS = np.linalg.inv(NODES[:, None] ** np.arange(1, _STAGES + 1))
"""Matrix from the increments of the stages to coefficients of powers of the share of a step."""
_MOST_ITERATIONS = 80
_SETTLED = 1e-3  # change over the tolerance at which Newton's iteration ends
_REAL = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
"""Real eigenvalue of the inverse of the weights (Hairer and Wanner 1996, IV.8)."""
_DIFFERENCE = np.array([-13 - 7 * 6**0.5, -13 + 7 * 6**0.5, -1.0]) / 3
"""Weights of the stages in the embedded error (ibid.)."""
_MOST_LANDINGS = 8
_CLOSED_IN = 200  # halvings of a share of a step: beyond the last bit
_ENOUGH = 1e-13
_CHECKED = np.array([0.2, 0.4, 0.6, 0.8, 1.0])


class Given(NamedTuple):
    """What is constant in a march: courses over time in stretches between the stops, friction, skin, tolerances, limits."""

    stops: Real  # (n + 1,): times at which speed, strength or contact are not smooth, with both ends [s]
    speeds: Real  # (n + 1,): of the bone at the stops, linear between them [m/s]
    touches: Real  # (n,): contact in each stretch, 1 or 0
    first: Any  # (n,): indices of the knots of the strength at the ends of each stretch
    last: Any
    knots: Real  # of the cubics of the strength: times [s], values [N], rates of change [N/s]
    values: Real
    slopes: Real
    floor: float  # strength without load or contact [N]
    law: Bristles  # with `nearest` as a force [N]
    body: tuple[float, float, float]  # as in `SlidingSkin`
    kinds: Any  # indices in `KINDS` of the events that may occur
    implicit: int  # number of states that are solved implicitly, the first ones; the others follow from them
    scale: Real  # (6,): of the states
    tolerance: float  # local error of a step over the scale of each state [1]
    turned: float  # speed beyond 0 [m/s] above which a reversal counts
    passed: float  # bristle force beyond the strength [N] above which it counts
    most_events: int  # above which the run ends
    steps_per_call: int  # steps in one call


_level_at = inner(strength_at_speed)
_deflection_rate = inner(yielding_rate)
_cubic = inner(cubic)
_rates_of_skin = inner(rates_of_skin)
_let_go = inner(let_go)


@inner
def _strength_in(time: Any, given: Any, memory: Any) -> Any:
    """Return the strength [N] at a time [s] of the stretch; `memory` stores the index of the knot before it."""
    knots, stretch = given.knots, int(memory[STRETCH])
    first, last = given.first[stretch], given.last[stretch]
    index = max(first, min(int(memory[KNOT]), last - 1))
    while index + 1 < last and knots[index + 1] <= time:
        index += 1
    while index > first and knots[index] > time:
        index -= 1
    memory[KNOT] = index
    return np.hypot(_cubic(knots, given.values, given.slopes, index, time), given.floor)


@inner
def _at(time: Any, given: Any, memory: Any) -> Any:
    """Return what the rates need at a time [s]: strength, speed of the bone, contact, direction; law and body."""
    stretch = int(memory[STRETCH])
    begin, length = given.stops[stretch], given.stops[stretch + 1] - given.stops[stretch]
    rise = given.speeds[stretch + 1] - given.speeds[stretch]
    speed = given.speeds[stretch] + rise * ((time - begin) / length)
    strength, touch = _strength_in(time, given, memory), given.touches[stretch]
    return strength, speed, touch, memory[DIRECTION], given.law, given.body


@inner
def _rates(state: Any, at: Any, rates: Any) -> Any:
    """Compute the rates of all states."""
    strength, speed, touch, direction, law, body = at
    deflection, over_plate = state[DEFLECTION], state[OVER_PLATE] if body[0] > 0 else speed
    level = _level_at(over_plate, strength, law.excess, law.stribeck_speed)
    numbers = law.stiffness, law.exponent, law.nearest / strength
    rate = touch * _deflection_rate(deflection, over_plate, level, direction, *numbers)
    held = law.stiffness * deflection
    friction = touch * (held + law.bristle_damping * rate + law.viscous_damping * over_plate)
    found = _rates_of_skin(state, rate, friction, speed, law.stiffness, body)
    rates[0], rates[1], rates[2], rates[3], rates[4], rates[5] = found


@inner
def _solve(matrix: Any, right: Any) -> Any:
    """Solve in place by Gaussian elimination with pivots, which uses up the matrix."""
    size = len(right)
    for column in range(size):
        best = column
        for row in range(column + 1, size):
            if abs(matrix[row, column]) > abs(matrix[best, column]):
                best = row
        if best != column:
            right[column], right[best] = right[best], right[column]
            for other in range(column, size):
                matrix[column, other], matrix[best, other] = matrix[best, other], matrix[column, other]
        for row in range(column + 1, size):
            factor = matrix[row, column] / matrix[column, column]
            right[row] -= factor * right[column]
            for other in range(column + 1, size):
                matrix[row, other] -= factor * matrix[column, other]
    for row in range(size - 1, -1, -1):
        for other in range(row + 1, size):
            right[row] -= matrix[row, other] * right[other]
        right[row] /= matrix[row, row]


@inner
def _jacobian(state: Any, base: Any, at: Any, scale: Any, matrix: Any) -> Any:
    """Compute the Jacobian of the implicit rates by forward differences from the rates `base`."""
    moved, count = np.empty(6), len(matrix)
    for index in range(count):
        kept = state[index]
        state[index] = kept + 1.5e-8 * max(scale[index], abs(kept))
        change = state[index] - kept
        _rates(state, at, moved)
        for row in range(count):
            matrix[row, index] = (moved[row] - base[row]) / change
        state[index] = kept


@inner
def _newton(size: Any, count: Any, stages: Any, rates: Any, slopes: Any, matrix: Any, right: Any) -> Any:
    """Compute matrix and right-hand side of one Newton iteration for all stages."""
    for stage in range(_STAGES):
        for index in range(count):
            row = stage * count + index
            right[row] = -stages[stage, index]
            for other in range(_STAGES):
                weight = size * WEIGHTS[stage, other]
                right[row] += weight * rates[other, index]
                for column in range(count):
                    matrix[row, other * count + column] = -weight * slopes[other, index, column]
            matrix[row, row] += 1.0


@inner
def _collocate(size: Any, before: Any, given: Any, memory: Any, stages: Any) -> Any:
    """Solve the stages of one step from the current time by Newton's iteration; return whether it converged."""
    count, scale, enough = given.implicit, given.scale, _SETTLED * given.tolerance
    matrix, right = np.empty((_STAGES * count, _STAGES * count)), np.empty(_STAGES * count)
    rates, slopes, state = np.empty((_STAGES, 6)), np.empty((_STAGES, count, count)), np.zeros(6)
    stages[:] = 0.0
    moved = np.inf
    for _ in range(_MOST_ITERATIONS):
        for stage in range(_STAGES):
            at = _at(memory[NOW] + size * NODES[stage], given, memory)
            for index in range(count):
                state[index] = before[index] + stages[stage, index]
            _rates(state, at, rates[stage])
            _jacobian(state, rates[stage], at, scale, slopes[stage])
        memory[ASKED] += _STAGES * (1 + count)
        if moved <= enough:
            break
        _newton(size, count, stages, rates, slopes, matrix, right)
        _solve(matrix, right)
        earlier, moved = moved, 0.0
        for row in range(len(right)):
            stage, index = row // count, row % count
            stages[stage, index] += right[row]
            moved = max(moved, abs(right[row]) / (scale[index] + abs(before[index])))
        if not moved < np.inf or moved > 2 * earlier:
            return False
    for stage in range(_STAGES):
        for row in range(3, 6):
            for other in range(_STAGES):
                stages[stage, row] += size * WEIGHTS[stage, other] * rates[other, row]
    return moved <= enough


@inner
def _state_at(share: Any, before: Any, stages: Any, state: Any) -> Any:
    """Compute the state at a share of a step, on the polynomial through its stages."""
    for row in range(6):
        state[row] = before[row]
        power = share
        for order in range(_STAGES):
            for stage in range(_STAGES):
                state[row] += stages[stage, row] * _COEFFICIENTS[order, stage] * power
            power *= share


@inner
def _error_of(size: Any, before: Any, given: Any, memory: Any, stages: Any) -> Any:
    """Return the embedded error of a step over the allowed one, filtered a second time if above 1."""
    count, rates, near = given.implicit, np.empty(6), before.copy()
    matrix, error = np.empty((count, count)), np.empty(count)
    at = _at(memory[NOW], given, memory)
    _rates(near, at, rates)
    _jacobian(near, rates, at, given.scale, matrix)
    memory[ASKED] += 3 + count
    for row in range(count):
        for column in range(count):
            matrix[row, column] = -matrix[row, column]
        matrix[row, row] += _REAL / size
    norm = 0.0
    for attempt in range(2):
        for row in range(count):
            error[row] = rates[row]
            for stage in range(_STAGES):
                error[row] += _DIFFERENCE[stage] * stages[stage, row] / size
        _solve(matrix.copy(), error)
        norm = 0.0
        for row in range(count):
            largest = max(abs(before[row]), abs(before[row] + stages[-1, row]))
            norm += (error[row] / (given.tolerance * (given.scale[row] + largest))) ** 2
        norm = np.sqrt(norm / count)
        if attempt == 1 or norm <= 1:
            break
        for row in range(count):
            near[row] += error[row]
        _rates(near, at, rates)
    return norm


@inner
def _switch(kind: Any, state: Any, strength: Any, given: Any, memory: Any) -> Any:
    """Return a quantity that is above 0 in the mode: speed along its direction, or remaining share of the strength."""
    direction = memory[DIRECTION]
    if kind == 0:
        return direction * state[OVER_PLATE] + given.turned
    left = 1 - direction * given.law.stiffness * state[DEFLECTION] / strength
    return memory[SIDE] * left + given.passed / strength


@inner
def _at_share(
    kind: Any, share: Any, size: Any, before: Any, stages: Any, given: Any, memory: Any, state: Any
) -> Any:
    """Return a switch at a share of a step, on the polynomial of the step."""
    _state_at(share, before, stages, state)
    strength = _strength_in(memory[NOW] + share * size, given, memory)
    return _switch(kind, state, strength, given, memory)


@inner
def _first_fall(size: Any, before: Any, stages: Any, given: Any, memory: Any) -> Any:
    """Return the share of a step at which a switch first falls through 0, and its kind; 2 and -1 if none does."""
    step, low = (size, before, stages, given, memory, np.empty(6)), 0.0
    best, which = 2.0, -1
    for look in _CHECKED:
        for kind in given.kinds:
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


@inner
def _land(kind: Any, size: Any, whole: Any, before: Any, stages: Any, given: Any, memory: Any) -> Any:
    """Solve a shortened step until a switch is 0 at its end; return its length, or -1."""
    state, enough = np.empty(6), _ENOUGH * given.stops[-1]
    for _ in range(_MOST_LANDINGS):
        if not _collocate(size, before, given, memory, stages):
            return -1.0
        step = (size, before, stages, given, memory, state)
        end = _at_share(kind, 1.0, *step)
        slope = (end - _at_share(kind, 0.875, *step)) / (0.125 * size)
        if end == 0 or not slope < 0:
            break
        corrected = min(size - end / slope, whole)
        if corrected <= 0 or abs(corrected - size) <= enough:
            break
        size = corrected
    return size


@inner
def _turn(kind: Any, now: Any, state: Any, strength: Any, given: Any, memory: Any, events: Any) -> Any:
    """Store an event, and change the mode after a switch has fallen through 0."""
    count, direction = int(memory[EVENTS]), memory[DIRECTION]
    events[0][count], events[1][count] = now, kind
    memory[EVENTS] = count + 1
    if kind == 1:
        memory[SIDE] = -memory[SIDE]
        return
    left = 1 + direction * given.law.stiffness * state[DEFLECTION] / strength
    memory[DIRECTION], memory[SIDE] = -direction, 1.0 if left >= 0 else -1.0


@inner
def _hold(state: Any, given: Any, memory: Any, events: Any) -> Any:
    """At the begin of a stretch release bristles off the plate, and change the mode until it is consistent."""
    if given.touches[int(memory[STRETCH])] == 0:
        _let_go(state, given.law.stiffness)
    strength = _strength_in(memory[NOW], given, memory)
    for _ in range(2):
        for kind in given.kinds:
            if _switch(kind, state, strength, given, memory) < 0:
                _turn(kind, memory[NOW], state, strength, given, memory, events)
                break


@inner
def _put_out(times: Any, reached: Any, size: Any, before: Any, stages: Any, memory: Any, out: Any) -> Any:
    """Write the states at the output times inside a step."""
    states, directions = out
    state, filled = np.empty(6), int(memory[FILLED])
    while filled < len(times) and times[filled] < reached:
        _state_at((times[filled] - memory[NOW]) / size, before, stages, state)
        for row in range(6):
            states[row, filled] = state[row]
        directions[filled] = memory[DIRECTION]
        filled += 1
    memory[FILLED] = filled


@inner
def _accepted(size: Any, state: Any, given: Any, memory: Any, stages: Any, smallest: Any) -> Any:
    """Try a step from the current time; return whether its error is allowed, and store the length of the next."""
    if not _collocate(size, state, given, memory, stages):
        memory[WANTED] = size / 2
        if size <= smallest:
            memory[STATUS] = UNSOLVED
        return False
    norm = _error_of(size, state, given, memory, stages)
    factor = min(10.0, max(0.2, 0.9 * max(norm, 1e-10) ** -0.25))
    if norm > 1 and size > smallest:
        memory[WANTED] = size * factor
        return False
    if factor < 1 or memory[WANTED] <= size:  # a step shortened at a knot does not limit the next
        memory[WANTED] = size * factor
    return True


@inner
def _step(times: Any, state: Any, given: Any, memory: Any, events: Any, out: Any) -> Any:
    """Take one step, at most to the next knot or event, or shorten the next one."""
    now, stages = memory[NOW], np.empty((_STAGES, 6))
    enough, smallest = _ENOUGH * times[-1], _SMALLEST_STEP * times[-1]
    _strength_in(now, given, memory)
    knot = given.knots[int(memory[KNOT]) + 1]  # a step ends there at the latest, so that none is missed
    size = max(memory[WANTED], smallest)
    if now + size >= knot - enough:
        size = knot - now
        if smallest >= size - enough:  # a shorter step would be set to this one again
            smallest = size
    if not _accepted(size, state, given, memory, stages, smallest):
        return
    share, kind = _first_fall(size, state, stages, given, memory)
    if kind >= 0:
        size = _land(kind, share * size, size, state, stages, given, memory)
        if size < 0:
            memory[STATUS] = UNSOLVED
            return
    reached = now + size if knot - (now + size) > enough else knot
    _put_out(times, reached, size, state, stages, memory, out)
    for row in range(6):
        state[row] += stages[-1, row]
    memory[NOW] = reached
    memory[STEPS] += 1
    if kind >= 0:
        strength = _strength_in(reached, given, memory)
        _turn(kind, reached, state, strength, given, memory, events)
    if reached >= given.stops[int(memory[STRETCH]) + 1]:
        memory[STRETCH] += 1


def _marching(stamp: int) -> Callable[..., Any]:
    """Compile the time stepping; the stamp makes numba's cache, which sees only this file, depend on all functions called."""

    def march(times: Any, state: Any, given: Any, memory: Any, events: Any, out: Any) -> Any:
        until = memory[STEPS] + given.steps_per_call + 0 * stamp
        asked = memory[ASKED] + given.steps_per_call * ASKED_IN_STEP
        memory[STATUS] = GOES_ON
        while memory[STATUS] == GOES_ON and memory[STEPS] < until and memory[ASKED] < asked:
            stretch = int(memory[STRETCH])
            if stretch == len(given.stops) - 1:
                memory[STATUS] = DONE
                break
            memory[KNOT] = max(memory[KNOT], given.first[stretch])
            if memory[NOW] == given.stops[stretch]:
                _hold(state, given, memory, events)
            _step(times, state, given, memory, events, out)
            if memory[EVENTS] >= given.most_events:
                memory[STATUS] = CHATTERS

    return outer(march)


march = _marching(zlib.crc32("".join(map(inspect.getsource, (bristle, between, skin, integrate))).encode()))
"""Take some steps from the state in `memory`; events are times [s] and kinds."""


def follow(
    times: Real, state: Real, given: Given
) -> tuple[Real, Real, list[tuple[float, str]], tuple[int, int]]:
    """Return states and directions at the output times, times [s] and kinds of events, numbers of steps and evaluations."""
    states, directions = np.empty((len(state), len(times))), np.empty(len(times))
    memory, most = np.zeros(STATUS + 1), MOST_EVENTS + 2  # two events may come with a stretch
    moments, kinds = np.empty(most), np.empty(most, np.int64)
    memory[WANTED] = 1e-3 * float(given.stops[1])
    memory[DIRECTION] = memory[SIDE] = 1.0
    memory[STATUS] = GOES_ON
    meter = Meter("a friction with bristles", end=float(times[-1]))
    while memory[STATUS] == GOES_ON:
        march(times, state, given, memory, (moments, kinds), (states, directions))
        meter.count(float(memory[NOW]))
    if memory[STATUS] == UNSOLVED:
        raise ElectrovibError(f"the equations could not be solved beyond {memory[NOW]:.6g} s")
    if memory[STATUS] == CHATTERS:
        raise ElectrovibError(
            f"more than {MOST_EVENTS} events before {memory[NOW]:.6g} s: the contact chatters"
        )
    filled, count = int(memory[FILLED]), int(memory[EVENTS])
    states[:, filled:], directions[filled:] = state[:, None], memory[DIRECTION]
    found = zip(moments[:count].tolist(), (KINDS[index] for index in kinds[:count]), strict=True)
    return states, directions, list(found), (int(memory[STEPS]), int(memory[ASKED]))
