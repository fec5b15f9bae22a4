"""March a stiff system whose right-hand side has kinks: implicit, adaptive, every kink located."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.nonlinear.collocation import Piece, factor, march, solve

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from electrovib.solve.transfer import Real

Mode: TypeAlias = tuple[int, ...]
"""On which side of each of its kinks a system is: the signs and states that hold until the next event."""

TOLERANCE = 1e-9
"""Local error of a step, relative, and absolute against the scale of each state."""
MOST_EVENTS = 100_000
_APART = 1e-13
"""Events nearer to each other than this share of the whole time count as one."""
_LOOKS = np.array([0.2, 0.4, 0.6, 0.8])
"""Where inside a step the switches are looked at, besides its end."""
_MOST_CORRECTIONS = 8


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
    Radau IIA of three stages: order 5 where the rate is smooth (`collocation.ORDER`). Breaks are ends of steps,
    and up to a break the rate is asked for times before it. An event ends the step at its root: it is found on
    the collocation polynomial, the shortened step is solved again, and its length corrected until its own end
    is the root, so that kinks cost no order. A mode that does not hold after a jump ends there at once.
    """
    end = float(times[-1])
    states, modes = np.empty((len(state), len(times))), [mode] * len(times)
    stops = np.unique([0.0, *(b for b in system.breaks(end) if 0 < b < end), end])
    now, filled, steps, evaluations = 0.0, 0, 0, 0
    events: list[tuple[float, int]] = []
    state = system.jump(0.0, np.array(state, dtype=float))
    for stop in stops[1:].tolist():
        mode = _mode_after_jump(system, now, state, mode, events)
        while now < stop:
            leg = _leg(system, now, stop, state, mode, tolerance, step)
            steps, evaluations = steps + leg.steps, evaluations + leg.evaluations
            last = int(np.searchsorted(times, leg.end, side="left" if leg.end == stop else "right"))
            if last > filled:
                states[:, filled:last] = leg.at(times[filled:last])
                modes[filled:last] = [mode] * (last - filled)
                filled = last
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


def _mode_after_jump(
    system: System, now: float, state: Real, mode: Mode, events: list[tuple[float, int]]
) -> Mode:
    """Change the mode until it holds, once for each switch at most."""
    for _ in range(len(system.switches(now, state, mode))):
        fallen = np.flatnonzero(system.switches(now, state, mode) < 0)
        if not len(fallen):
            break
        events.append((now, int(fallen[0])))
        mode = system.following(int(fallen[0]), now, state, mode)
    return mode


@dataclass(frozen=True)
class _Leg:
    """One smooth stretch: up to a break or an event."""

    end: float
    state: Real
    event: int | None
    pieces: tuple[Callable[[Real], Real], ...]
    bounds: tuple[float, ...]
    steps: int
    evaluations: int

    def at(self, times: Real) -> Real:
        """States at increasing times of this stretch, from the collocation polynomials."""
        found = np.empty((len(self.state), len(times)))
        edges = np.searchsorted(times, self.bounds, side="right")
        edges[0], edges[-1] = 0, len(times)
        for index in np.flatnonzero(np.diff(edges)).tolist():
            inside = slice(edges[index], edges[index + 1])
            found[:, inside] = self.pieces[index](times[inside])
        found[:, times >= self.end] = self.state[:, None]
        return found


