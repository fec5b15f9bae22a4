"""States of relaxations at the breaks of a piecewise linear drive; for a repeated drive in closed form in any period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.recursion import states_at

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.pieces import Linear


_MODES_AT_ONCE: Final = 64
"""Modes computed together, so that thousands of them need no matrix of thousands squared."""
_FEW_BREAKS: Final = 1000
"""Largest number of breaks at which the states at all of them are computed, whichever are asked for."""


def periodic_state(part: Linear, rates: Real) -> Real:
    """Compute the state of each mode at the beginning of a period, in the periodic state of a repeated drive.

    `rates` (modes,); returns `state` (modes,) [V].

    x0 = (state after one period from rest)/(1 - exp(-rate period)).
    """
    assert part.period is not None
    one = part.until(part.period)
    end = _break_states(one, rates, np.zeros(len(rates)))[:, -1]
    state: Real = end / -np.expm1(-rates * part.period)
    return state


def _break_states(part: Linear, rates: Real, state: Real) -> Real:
    """Return the states at the breaks, shape (modes, breaks)."""
    return _states_at(part, rates, state, np.arange(len(part.times)))


def _states_at(part: Linear, rates: Real, state: Real, places: Indices) -> Real:
    """Return the states at some breaks, shape (modes, places)."""
    if part.is_step or not len(rates):
        return np.repeat(state[:, None], len(places), axis=1)
    steps = part.lengths if part.step is None else part.step
    states = np.empty((len(rates), len(places)))
    for first in range(0, len(rates), _MODES_AT_ONCE):
        some = slice(first, first + _MODES_AT_ONCE)
        states[some] = states_at(-rates[some], part.after[:-1], part.before[1:], steps, state[some], places)
    return states


class BreakStates:
    """States of modes at the breaks of straight pieces; for repeated pieces in any period, without the periods between.

    Parameters
    ----------
    part : Linear
        The pieces.
    rates : ndarray, shape (modes,)
        Rates of the modes [1/s], > 0.
    state : ndarray, shape (modes,)
        States at time 0 [V].
    wanted : ndarray of int, optional
        Breaks at which the states will be asked for; by default all.
    """

    def __init__(self, part: Linear, rates: Real, state: Real, wanted: Indices | None = None) -> None:
        self.part, self.rates, self.state = part, rates, state
        self.settled: Real | None = None
        self.places: Indices | None = None
        if part.period is not None:
            self.states = _break_states(part, rates, np.zeros(len(rates)))
            self.settled = self.states[:, -1] / -np.expm1(-rates * part.period)
        elif wanted is None or len(part.times) <= _FEW_BREAKS:
            self.states = _break_states(part, rates, state)
        else:
            self.places = np.unique(wanted)
            self.states = _states_at(part, rates, state, self.places)

    def at(self, index: Indices, periods: Indices) -> Real:
        """Return the states at breaks of a period, some periods after the first.

        `index`, `periods` (n,); returns `states` (modes, n) [V].

        After k periods T a mode is at x_0 + (x_settled - x_0)(1 - exp(-rate k T)); this state decays until the break.
        """
        if self.places is not None:
            index = np.searchsorted(self.places, index)
        states: Real = self.states[:, index]
        if self.settled is None or self.part.period is None:
            return states
        came = -np.expm1(-np.outer(self.rates * self.part.period, periods))
        begins = self.state[:, None] + (self.settled - self.state)[:, None] * came
        decayed: Real = states + begins * np.exp(-np.outer(self.rates, self.part.times[index]))
        return decayed
