"""What a stiff system with kinks has to tell, and what its march gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real


Mode: TypeAlias = tuple[int, ...]
"""On which side of each of its kinks a system is: the signs and states that hold until the next event."""


class System(Protocol):
    """Ordinary differential equations that are smooth as long as a mode holds.

    Notes
    -----
    Between two breaks and two events `rate` is smooth in time and state. A mode ends when one of `switches`
    falls through zero; `following` then says which begins.
    """

    @property
    def scale(self) -> Real:
        """Size of each state, above 0: what counts as small against it."""

    def breaks(self, end: float) -> Sequence[float]:
        """Times up to `end` [s] at which the rate is not smooth in time, or the state jumps."""

    def jump(self, state: Real, *, time: float) -> Real:
        """State just after a break.

        Parameters
        ----------
        time : float
            Of the break [s].
        state : ndarray, shape (states,)
            Just before it.

        Returns
        -------
        ndarray, shape (states,)
            Just after it.
        """

    def rate(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Rate of change of each state.

        Parameters
        ----------
        time : float
            s.
        state : ndarray, shape (states,)
            There.
        mode : Mode
            That holds.

        Returns
        -------
        ndarray, shape (states,)
            Unit of each state per second.
        """

    def switches(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Values that stay above 0 as long as the mode holds.

        Parameters
        ----------
        time : float
            s.
        state : ndarray, shape (states,)
            There.
        mode : Mode
            That holds.

        Returns
        -------
        ndarray, shape (switches,)
            In any unit.
        """

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Mode after a switch has fallen through zero.

        Parameters
        ----------
        index : int
            Which switch.
        time : float
            When [s].
        state : ndarray, shape (states,)
            There.
        mode : Mode
            That has ended.

        Returns
        -------
        Mode
            That begins.
        """


@dataclass(frozen=True, kw_only=True)
class Solved:
    """What an integration found.

    Parameters
    ----------
    states : ndarray, shape (states, n)
        At the output times; at a jump the value after it.
    modes : tuple of Mode
        At the output times.
    events : tuple of (float, int)
        When [s] which switch fell through zero.
    steps, evaluations : int
        Of the integrator, and of the rate.
    """

    states: Real
    modes: tuple[Mode, ...]
    events: tuple[tuple[float, int], ...]
    steps: int
    evaluations: int
