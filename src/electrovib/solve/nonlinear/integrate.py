"""March a stiff system whose right-hand side has kinks: implicit, adaptive, every kink located."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from electrovib.core.errors import ElectrovibError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.solve.transfer import Real

Mode: TypeAlias = tuple[int, ...]
"""On which side of each of its kinks a system is: the signs and states that hold until the next event."""

TOLERANCE = 1e-9
"""Local error of a step, relative, and absolute against the scale of each state."""
MOST_EVENTS = 100_000
_APART = 1e-13
"""Events nearer to each other than this share of the whole time count as one."""


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

    def jump(self, time: float, state: Real) -> Real:
        """State just after a break [s], from that just before."""

    def rate(self, time: float, state: Real, mode: Mode) -> Real:
        """Rate of change of each state [its unit/s]."""

    def switches(self, time: float, state: Real, mode: Mode) -> Real:
        """Values that stay above 0 as long as the mode holds."""

    def following(self, index: int, time: float, state: Real, mode: Mode) -> Mode:
        """Mode after the switch of this index has fallen through zero."""


@dataclass(frozen=True)
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


def integrate(
    system: System,
    state: Real,
    mode: Mode,
    times: Real,
    *,
    tolerance: float = TOLERANCE,
    step: float | None = None,
) -> Solved:
    """Follow a system from time 0 by Radau's implicit method of fifth order.

    Parameters
    ----------
    system : System
        Rates, breaks and switches.
    state : ndarray, shape (states,)
        At time 0, before a jump of time 0.
    mode : Mode
        That holds from time 0 on.
    times : ndarray, shape (n,)
        When the states are wanted, increasing, from 0 on [s].
    tolerance : float
        Local error of a step: relative, and absolute against the system's scale.
    step : float, optional
        Fixed steps [s] without control of the error, to measure the order of convergence.

    Returns
    -------
    Solved
        States and modes at the output times.

    Raises
    ------
    ElectrovibError
        If a step cannot be made small enough, or events do not end.

    Notes
    -----
    Radau IIA of three stages: order 5 where the rate is smooth. Breaks are ends of steps, and an event ends the
    step at its root, found on the collocation polynomial and then solved for again, so that kinks cost no order.
    """
    end = float(times[-1])
    states, modes = np.empty((len(state), len(times))), [mode] * len(times)
    stops = np.unique([0.0, *(b for b in system.breaks(end) if 0 < b < end), end])
    now, filled, events, steps, evaluations = 0.0, 0, [], 0, 0
    state = system.jump(0.0, np.array(state, dtype=float))
    for stop in stops[1:].tolist():
        while now < stop:
            leg = _leg(system, now, stop, state, mode, tolerance, step)
            steps, evaluations = steps + leg.steps, evaluations + leg.evaluations
            last = np.searchsorted(times, leg.end, side="left" if leg.end == stop else "right")
            if last > filled:
                states[:, filled:last] = leg.at(times[filled:last])
                modes[filled:last] = [mode] * (last - filled)
                filled = int(last)
            now, state = leg.end, leg.state
            if leg.event is not None:
                events.append((now, leg.event))
                mode = system.following(leg.event, now, state, mode)
                if len(events) > MOST_EVENTS:
                    raise ElectrovibError(f"more than {MOST_EVENTS} events before {now} s: it chatters")
        state = system.jump(stop, state)
    states[:, filled:] = state[:, None]
    modes[filled:] = [mode] * (len(times) - filled)
    return Solved(states, tuple(modes), tuple(events), steps, evaluations)


@dataclass(frozen=True)
class _Leg:
    """One smooth stretch: up to a break or an event."""

    end: float
    state: Real
    event: int | None
    pieces: tuple[Callable[[Real], Real], ...]
    bounds: Real
    steps: int
    evaluations: int

    def at(self, times: Real) -> Real:
        """States at times of this stretch, from the collocation polynomials."""
        place = np.clip(np.searchsorted(self.bounds, times, side="left") - 1, 0, max(len(self.pieces) - 1, 0))
        found = np.empty((len(self.state), len(times)))
        for index in np.unique(place).tolist():
            chosen = place == index
            found[:, chosen] = self.pieces[index](times[chosen])
        found[:, times >= self.end] = self.state[:, None]
        return found


def _leg(
    system: System, start: float, stop: float, state: Real, mode: Mode, tolerance: float, step: float | None
) -> _Leg:
    """Integrate until a break or the first event."""
    solver = _solver(system, start, stop, state, mode, tolerance, step)
    pieces: list[Callable[[Real], Real]] = []
    bounds = [start]
    while solver.status == "running":
        before = solver.t
        message = solver.step()
        if solver.status == "failed":
            raise ElectrovibError(f"the equations could not be solved beyond {solver.t:.6g} s: {message}")
        piece = solver.dense_output()
        if np.any(system.switches(solver.t, solver.y, mode) < 0):
            when, index = _first_fall(system, piece, before, solver.t, mode)
            if when > before:
                fixed = _solver(system, before, when, piece(before), mode, tolerance, None)
                landed, extra = _land(fixed) if step is None else (piece(when), 0)
            else:
                landed, extra = piece(before), 0
            when = max(when, start + _APART * stop)
            return _Leg(
                when,
                landed,
                index,
                (*pieces, piece),
                np.array([*bounds, solver.t]),
                len(pieces) + 1,
                solver.nfev + extra,
            )
        pieces.append(piece)
        bounds.append(solver.t)
    return _Leg(stop, solver.y, None, tuple(pieces), np.array(bounds), len(pieces), solver.nfev)


def _land(solver) -> tuple[Real, int]:  # type: ignore[no-untyped-def]  # noqa: ANN001  # scipy's solver has no type
    """Solve the shortened step again, so that its end has the accuracy of a step and not of a polynomial."""
    while solver.status == "running":
        solver.step()
    return solver.y, solver.nfev


def _solver(  # type: ignore[no-untyped-def]  # noqa: ANN202
    system: System, start: float, stop: float, state: Real, mode: Mode, tolerance: float, step: float | None
):
    from scipy.integrate import Radau

    def rate(time: float, now: Real) -> Real:
        return system.rate(time, now, mode)

    if step is None:
        return Radau(rate, start, state, stop, rtol=tolerance, atol=tolerance * system.scale)
    count = max(1, int(np.ceil((stop - start) / step * (1 - 1e-9))))
    size = (stop - start) / count
    # errors count against a scale so large that every step passes; its equations are solved to rounding all the same
    solver = Radau(
        rate, start, state, stop, first_step=size, max_step=size, rtol=1.0, atol=1e6 * system.scale
    )
    solver.newton_tol = 1e-19
    return solver


def _first_fall(  # type: ignore[no-untyped-def]
    system: System,
    piece,  # noqa: ANN001
    before: float,
    after: float,
    mode: Mode,
) -> tuple[float, int]:
    """Find when the first of the switches that end a step below zero falls through it, and which."""
    from scipy.optimize import brentq

    def value(time: float, index: int) -> float:
        return float(system.switches(time, piece(time), mode)[index])

    falls = []
    for index in np.flatnonzero(system.switches(after, piece(after), mode) < 0).tolist():
        at_once = value(before, index) <= 0 or value(after, index) >= 0
        when = before if at_once else brentq(value, before, after, args=(index,), xtol=1e-300, rtol=1e-15)
        falls.append((float(when), index))
    return min(falls)