def _leg(
    system: System, start: float, stop: float, state: Real, mode: Mode, tolerance: float, step: float | None
) -> _Leg:
    """Integrate until a break or the first event."""
    asked, latest = 0, np.nextafter(stop, start)

    def rate(time: float, now: Real) -> Real:
        nonlocal asked
        asked += 1
        return system.rate(min(time, latest), now, mode)

    pieces: list[Callable[[Real], Real]] = []
    bounds = [start]
    taken = (
        _adaptive(rate, start, stop, state, system.scale, tolerance)
        if step is None
        else _even(rate, start, stop, state, system.scale, step)
    )
    for after, end_state, piece in taken:
        before, before_state = bounds[-1], state
        fall = _first_fall(system, piece, before, after, end_state, mode)
        if fall is None:
            pieces.append(piece)
            bounds.append(after)
            state = end_state
            continue
        when, index = fall
        landed: tuple[Piece, ...] = ()
        if when > before:
            landed = _land(rate, system, before, before_state, when, after, index, mode)
            when, state = landed[-1].end, landed[-1].state
        when = min(max(when, start + _APART * stop), stop)
        every: tuple[Callable[[Real], Real], ...] = (*pieces, *landed) or (piece,)
        bounds += [part.end for part in landed[:-1]] + [when] * bool(landed or not pieces)
        return _Leg(when, state, index, every, tuple(bounds), len(every), asked)
    return _Leg(stop, state, None, tuple(pieces), tuple(bounds), len(pieces), asked)


def _adaptive(
    rate: Callable[[float, Real], Real], start: float, stop: float, state: Real, scale: Real, tolerance: float
) -> Iterator[tuple[float, Real, Callable[[Real], Real]]]:
    """Steps whose length follows from the error: each one's end, the state there, and its polynomial."""
    from scipy.integrate import Radau

    solver = Radau(rate, start, state, stop, rtol=tolerance, atol=tolerance * scale)
    solver.lu, solver.solve_lu = (
        factor,
        solve,
    )  # scipy's own take several times longer than the small systems do
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise ElectrovibError(f"the equations could not be solved beyond {solver.t:.6g} s: {message}")
        yield float(solver.t), solver.y, solver.dense_output()


def _even(
    rate: Callable[[float, Real], Real], start: float, stop: float, state: Real, scale: Real, step: float
) -> Iterator[tuple[float, Real, Callable[[Real], Real]]]:
    """Steps of one length, the given one or a little less."""
    count = max(1, int(np.ceil((stop - start) / step * (1 - 1e-9))))
    bounds = np.linspace(start, stop, count + 1).tolist()
    for before, after in itertools.pairwise(bounds):
        taken = _marched(rate, before, state, after - before, scale)
        state = taken[-1].state
        for piece in taken:
            yield after if piece is taken[-1] else piece.end, piece.state, piece


def _marched(
    rate: Callable[[float, Real], Real], start: float, state: Real, size: float, scale: Real
) -> tuple[Piece, ...]:
    pieces = march(rate, start, state, size, scale)
    if pieces is None:
        raise ElectrovibError(f"the equations could not be solved beyond {start:.6g} s")
    return pieces


def _land(
    rate: Callable[[float, Real], Real],
    system: System,
    before: float,
    state: Real,
    when: float,
    after: float,
    index: int,
    mode: Mode,
) -> tuple[Piece, ...]:
    """Solve the shortened step again, and correct its length until its own end is the root."""
    for _ in range(_MOST_CORRECTIONS):
        landed = _marched(rate, before, state, when - before, system.scale)
        last = landed[-1]
        value = float(system.switches(last.end, last.state, mode)[index])
        early = last.start + 0.875 * last.size
        slope = (value - float(system.switches(early, last(np.asarray(early)), mode)[index])) / (
            last.end - early
        )
        if value == 0 or not slope < 0:
            break
        corrected = min(when - value / slope, after)
        if corrected <= before or abs(corrected - when) <= _APART * after:
            break
        when = corrected
    return landed


def _first_fall(
    system: System, piece: Callable[[Real], Real], before: float, after: float, state: Real, mode: Mode
) -> tuple[float, int] | None:
    """Find when the first switch falls through zero in a step, and which; it may have risen again by the end."""
    from scipy.optimize import brentq

    def value(time: float, index: int) -> float:
        return float(system.switches(time, piece(np.asarray(time)), mode)[index])

    if not len(system.switches(after, state, mode)):
        return None
    looks = before + (after - before) * _LOOKS
    inside = piece(looks).T
    values = [system.switches(time, each, mode) for time, each in zip(looks.tolist(), inside, strict=True)]
    values.append(system.switches(after, state, mode))
    fallen = np.array(values) < 0
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
