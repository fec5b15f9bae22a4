"""Stick-slip motion for bristle laws of a known formula: the equations of `sliding` in compiled steps."""

from __future__ import annotations

import inspect
import zlib
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.physics.friction import bristle
from electrovib.solve.mechanics import compiled_step
from electrovib.solve.mechanics.compiled_step import (
    DEFLECTION,
    DISPLACEMENT,
    ENOUGH,
    FRICTION,
    OVER_PLATE,
    STAGES,
    collocate,
    compiled,
    compiled_for_python,
    error_of,
    first_fall,
    land,
    state_at,
    strength_in,
    switch,
    turned,
)
from electrovib.solve.mechanics.skin import lifted, skin_of
from electrovib.solve.mechanics.sliding import DEAD_BAND, KINDS, SMALLEST, TOLERANCE, Slide, not_negative
from electrovib.solve.meter import Meter
from electrovib.solve.nonlinear.integrate import COEFFICIENTS, MOST_EVENTS, NODES, WEIGHTS

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.friction import BristleFriction
    from electrovib.physics.motion import Motion
    from electrovib.solve.mechanics.between import Between
    from electrovib.solve.mechanics.skin import SlidingSkin

DONE, UNSOLVED, CHATTERS, GOES_ON = range(4)
"""Status at the end of a call."""
NOW, STRETCH, FILLED, WANTED, DIRECTION, SIDE, STEPS, ASKED, EVENTS, STATUS = range(10)
"""State carried from one call to the next: time [s], indices of stretch and output, next step [s], mode, counts."""
ASKED_IN_STEP = 20  # evaluations of the rate in a usual step; more where steps are rejected
_SMALLEST_STEP = 1e-15
_SOURCES = "".join(map(inspect.getsource, (bristle, compiled_step)))
AT_ONCE = 100_000
"""Steps in one call, some tenths of a second: between calls the run can be interrupted and reports its progress."""
STILL = 1e-12
"""Speed against the direction of the mode, over the largest, above which it is a reversal rather than rounding."""


class RadauNumbers(NamedTuple):
    """Coefficients of Radau's method: nodes, weights, and the polynomial through the stages."""

    nodes: Real
    weights: Real
    coefficients: Real


class GivenOverTime(NamedTuple):
    """Speed, contact and strength over time, in stretches between the stops.

    Parameters
    ----------
    stops : ndarray, shape (n + 1,)
        Times at which speed, strength or contact are not smooth, with both ends [s].
    speeds, touches : ndarray, shape (n + 1,), (n,)
        Speed of the bone at the stops, linear between them [m/s]; contact in each stretch, 1 or 0.
    first, last : ndarray of int, shape (n,)
        Indices of the knots of the strength at the ends of each stretch.
    knots, values, slopes : ndarray
        Cubics of the strength: times [s], values [N], rates of change [N/s].
    floor : float
        Strength without load or contact [N].
    """

    stops: Real
    speeds: Real
    touches: Real
    first: Any
    last: Any
    knots: Real
    values: Real
    slopes: Real
    floor: float


class Sizes(NamedTuple):
    """Tolerances and limits.

    Parameters
    ----------
    tolerance : float
        Local error of a step over the scale of each state [1].
    scale : ndarray, shape (3,)
        Scales of the states [m], [m], [m/s].
    turned, passed : float
        Speed beyond 0 [m/s], and bristle force beyond the strength [N], above which an event counts.
    most_events : int
        Number of events above which the run ends.
    at_once : int
        Number of steps in one call.
    """

    tolerance: float
    scale: Real
    turned: float
    passed: float
    most_events: int
    at_once: int


@compiled
def _note(when: Any, kind: Any, memory: Any, events: Any) -> Any:
    """Store an event."""
    count = int(memory[EVENTS])
    events[0][count], events[1][count] = when, kind
    memory[EVENTS] = count + 1


@compiled
def _hold(state: Any, moment: Any, now: Any, kinds: Any, memory: Any, sizes: Any, events: Any) -> Any:
    """At the begin of a stretch release bristles off the plate, and change the mode until it is consistent."""
    course, place, stretch, direction, law, _ = moment
    if course.touches[stretch] == 0:
        state[FRICTION] += law.stiffness * state[DEFLECTION] ** 2 / 2
        state[DEFLECTION] = 0.0
    side = memory[SIDE]
    strength = strength_in(course, place, course.last[stretch], now)
    for _ in range(2):
        for kind in kinds:
            if switch(kind, state, strength, direction, side, law, sizes) < 0:
                _note(now, kind, memory, events)
                direction, side = turned(kind, state, strength, direction, side, law)
                break
    memory[DIRECTION], memory[SIDE] = direction, side


@compiled
def _put_out(
    times: Any,
    reached: Any,
    now: Any,
    size: Any,
    before: Any,
    stages: Any,
    method: Any,
    memory: Any,
    states: Any,
    directions: Any,
) -> Any:
    """Write the states at the output times inside a step."""
    state, filled = np.empty(6), int(memory[FILLED])
    while filled < len(times) and times[filled] < reached:
        state_at(before, stages, (times[filled] - now) / size, method, state)
        for row in range(6):
            states[row, filled] = state[row]
        directions[filled] = memory[DIRECTION]
        filled += 1
    memory[FILLED] = filled


