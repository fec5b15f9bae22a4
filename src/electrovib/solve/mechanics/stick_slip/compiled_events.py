"""Events of a compiled step: reversals, and bristle forces that pass the strength."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.mechanics.stick_slip.compiled_step import (
    collocate,
    compiled,
    state_at,
    strength_in,
)

if TYPE_CHECKING:
    pass

_MOST_LANDINGS = 8
_CLOSED_IN = 200  # halvings of a share of a step: beyond the last bit
ENOUGH = 1e-13
_LOOKS = np.array([0.2, 0.4, 0.6, 0.8, 1.0])


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
