"""Implicit adaptive integration of a stiff system whose right-hand side has kinks, each of which is located.

The steps are those of Radau's implicit method of order 5 (Hairer and Wanner 1996, IV.8) in scipy.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from electrovib.core.errors import ElectrovibError
from electrovib.solve.meter import Meter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from scipy.integrate import DenseOutput

    from electrovib.core.arrays import Real

    Rates: TypeAlias = Callable[[Real, Real], Real]


_ROOT = np.sqrt(6.0)
NODES = np.array([(4 - _ROOT) / 10, (4 + _ROOT) / 10, 1.0])
"""Radau IIA, three stages: zeros of x^2 (x - 1)^3 differentiated twice (Hairer and Wanner 1996, IV.5)."""
WEIGHTS = np.array(
    [
        [(88 - 7 * _ROOT) / 360, (296 - 169 * _ROOT) / 1800, (-2 + 3 * _ROOT) / 225],
        [(296 + 169 * _ROOT) / 1800, (88 + 7 * _ROOT) / 360, (-2 - 3 * _ROOT) / 225],
        [(16 - _ROOT) / 36, (16 + _ROOT) / 36, 1 / 9],
    ]
)
"""Integral of each stage's polynomial from the beginning to each node, as a share of the step (the same place)."""
Mode: TypeAlias = tuple[int, ...]
"""The side of each kink on which a system is: signs and states that hold until the next event."""
TOLERANCE = 1e-9
"""Local error of a step, relative, and absolute with respect to the scale of each state."""
MOST_EVENTS = 100_000
HELD = 30
"""Numbers that are held for each state in each step up to the next break or event."""
_APART = 1e-13
"""Least time between two events, as a share of the whole time."""
_CHECKED = np.array([0.2, 0.4, 0.6, 0.8])
"""Shares of a step at which the switching functions are evaluated, besides its end."""
_MOST_CORRECTIONS = 8
_ENOUGH = 1e-13
"""Relative correction of the time at which the iteration ends."""


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

    def rate(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the rate of change of each state, at one time or at n times.

        `state` (states,) or (states, n); returns `rate` of the same shape.
        """

    def switches(self, state: Real, mode: Mode, *, time: Any) -> Real:
        """Return the switching functions, which stay above 0 as long as the mode holds, at one time or at n times.

        `state` (states,) or (states, n); returns `values` (switches,) or (switches, n).
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
    steps : int
        Number of steps of the integrator.
    """

    states: Real
    modes: tuple[Mode, ...]
    events: tuple[tuple[float, int], ...]
    steps: int


def integrate(
    system: System,
    state: Real,
    mode: Mode,
    times: Real,
    *,
    tolerance: float = TOLERANCE,
    step: float | None = None,
    repeats: float = math.inf,
) -> Solved:
    """Integrate a system from time 0 by Radau's implicit method of fifth order.

    `state` (states,), `times` (n,) [s].

    Breaks are ends of steps, and up to a break the rate is evaluated at times before it. An event ends the step at its
    root: the root is found on the collocation polynomial, the shortened step is solved again, and its length is
    corrected until it ends at the root, so that kinks do not reduce the order. A mode that does not hold after a
    discontinuity ends there at once.
    `step` is the largest step [s], `repeats` the period of what drives the system [s].
    """
    end = float(times[-1])
    states, modes = np.empty((len(state), len(times))), [mode] * len(times)
    stops = np.unique([0.0, *(b for b in system.breaks(end) if 0 < b < end), end])
    now, filled, steps = 0.0, 0, 0
    meter = Meter(f"Radau's method on {len(state)} equations", end=end, repeats=repeats)
    events: list[tuple[float, int]] = []
    state = system.jump(np.array(state, dtype=float), time=0.0)
    for stop in stops[1:].tolist():
        mode = _mode_after_jump(system, now, state, mode, events)
        while now < stop:
            leg = _leg(system, now, stop, state, mode, meter, tolerance, step)
            steps += len(leg.pieces)
            last = int(np.searchsorted(times, leg.end, side="left" if leg.end == stop else "right"))
            if last > filled:
                states[:, filled:last] = leg.at(times[filled:last])
                modes[filled:last] = [mode] * (last - filled)
                filled = last
            now, state = leg.end, leg.state
            if leg.event is not None:
                events.append((now, leg.event))
                mode = system.following(leg.event, state, mode, time=now)
                if len(events) > MOST_EVENTS:
                    raise ElectrovibError(
                        f"more than {MOST_EVENTS} events before {now} s: the system chatters"
                    )
        state = system.jump(state, time=stop)
    states[:, filled:] = state[:, None]
    modes[filled:] = [mode] * (len(times) - filled)
    return Solved(states=states, modes=tuple(modes), events=tuple(events), steps=steps)


def _mode_after_jump(
    system: System, now: float, state: Real, mode: Mode, events: list[tuple[float, int]]
) -> Mode:
    """Return a mode that holds after a discontinuity, with at most one change for each switching function."""
    for _ in range(len(system.switches(state, mode, time=now))):
        fallen = np.flatnonzero(system.switches(state, mode, time=now) < 0)
        if not len(fallen):
            break
        events.append((now, int(fallen[0])))
        mode = system.following(int(fallen[0]), state, mode, time=now)
    return mode


@dataclass(frozen=True, kw_only=True)
class _Leg:
    """One smooth interval, which ends at a break or an event."""

    end: float
    state: Real
    event: int | None
    pieces: tuple[DenseOutput, ...]

    def at(self, times: Real) -> Real:
        """Return the states at increasing times of this interval, from the polynomials of the steps."""
        found = np.empty((len(self.state), len(times)))
        edges = np.searchsorted(times, [piece.t for piece in self.pieces[:-1]], side="right")
        for piece, inside in zip(self.pieces, np.split(np.arange(len(times)), edges), strict=True):
            if len(inside):
                found[:, inside] = piece(times[inside])
        found[:, times >= self.end] = self.state[:, None]
        return found


def _leg(
    system: System,
    start: float,
    stop: float,
    state: Real,
    mode: Mode,
    meter: Meter,
    tolerance: float,
    step: float | None,
) -> _Leg:
    """Integrate up to a break or the first event."""
    latest = np.nextafter(stop, start)

    def rate(every: Real, now: Real) -> Real:
        return system.rate(now, mode, time=np.minimum(every, latest))

    pieces: list[DenseOutput] = []
    event = None
    march = functools.partial(_steps, rate, scale=system.scale, tolerance=tolerance, step=step)
    for piece, after_state in march(state, start=start, stop=stop):
        before, before_state, state = piece.t_old, state, after_state
        meter.held = HELD * len(state) * len(pieces)
        meter.count(piece.t)
        fall = first_fall(system, piece, state, mode, before=before, after=piece.t)
        pieces.append(piece)
        if fall is not None:
            when, event = fall
            if when > before:
                landing = functools.partial(march, before_state, start=before)
                pieces[-1:], state = land(landing, system, mode, when=when, after=piece.t, index=event)
                when = pieces[-1].t
            else:
                state = before_state
            stop = min(max(when, start + _APART * stop), stop)
            break
    return _Leg(end=stop, state=state, event=event, pieces=tuple(pieces))


def _steps(
    rate: Rates,
    state: Real,
    *,
    start: float,
    stop: float,
    scale: Real,
    tolerance: float,
    step: float | None,
    whole: bool = False,
) -> Iterator[tuple[DenseOutput, Real]]:
    """Yield the polynomial of each step and the state at its end; `step` is the largest and the first [s].

    `state`, `scale` (states,); `whole` tries the whole time as one step.
    """
    from scipy.integrate import Radau

    solver = Radau(
        lambda time, states: rate(np.full(states.shape[1], time), states),
        start,
        state,
        stop,
        first_step=stop - start if whole else step and min(step, stop - start),
        max_step=np.inf if step is None else step,
        rtol=tolerance,
        atol=tolerance * scale,
        jac=lambda time, now: _jacobian(rate, now, time=time, scale=scale),
        vectorized=True,
    )
    while solver.status == "running":
        solver.step()
        if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
            raise ElectrovibError(f"the equations could not be solved beyond {solver.t:.6g} s")
        yield solver.dense_output(), solver.y


def _jacobian(rate: Rates, state: Real, *, time: float, scale: Real) -> Real:
    """Return the Jacobian of a rate by forward differences.

    `state`, `scale` (states,); returns `jacobian` (states, states).
    """
    steps = np.sqrt(np.finfo(float).eps) * np.maximum(scale, np.abs(state))
    moved = state[:, None] + np.diag(steps)
    found = rate(np.full(len(state) + 1, time), np.column_stack([moved, state]))
    slopes = np.asarray((found[:, :-1] - found[:, -1:]) / (np.diag(moved) - state))
    if not np.all(np.isfinite(slopes)):
        raise ElectrovibError(f"the equations could not be solved beyond {time:.6g} s")
    return slopes


def land(
    march: Callable[..., Iterator[tuple[DenseOutput, Real]]],
    system: System,
    mode: Mode,
    *,
    index: int,
    when: float,
    after: float,
) -> tuple[list[DenseOutput], Real]:
    """Solve the step again, with its length corrected until it ends at the event; return its polynomials and its end."""
    for _ in range(_MOST_CORRECTIONS):
        landed, states = zip(*march(stop=when, whole=True), strict=True)
        last, state = landed[-1], states[-1]
        value = float(system.switches(state, mode, time=last.t)[index])
        early = last.t_old + 0.875 * (last.t - last.t_old)
        if early >= last.t:  # the step is too short to distinguish times in it
            break
        slope = (value - float(system.switches(last(early), mode, time=early)[index])) / (last.t - early)
        if value == 0 or not slope < 0:
            break
        corrected = min(when - value / slope, after)
        if corrected <= landed[0].t_old or abs(corrected - when) <= _ENOUGH * after:
            break
        when = corrected
    return list(landed), state


def first_fall(
    system: System, piece: Callable[[Real], Real], state: Real, mode: Mode, *, before: float, after: float
) -> tuple[float, int] | None:
    """Return when the first switching function falls through zero in a step; it may have risen again by the end.

    `state` (states,).
    """

    def value(time: float, index: int) -> float:
        return float(system.switches(piece(np.asarray(time)), mode, time=time)[index])

    checked = before + (after - before) * _CHECKED
    inside = np.column_stack([piece(checked), state])
    values = system.switches(inside, mode, time=np.append(checked, after)).T
    fallen = values < 0
    if not fallen.any():
        return None
    first = int(np.argmax(fallen.any(axis=1)))
    ends = [before, *checked.tolist(), after]
    between, indices = ends[first : first + 2], np.flatnonzero(fallen[first]).tolist()
    return min((fall_of(functools.partial(value, index=index), *between), index) for index in indices)


def fall_of(value: Callable[[float], float], low: float, high: float) -> float:
    """Return when a function falls through 0 between two times, at an end of them where it does so by rounding."""
    from scipy.optimize import brentq

    if value(low) <= 0:
        return low
    if value(high) >= 0:
        return high
    return float(brentq(value, low, high, xtol=1e-300, rtol=1e-15))
