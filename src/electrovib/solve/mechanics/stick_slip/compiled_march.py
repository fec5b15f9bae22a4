"""Time stepping of a skin with bristles in compiled code, with every reversal located."""

from __future__ import annotations

import inspect
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.friction import bristle
from electrovib.solve.mechanics.stick_slip import compiled_events, compiled_step
from electrovib.solve.mechanics.stick_slip.compiled_events import ENOUGH, first_fall, land, switch, turned
from electrovib.solve.mechanics.stick_slip.compiled_step import (
    DEFLECTION,
    FRICTION,
    STAGES,
    collocate,
    compiled,
    compiled_for_python,
    error_of,
    state_at,
    strength_in,
)

if TYPE_CHECKING:
    from collections.abc import Callable

DONE, UNSOLVED, CHATTERS, GOES_ON = range(4)
"""Status at the end of a call."""
NOW, STRETCH, FILLED, WANTED, DIRECTION, SIDE, STEPS, ASKED, EVENTS, STATUS = range(10)
"""State carried from one call to the next: time [s], indices of stretch and output, next step [s], mode, counts."""
ASKED_IN_STEP = 20  # evaluations of the rate in a usual step; more where steps are rejected
_SMALLEST_STEP = 1e-15


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


_SOURCES = "".join(map(inspect.getsource, (bristle, compiled_step, compiled_events)))
march = _marching(zlib.crc32(_SOURCES.encode()))
"""Take some steps from the state in `memory`; events are times [s] and kinds."""