@compiled
def _accepted(
    size: Any,
    state: Any,
    moment: Any,
    count: Any,
    sizes: Any,
    method: Any,
    memory: Any,
    stages: Any,
    smallest: Any,
) -> Any:
    """Try a step from the current time; return whether its error is allowed, and store the length of the next."""
    now = memory[NOW]
    converged, asked = collocate(now, size, state, count, moment, sizes, method, stages)
    memory[ASKED] += asked
    if not converged:
        memory[WANTED] = size / 2
        if size <= smallest:
            memory[STATUS] = UNSOLVED
        return False
    norm, asked = error_of(now, size, state, count, moment, sizes, stages)
    memory[ASKED] += asked
    factor = min(10.0, max(0.2, 0.9 * max(norm, 1e-10) ** -0.25))
    if norm > 1 and size > smallest:
        memory[WANTED] = size * factor
        return False
    if factor < 1 or memory[WANTED] <= size:  # a step shortened at a knot does not limit the next
        memory[WANTED] = size * factor
    return True


@compiled
def _step(
    times: Any,
    state: Any,
    course: Any,
    law: Any,
    skin: Any,
    kinds: Any,
    sizes: Any,
    method: Any,
    memory: Any,
    place: Any,
    events: Any,
    out: Any,
) -> Any:
    """Take one step, at most to the next knot or event, or shorten the next one."""
    now, stretch, side = memory[NOW], int(memory[STRETCH]), memory[SIDE]
    moment = (course, place, stretch, memory[DIRECTION], law, skin)
    count, enough, smallest = 3 if skin[0] > 0 else 1, ENOUGH * times[-1], _SMALLEST_STEP * times[-1]
    stages = np.empty((STAGES, 6))
    strength_in(course, place, course.last[stretch], now)
    knot = course.knots[place[0] + 1]  # a step ends at the next knot at the latest, so that none is missed
    size = max(memory[WANTED], smallest)
    if now + size >= knot - enough:
        size = knot - now
        if smallest >= size - enough:  # a shorter step would be set to this one again
            smallest = size
    if not _accepted(size, state, moment, count, sizes, method, memory, stages, smallest):
        return
    share, kind = first_fall(now, size, state, stages, moment, kinds, side, sizes, method)
    if kind >= 0:
        landing = (now, share * size, size, state, count, moment, side, sizes, method, stages)
        size, asked = land(kind, *landing)
        memory[ASKED] += asked
        if size < 0:
            memory[STATUS] = UNSOLVED
            return
    reached = now + size if knot - (now + size) > enough else knot
    _put_out(times, reached, now, size, state, stages, method, memory, *out)
    for row in range(6):
        state[row] += stages[-1, row]
    memory[NOW] = reached
    memory[STEPS] += 1
    if kind >= 0:
        _note(reached, kind, memory, events)
        strength = strength_in(course, place, course.last[stretch], reached)
        memory[DIRECTION], memory[SIDE] = turned(kind, state, strength, moment[3], side, law)
    if reached >= course.stops[stretch + 1]:
        memory[STRETCH] += 1


def _marching(stamp: int) -> Callable[..., Any]:
    """Compile the time stepping; the stamp makes numba's cache, which sees only this file, depend on all functions called."""

    @compiled_for_python
    def march(
        times: Any,
        state: Any,
        course: Any,
        law: Any,
        skin: Any,
        kinds: Any,
        sizes: Any,
        method: Any,
        memory: Any,
        events: Any,
        out: Any,
    ) -> Any:
        place, until = np.zeros(2, np.int64), memory[STEPS] + sizes.at_once + 0 * stamp
        asked = memory[ASKED] + sizes.at_once * ASKED_IN_STEP
        memory[STATUS] = GOES_ON
        while memory[STATUS] == GOES_ON and memory[STEPS] < until and memory[ASKED] < asked:
            stretch = int(memory[STRETCH])
            if stretch == len(course.stops) - 1:
                memory[STATUS] = DONE
                break
            place[1] = course.first[stretch]
            place[0] = max(place[0], place[1])
            if memory[NOW] == course.stops[stretch]:
                moment = (course, place, stretch, memory[DIRECTION], law, skin)
                _hold(state, moment, memory[NOW], kinds, memory, sizes, events)
            _step(times, state, course, law, skin, kinds, sizes, method, memory, place, events, out)
            if memory[EVENTS] >= sizes.most_events:
                memory[STATUS] = CHATTERS

    return march


march = _marching(zlib.crc32(_SOURCES.encode()))
"""Take some steps from the state in `memory`; events are times [s] and kinds."""


