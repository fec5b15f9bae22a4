"""Location of the time at which a switching function falls through zero inside a step, and the step that ends there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.nonlinear.collocation import Piece, steps_to

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.solve.nonlinear.collocation import Rates
    from electrovib.solve.nonlinear.system import Mode, System

_LOOKS = np.array([0.2, 0.4, 0.6, 0.8])
"""Shares of a step at which the switching functions are evaluated, besides its end."""
_MOST_CORRECTIONS = 8
_ENOUGH = 1e-13
"""Relative correction of the time at which the iteration ends."""


def land(
    rate: Rates,
    system: System,
    state: Real,
    mode: Mode,
    *,
    index: int,
    before: float,
    when: float,
    after: float,
) -> tuple[Piece, ...]:
    """Solve the step again, with its length corrected until it ends at the event.

    `state` (states,).
    """
    for _ in range(_MOST_CORRECTIONS):
        landed = steps_to(rate, state, start=before, size=when - before, scale=system.scale)
        last = landed[-1]
        value = float(system.switches(last.state, mode, time=last.end)[index])
        early = last.start + 0.875 * last.size
        if early >= last.end:  # the step is too short to distinguish times in it
            break
        slope = (value - float(system.switches(last(np.asarray(early)), mode, time=early)[index])) / (
            last.end - early
        )
        if value == 0 or not slope < 0:
            break
        corrected = min(when - value / slope, after)
        if corrected <= before or abs(corrected - when) <= _ENOUGH * after:
            break
        when = corrected
    return landed


def first_fall(
    system: System, piece: Callable[[Real], Real], state: Real, mode: Mode, *, before: float, after: float
) -> tuple[float, int] | None:
    """Return when the first switching function falls through zero in a step; it may have risen again by the end.

    `state` (states,).
    """
    from scipy.optimize import brentq

    def value(time: float, index: int) -> float:
        return float(system.switches(piece(np.asarray(time)), mode, time=time)[index])

    looks = before + (after - before) * _LOOKS
    inside = np.column_stack([piece(looks), state])
    values = system.watched(inside, mode, times=np.append(looks, after)).T
    fallen = values < 0
    if not fallen.any():
        return None
    first = int(np.argmax(fallen.any(axis=1)))
    ends = [before, *looks.tolist(), after]
    falls = []
    for index in np.flatnonzero(fallen[first]).tolist():
        low, high = ends[first], ends[first + 1]
        if value(low, index) <= 0:
            falls.append((low, index))
        elif value(high, index) >= 0:  # the polynomial's end and the state differ by rounding
            falls.append((high, index))
        else:
            falls.append((float(brentq(value, low, high, args=(index,), xtol=1e-300, rtol=1e-15)), index))
    return min(falls)
