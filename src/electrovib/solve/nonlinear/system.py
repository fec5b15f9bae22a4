"""Interface of a stiff system with kinks, and the result of its integration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real


Mode: TypeAlias = tuple[int, ...]
"""The side of each kink on which a system is: signs and states that hold until the next event."""


class System(Protocol):
    """Ordinary differential equations that are smooth as long as a mode holds.

    Notes
    -----
    Between two breaks and two events `rate` is smooth in time and state. A mode ends when one of the switching functions
    `switches` falls through zero; `following` then returns the next mode.
    """

    @property
    def scale(self) -> Real:
        """Magnitude of each state, above 0, which sets the absolute tolerance."""

    def breaks(self, end: float) -> Sequence[float]:
        """Return the times up to `end` [s] at which the rate is not smooth in time, or the state is discontinuous."""

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a break.

        `state` (states,); returns `state` (states,).
        """

    def rate(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the rate of change of each state.

        `state` (states,); returns `rate` (states,).
        """

    def rates(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the rates of change at several times: `rate` for each.

        `states` (states, n), `times` (n,); returns `rates` (states, n).
        """
        every = zip(states.T, times.tolist(), strict=True)
        return np.transpose([self.rate(state, mode, time=time) for state, time in every])

    def watched(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the switching functions at several times: `switches` for each.

        Returns `values` (switches, n).
        """
        every = zip(states.T, times.tolist(), strict=True)
        return np.transpose([self.switches(state, mode, time=time) for state, time in every])

    def switches(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the switching functions, which stay above 0 as long as the mode holds.

        `state` (states,); returns `values` (switches,).
        """

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after a switching function has fallen through zero.

        `state` (states,).
        """


@dataclass(frozen=True, kw_only=True)
class Solved:
    """Result of an integration.

    Parameters
    ----------
    states : ndarray, shape (states, n)
        States at the output times; at a discontinuity, the value after it.
    modes : tuple of Mode
        Modes at the output times.
    events : tuple of (float, int)
        Time [s] of each event, and index of the switching function that fell through zero.
    steps, evaluations : int
        Number of steps of the integrator, and of evaluations of the rate.
    """

    states: Real
    modes: tuple[Mode, ...]
    events: tuple[tuple[float, int], ...]
    steps: int
    evaluations: int
