"""States of relaxations at the breaks of straight pieces; of repeated pieces in closed form, period by period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.recursion import march

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.parts import Linear


_MODES_AT_ONCE: Final = 64
"""So that thousands of modes, which a quadrature over relaxations has, need no matrix of thousands squared."""


def periodic_state(part: Linear, rates: Real) -> Real:
    """State of each mode at the beginning of a period of a drive that has been repeating for ever.

    Parameters
    ----------
    part : Linear
        Straight pieces with a period.
    rates : ndarray, shape (modes,)
        1/s, > 0.

    Returns
    -------
    ndarray, shape (modes,)
        V.

    Notes
    -----
    x0 = (state after one period from rest)/(1 - exp(-rate period)).
    """
    assert part.period is not None
    one = part.until(part.period)
    end = _break_states(one, rates, np.zeros(len(rates)))[:, -1]
    state: Real = end / -np.expm1(-rates * part.period)
    return state


def _break_states(part: Linear, rates: Real, state: Real) -> Real:
    """States at the breaks, shape (modes, breaks)."""
    if part.is_step or not len(rates):
        return np.repeat(state[:, None], len(part.times), axis=1)
    steps, states = np.diff(part.times), np.empty((len(rates), len(part.times)))
    for first in range(0, len(rates), _MODES_AT_ONCE):
        some = slice(first, first + _MODES_AT_ONCE)
        count = len(rates[some])
        states[some], _ = march(
            -rates[some], np.eye(count), np.zeros(count), part.after[:-1], part.before[1:], steps, state[some]
        )
    return states


class BreakStates:
    """States of modes at the breaks of straight pieces; of repeated ones in any period, without the periods between.

    Parameters
    ----------
    part : Linear
        The pieces.
    rates : ndarray, shape (modes,)
        1/s, > 0.
    state : ndarray, shape (modes,)
        At time 0 [V].
    """

    def __init__(self, part: Linear, rates: Real, state: Real) -> None:
        self.part, self.rates, self.state = part, rates, state
        self.settled: Real | None = None
        if part.period is None:
            self.states = _break_states(part, rates, state)
        else:
            self.states = _break_states(part, rates, np.zeros(len(rates)))
            self.settled = self.states[:, -1] / -np.expm1(-rates * part.period)

    def at(self, index: Indices, periods: Indices) -> Real:
        """States at breaks of a period, as many periods after the first.

        Parameters
        ----------
        index, periods : ndarray of int, shape (n,)
            Which break, and how many periods later than in the first.

        Returns
        -------
        ndarray, shape (modes, n)
            V.

        Notes
        -----
        After k periods T a mode is at x_0 + (x_settled - x_0)(1 - exp(-rate k T)); what it begins a period with decays
        until the break.
        """
        states: Real = self.states[:, index]
        if self.settled is None or self.part.period is None:
            return states
        came = -np.expm1(-np.outer(self.rates * self.part.period, periods))
        begins = self.state[:, None] + (self.settled - self.state)[:, None] * came
        decayed: Real = states + begins * np.exp(-np.outer(self.rates, self.part.times[index]))
        return decayed