def slide_quickly(
    law: BristleFriction,
    *,
    motion: Motion,
    strength: Between,
    times: Real,
    mass: float | None = None,
    stiffness: float | None = None,
    damping: float | None = None,
    tolerance: float = TOLERANCE,
) -> Slide:
    """Compute the stick-slip motion of a skin with bristle friction, as `sliding` does, in compiled steps.

    `times` (n,) [s].
    """
    pieces = strength.pieces
    not_negative(pieces.knots, pieces.values)
    skin = skin_of(law, mass=mass, stiffness=stiffness, damping=damping)
    speeds = motion.speeds(strength.ends)
    fastest = float(np.max(np.abs(motion.speeds(times)), initial=float(np.max(np.abs(speeds)))))
    largest = float(np.max(pieces.values)) or skin.natural_force(fastest) or 1.0
    largest_speed = fastest or skin.natural_speed(largest)
    floor = SMALLEST * largest
    course = _course(strength, motion, floor)
    first = float(np.hypot(strength(0.0), floor))
    state = _settled(skin if course.touches[0] else lifted(skin), speed=float(speeds[0]), strength=first)
    body = skin.body
    is_elastic = body[0] > 0
    scale = skin.scale(strength=largest, speed=largest_speed)
    scale = scale[[2, 0, 1]] if is_elastic else np.array([scale[0], 1.0, 1.0])
    sizes = Sizes(tolerance, scale, STILL * largest_speed, DEAD_BAND * largest, MOST_EVENTS, AT_ONCE)
    assert law.bristles is not None
    numbers = law.bristles._replace(nearest=law.bristles.nearest * largest)
    switches = np.array([0] * is_elastic + [1] * (not law.yields_smoothly), np.int64)
    states, directions, moments, kinds, memory = _marched(
        times, state, (course, numbers, body, switches, sizes)
    )
    own = states[[1, 2, 0, 3, 4, 5]] if is_elastic else states[[0, 3, 5]]
    bone = motion.speeds(times)
    over_plate = states[OVER_PLATE] if is_elastic else bone
    deflection = states[DEFLECTION]
    rate = law.deflection_rate(deflection, over_plate, np.hypot(strength(times), floor), directions)
    energies = skin.energies(own)
    return Slide(
        skin_displacement=skin.displacement(own),
        skin_speed=bone - over_plate,
        lateral_force=np.where(motion.touches(times), law.force(deflection, rate, over_plate), 0.0),
        bristle_deflection=deflection,
        energies=energies,
        energy_residual=energies.residual,
        events=tuple((when, KINDS[index]) for when, index in zip(moments, kinds, strict=True)),
        steps=int(memory[STEPS]),
        evaluations=int(memory[ASKED]),
    )


def _settled(skin: SlidingSkin, *, speed: float, strength: float) -> Any:
    """Return the state of steady sliding in the rows of the compiled steps; undeflected at rest."""
    state: Any = np.zeros(6)
    if speed > 0:
        found = skin.settled(speed=speed, strength=strength)
        state[DEFLECTION] = float(skin.deflection(found))
        state[DISPLACEMENT] = float(np.ravel(skin.displacement(found))[0])
        state[OVER_PLATE] = speed
    return state


def _course(strength: Between, motion: Motion, floor: float) -> Any:
    """Return strength, speed and contact from corner to corner, in the form of the compiled steps."""
    stops, pieces = strength.ends, strength.pieces
    last = np.searchsorted(pieces.knots, stops[1:], side="left")
    first = np.searchsorted(pieces.knots, stops[:-1], side="right") - 1
    touches = np.asarray(motion.touches((stops[1:] + stops[:-1]) / 2), dtype=float)
    return GivenOverTime(
        stops, motion.speeds(stops), touches, first, np.maximum(last, first + 1), *pieces, floor
    )


def _marched(
    times: Real, state: Real, given: tuple[Any, ...]
) -> tuple[Real, Real, list[float], list[int], Real]:
    """Return states and directions at the output times, times [s] and kinds of events, and the counts."""
    states, directions = np.empty((len(state), len(times))), np.empty(len(times))
    memory = np.zeros(STATUS + 1)
    moments, kinds = (
        np.empty(MOST_EVENTS + 2),
        np.empty(MOST_EVENTS + 2, np.int64),
    )  # two may come with a stretch
    memory[WANTED] = 1e-3 * float(given[0].stops[1])
    memory[DIRECTION] = memory[SIDE] = 1.0
    method = RadauNumbers(NODES, WEIGHTS, COEFFICIENTS)
    memory[STATUS] = GOES_ON
    meter = Meter("a friction with bristles", end=float(times[-1]))
    while memory[STATUS] == GOES_ON:
        march(times, state, *given, method, memory, (moments, kinds), (states, directions))
        meter.count(float(memory[NOW]))
    if memory[STATUS] == UNSOLVED:
        raise ElectrovibError(f"the equations could not be solved beyond {memory[NOW]:.6g} s")
    if memory[STATUS] == CHATTERS:
        raise ElectrovibError(
            f"more than {MOST_EVENTS} events before {memory[NOW]:.6g} s: the contact chatters"
        )
    filled = int(memory[FILLED])
    states[:, filled:], directions[filled:] = state[:, None], memory[DIRECTION]
    count = int(memory[EVENTS])
    return states, directions, moments[:count].tolist(), kinds[:count].tolist(), memory
