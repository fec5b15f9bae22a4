"""Implicit adaptive integration of a stiff system whose right-hand side has kinks, each of which is located."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from electrovib.core.budget import Meter
from electrovib.core.errors import ElectrovibError
from electrovib.solve.costs import SHORTER, radau_step
from electrovib.solve.nonlinear.radau import (
    CHATTERS,
    DONE,
    GOES_ON,
    LAST_RATE,
    NODES,
    UNSOLVED,
    Piece,
    Progress,
    Task,
    next_piece,
    product,
    progress_from,
    put,
    restart,
    states_on,
    to_rounding,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real

TOLERANCE = 1e-9
"""Local error of a step, relative, and absolute with respect to the scale of each state."""
MOST_EVENTS = 100_000
_LOOKS = np.array([0.2, 0.4, 0.6, 0.8, 1.0])
"""Shares of a step at which the switching functions are evaluated."""
_MOST_SECANTS = 100
_MOST_LANDINGS = 8
_LANDED = 1e-13
"""Correction of the time of an event, over the whole time, at which the iteration ends."""

Mode: TypeAlias = tuple[int, ...]
"""The side of each kink on which a system is: signs and states that hold until the next event."""


class System(Protocol):
    """Ordinary differential equations that are smooth as long as a mode holds.

    Notes
    -----
    Between two breaks and two events `rate` is smooth in time and state. A mode ends when one of the switching functions
    `switches` falls through zero; `following` then returns the next mode. States have the shape (states,), or (states, n)
    at n times.
    """

    @property
    def scale(self) -> Real:
        """Magnitude of each state, above 0, which sets the absolute tolerance."""

    def breaks(self, end: float) -> Sequence[float]:
        """Return the times up to `end` [s] at which the rate is not smooth in time, or the state is discontinuous."""

    def jump(self, state: Real, *, time: float) -> Real:
        """Return the state just after a break."""

    def rate(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the rate of change of each state [its unit/s]."""

    def rates(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the rates of change at several times: `rate` for each."""
        every = zip(states.T, times.tolist(), strict=True)
        return np.transpose([self.rate(state, mode, time=time) for state, time in every])

    def switches(self, state: Real, mode: Mode, *, time: float) -> Real:
        """Return the switching functions (switches,), which stay above 0 as long as the mode holds."""

    def watched(self, states: Real, mode: Mode, *, times: Real) -> Real:
        """Return the switching functions (switches, n) at several times: `switches` for each."""
        every = zip(states.T, times.tolist(), strict=True)
        return np.transpose([self.switches(state, mode, time=time) for state, time in every])

    def following(self, index: int, state: Real, mode: Mode, *, time: float) -> Mode:
        """Return the mode after a switching function has fallen through zero."""


@dataclass(frozen=True, kw_only=True)
class Solved:
    """Result of an integration.

    Parameters
    ----------
    states : ndarray, shape (states, n)
        States at the output times; at a discontinuity, the value after it.
    modes : ndarray of int, shape (n, signs)
        Modes at the output times.
    events : tuple of (float, int)
        Time [s] of each event, and index of the switching function that fell through zero.
    steps : int
        Number of steps of the integrator.
    """

    states: Real
    modes: Any
    events: tuple[tuple[float, int], ...]
    steps: int


class Output(NamedTuple):
    """States (states, n) and modes (n, signs) at the output times, times [s] and indices of the events."""

    states: Real
    modes: Any
    moments: Real
    indices: Any


def integrate(
    system: System,
    state: Real,
    mode: Mode,
    times: Real,
    *,
    tolerance: float = TOLERANCE,
    step: float | None = None,
) -> Solved:
    """Integrate a system from time 0 by Radau's implicit method of fifth order; `state` (states,), `times` (n,) [s].

    Radau IIA with three stages is of order 5 where the rate is smooth (`radau.ORDER`). Breaks are ends of steps, and
    up to a break everything is evaluated at times before it. An event ends the step at its root: the root is found on
    the collocation polynomial, the shortened step is solved again, and its length is corrected until it ends at the
    root, so that kinks do not reduce the order. A mode that does not hold after a discontinuity ends there at once.
    """
    end = float(times[-1])
    stops = np.unique([0.0, *(b for b in system.breaks(end) if 0 < b < end), end])
    task = Task(stops, np.ones(len(stops), bool), times, system.scale, tolerance, step or 0.0)
    what = f"Radau's method on {len(state)} equations"
    meter = Meter(what, end=end, each=radau_step(len(state)), remedy=SHORTER)
    return solved(advance, system, progress_from(np.array(state, dtype=float)), mode, task, meter)


def solved(
    march: Callable[..., Any], system: Any, progress: Progress, mode: Mode, task: Task, meter: Meter
) -> Solved:
    """Call `advance`, or many of it compiled together, until the last time."""
    count = len(task.times)
    out = Output(
        np.empty((len(progress.state), count)),
        np.empty((count, len(mode)), np.int64),
        np.empty(MOST_EVENTS),
        np.empty(MOST_EVENTS, np.int64),
    )
    at = progress.at
    while at.status == GOES_ON:
        tries = int(at.tries)
        mode = march(system, mode, progress, task, out)
        meter.count(float(at.time), steps=int(at.tries) - tries)
    if at.status == UNSOLVED:
        raise ElectrovibError(f"the equations could not be solved beyond {at.time:.6g} s")
    if at.status == CHATTERS:
        raise ElectrovibError(f"more than {MOST_EVENTS} events before {at.time:.6g} s: the system chatters")
    found = zip(out.moments[: at.events].tolist(), out.indices[: at.events].tolist(), strict=True)
    return Solved(states=out.states, modes=out.modes, events=tuple(found), steps=int(at.steps))


def watched(system: Any, states: Real, mode: Any, times: Real) -> Real:
    """Return the switching functions (switches, n) of n states (states, n) at n times [s]."""
    found: Real = system.watched(states, mode, times=times)
    return found


def following(system: Any, index: int, state: Real, mode: Any, time: float) -> Any:
    """Return the mode after the switching function of this index has fallen through 0."""
    return system.following(index, state, mode, time=time)


def jump(system: Any, state: Real, time: float) -> Real:
    """Return the state just after a break [s]."""
    found: Real = system.jump(state, time=time)
    return found


def advance(system: Any, mode: Any, progress: Progress, task: Task, out: Output) -> Any:
    """Take one step, at most to the next stop or event; return the mode after it."""
    at = progress.at
    if at.arrived:
        return _crossed(system, mode, progress, task, out)
    if at.restarts:
        restart(system, mode, progress, task)
        at.restarts = False
    piece = next_piece(system, mode, progress, task)
    if at.status == UNSOLVED:
        return mode
    share, index = first_fall(system, mode, piece, at.latest)
    reached, stop = piece.start + piece.size, task.stops[at.following]
    if index >= 0:
        piece, converged = land(system, mode, piece, index, share, at.latest, task)
        if not converged:
            at.wanted, at.is_known = piece.size / 2, False
            return mode
        reached = min(piece.start + piece.size, stop)
    if piece.size > 0:
        _put_out(mode, progress, task, out, piece, reached)
        put(progress.state, piece.before + piece.stages[:, -1])
        put(progress.stages, piece.stages)
        put(progress.slope, product(piece.stages, LAST_RATE).ravel() / piece.size)
        at.taken = piece.size
        at.time, at.steps = reached, at.steps + 1
    if index >= 0:
        mode = _switched(system, mode, progress, out, index)
        at.restarts = True
    if at.time >= stop:
        at.arrived = task.breaks[at.following]
        at.following += 1
        if not at.arrived:
            at.latest = np.nextafter(task.stops[at.following], at.time)
    return mode


def _crossed(system: Any, mode: Any, progress: Progress, task: Task, out: Output) -> Any:
    """Pass a break, and change the mode until it holds, at most once for each switching function; the last break is the end."""
    at, state = progress.at, progress.state
    put(state, jump(system, state, at.time))
    at.arrived, at.restarts = False, True
    if at.following == len(task.stops):
        for filled in range(at.filled, len(task.times)):
            put(out.states[:, filled], state)
            for place in range(len(mode)):
                out.modes[filled, place] = mode[place]
        at.status = DONE
        return mode
    for _ in range(len(watched(system, state.reshape((-1, 1)), mode, np.full(1, at.time)))):
        values = watched(system, state.reshape((-1, 1)), mode, np.full(1, at.time))[:, 0]
        for index in range(len(values)):
            if values[index] < 0:
                mode = _switched(system, mode, progress, out, index)
                break
    return mode


def _switched(system: Any, mode: Any, progress: Progress, out: Output, index: int) -> Any:
    """Store an event at the current time, and return the mode after it."""
    at = progress.at
    if at.events == len(out.moments):
        at.status = CHATTERS
        return mode
    out.moments[at.events], out.indices[at.events] = at.time, index
    at.events += 1
    return following(system, index, progress.state, mode, at.time)


def _put_out(mode: Any, progress: Progress, task: Task, out: Output, piece: Piece, reached: float) -> None:
    """Write states and mode at the output times inside a step."""
    at = progress.at
    first, last = at.filled, np.searchsorted(task.times, reached)
    if last > first:
        shares = (task.times[first:last] - piece.start) / piece.size
        put(out.states[:, first:last], states_on(piece, shares))
        for place in range(len(mode)):
            out.modes[first:last, place] = mode[place]
        at.filled = last


def first_fall(system: Any, mode: Any, piece: Piece, latest: float) -> tuple[float, int]:
    """Return the share of a step at which a switching function first falls through 0, and its index; -1 if none does.

    It may have risen again by the end of the step.
    """
    values = _watched_on(system, mode, piece, _LOOKS.copy(), latest)
    first, which = 2.0, -1
    for look in range(len(_LOOKS)):
        for index in range(len(values)):
            if values[index, look] < 0:
                low = 0.0 if look == 0 else _LOOKS[look - 1]
                share = _root(system, mode, piece, index, low, _LOOKS[look], latest)
                if share < first:
                    first, which = share, index
        if which >= 0:
            break
    return first, which


def _watched_on(system: Any, mode: Any, piece: Piece, shares: Real, latest: float) -> Real:
    """Return the switching functions (switches, n) at shares (n,) of a step."""
    times = np.minimum(piece.start + piece.size * shares, latest)
    return watched(system, states_on(piece, shares), mode, times)


def _root(system: Any, mode: Any, piece: Piece, index: int, low: float, high: float, latest: float) -> float:
    """Return the share of a step at which a switching function falls through 0, by secants that keep it between them."""
    values = _watched_on(system, mode, piece, np.array([low, high]), latest)[index]
    above, below, last, share = values[0], values[1], 0, low
    if above <= 0:
        return low
    for _ in range(_MOST_SECANTS):
        share = high - below * (high - low) / (below - above)
        if not low < share < high:
            break
        value = _watched_on(system, mode, piece, np.array([share]), latest)[index, 0]
        if value == 0:
            return float(share)
        if value > 0:
            low, above = share, value
            below = below / 2 if last == 1 else below  # the end that stays counts half (Illinois)
            last = 1
        else:
            high, below = share, value
            above = above / 2 if last == -1 else above
            last = -1
    return float(min(max(share, low), high))


def land(
    system: Any, mode: Any, piece: Piece, index: int, share: float, latest: float, task: Task
) -> tuple[Piece, bool]:
    """Solve a step again, with its length corrected until it ends at the event; return whether it could be solved."""
    size = share * piece.size
    stages = states_on(piece, share * NODES) - piece.before.reshape((-1, 1))
    landed = Piece(piece.start, size, piece.before, stages)
    for _ in range(_MOST_LANDINGS if size > 0 else 0):
        asked = Piece(piece.start, size, piece.before, piece.stages)
        stages, count = to_rounding(system, mode, asked, latest, task.scale)
        if count == 0:
            return asked, False
        landed = Piece(piece.start, size, piece.before, stages)
        values = _watched_on(system, mode, landed, np.array([0.875, 1.0]), latest)[index]
        end, slope = values[1], (values[1] - values[0]) / (0.125 * size)
        if end == 0 or not slope < 0:
            break
        corrected = min(size - end / slope, piece.size)
        if corrected <= 0 or abs(corrected - size) <= _LANDED * task.stops[-1]:
            break
        size = corrected
    return landed, True
