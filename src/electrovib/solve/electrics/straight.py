"""Modes under a piecewise linear drive, exact at any output times, from a given state.

The states at the breaks follow from one recursion, for a repeated drive in closed form in any period. At very many times
after a corner a few polynomials replace the exponentials: a sum of relaxations changes, at a time t after a corner, within
about the time t, so that between t and 2 t they represent it to rounding, however far apart the rates lie.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.solve.electrics.rows import in_rows, some_cases
from electrovib.solve.recursion import March, hold_weights, states_at

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.parts import Linear

Rows: TypeAlias = "Sequence[Real] | Real"
"""Outputs over time, one array (n,) for each."""
InStretches: TypeAlias = "Callable[[slice], Rows]"
"""Outputs at the times of a stretch; the stretches follow one another. Of cases, those of a stretch of the cases."""
CHUNK = 1 << 16
"""Largest number of states in memory, so that a million samples need no gigabyte."""
MANY_SAMPLES = 20_000
"""Number of samples from which the block scan is faster than the closed form of each segment."""
_LONG = 8000
"""Mean number of times in each piece from which polynomials are faster than each time by itself."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""Largest deviation of an evenly spaced grid, over its last time."""
_MODES_AT_ONCE: Final = 64
"""Modes computed together, so that thousands of them need no matrix of thousands squared."""
_FEWEST_BREAKS: Final = 16
"""Largest number of breaks at which the states are computed in a plain loop."""
_FEW_BREAKS: Final = 1000
"""Largest number of breaks at which the states at all of them are computed, whichever are asked for."""
GRADED_DEGREE: Final = 10
"""Degree of the polynomials: on these intervals the Chebyshev coefficients of exp(-z) beyond it are below 1e-16."""
STRETCHES: Final = 8
"""Number of equal intervals from each time to twice that time."""
FEW_TIMES: Final = 4 * GRADED_DEGREE
"""Largest number of times of an interval at each of which the sum is computed."""
_AT_ONCE: Final = 4096
_HELD: Final = 1 << 16
"""Largest number of modes times output times in memory."""
_FORGOTTEN: Final = 745.0
"""Time constants after which an exponential underflows to 0."""
_DECAYED: Final = 80.0
"""Time constants after which an exponential counts as 0: 2e-35 of it remains."""
_FEW_PIECES: Final = 64
"""Largest number of pieces that are evaluated one after the other by one exponential of each mode."""
_SEVERAL: Final = 100
"""Mean number of times in each piece from which one exponential of each mode is faster than each time by itself."""
_STEEP: Final = 1e3
"""Ratio of slope over rate to the drive, and of a time constant to the time, above which a mode is a small difference."""


@dataclass(frozen=True, eq=False)
class SharedModes:
    """Outputs of modes x' = rate (v - x) under a drive v: direct v + sum gain x, or gain (x - v) in outputs with a lag.

    `rates` (modes,) > 0 [1/s], `gains` (outputs, modes), `direct`, `lag` (outputs,); cases have an axis before these but `lag`,
    and there may be rates of 0. `known` holds the states at the breaks of
    parts of straight pieces, and `passed` those at some breaks of a record that the recursion has passed.
    """

    rates: Real
    gains: Real
    direct: Real
    lag: NDArray[np.bool_]
    known: dict[int, BreakStates] = field(default_factory=dict)
    passed: dict[int, dict[int, Real]] = field(default_factory=dict)

    def along(self, part: Linear, time: Real, state: Real | None) -> InStretches:
        """Return the response to straight pieces as a function of successive stretches of times, as from `straight`.

        At the breaks themselves, and on an even grid that contains them, one recursion computes all outputs.
        """
        if self.rates.ndim > 1:
            begin = periodic_state(part, self.rates) if state is None else state
            return in_rows(self, part, time, begin)
        marched = _marched(part, time)
        if marched is not None:
            return self._recursion(part, time, marched, state)
        if part.period is None and len(part.times) > _FEW_BREAKS:
            whole = self._piece_by_piece(part, time, state)
            return lambda stretch: [row[stretch] for row in whole]
        return lambda stretch: self._piece_by_piece(part, time[stretch], state)

    def some(self, stretch: slice) -> SharedModes:
        """Return the modes of some cases."""
        rates, gains, direct = (some_cases(each, stretch) for each in (self.rates, self.gains, self.direct))
        return SharedModes(rates, gains, direct, self.lag)

    def straight(self, part: Linear, time: Real, state: Real | None) -> Rows:
        """Compute the response to straight pieces at any times, each output in an array of its own.

        `time` (n,) [s], `state` (modes,) [V] at time 0, or None for the periodic state; returns one `response` (n,) [V] for
        each output.
        """
        return self.along(part, time, state)(slice(0, len(time)))

    def _piece_by_piece(self, part: Linear, time: Real, state: Real | None) -> list[Real]:
        """Return the outputs at any times from the states at the beginnings of their pieces."""
        index, elapsed = part.locate(time)
        periods = part.count_periods(time)
        begins = np.flatnonzero(np.append(True, (np.diff(index) != 0) | (np.diff(periods) != 0)))
        states = self._at_breaks(part, state, index[begins])
        weights, at_begin, gentle = np.zeros(0), np.zeros(0), np.zeros(len(begins), bool)
        few = len(begins) <= _FEW_PIECES and len(self.rates) <= _MODES_AT_ONCE
        if few and len(time) >= _SEVERAL * len(begins):
            where, when = index[begins], periods[begins]
            weights, at_begin, gentle = self.in_exponentials(
                states, where, when, longest=float(np.max(elapsed))
            )
        if not np.any(gentle) and len(time) < _LONG * len(begins):
            return list(self._in_pieces(states, time, index, elapsed, periods))
        result = [np.empty(len(time)) for _ in self.gains]
        for place, (first, last) in enumerate(zip(begins, [*begins[1:], len(time)], strict=True)):
            where, period = index[first], periods[first]
            if last - first < _LONG and gentle[place]:
                decays = exponentials(self.rates, elapsed[first:last])
                sums = weights[:, place, 1:] @ decays + weights[:, place, :1] * elapsed[first:last]
                sums[:, elapsed[first:last] == 0] = at_begin[:, place, None]  # exactly 0 from rest
                for row, each in zip(result, sums, strict=True):
                    row[first:last] = each
                continue
            start = float(part.times[where] + period * (part.period or 0.0))

            def evaluate(
                since: Real, where: Indices = where, period: Indices = period, start: float = start
            ) -> Real:
                same = np.zeros(len(since), np.intp)
                return self._in_pieces(states, start + since, same + where, since, same + period)

            found = graded(evaluate, elapsed[first:last], float(np.max(self.rates)))
            for row, each in zip(result, found, strict=True):
                row[first:last] = each
        return result

    def _recursion(
        self, part: Linear, time: Real, marched: tuple[Real, Real, Real | float], state: Real | None
    ) -> InStretches:
        """Return the outputs at the ends of pieces, at a discontinuity the value after it, at the last time as well."""
        begin = periodic_state(part, self.rates) if state is None else state
        one = March(-self.rates, self.gains, self.direct, *marched, begin, lag=self.lag)
        at_breaks = part.begins_with(time)

        def through(stretch: slice) -> Real:
            last = min(stretch.stop, one.pieces)
            if at_breaks:
                self.passed.setdefault(id(part), {})[stretch.start] = one.state
            output = one.through(slice(stretch.start, last))
            if last < stretch.stop and (jump := float(part.value(time[-1:])[0] - marched[1][-1])):
                output[:, -1] += (self.direct - np.where(self.lag, self.gains.sum(axis=1), 0.0)) * jump
            return output[:, : stretch.stop - stretch.start]

        return through

    def _at_breaks(self, part: Linear, state: Real | None, index: Indices) -> BreakStates:
        """Return the states at the breaks around some pieces; those at all breaks of a part are kept."""
        if id(part) in self.known:
            return self.known[id(part)]
        wanted = np.unique(np.concatenate([index, np.maximum(index - 1, 0)]))
        states = BreakStates(part, self.rates, state, wanted, self.passed.get(id(part)))
        if states.places is None:
            self.known[id(part)] = states
        return states

    def in_exponentials(
        self, states: BreakStates, index: Indices, periods: Indices, *, longest: float
    ) -> tuple[Real, Real, NDArray[np.bool_]]:
        """Return slope, level and weights of the exponentials in some pieces, and which pieces these represent to rounding.

        `longest` is the longest time since the begin of a piece [s]. Returns `weights` (outputs, pieces, 2 + modes), and what
        they are at the begin of each piece without differences of large numbers, shape (outputs, pieces).
        With a drive v + v' s every mode is v + v' s + lag, and the lag (lag_0 + v'/r) exp(-r s) - v'/r.
        """
        part = states.part
        level, slopes = part.after[index], part.slope_of(index)
        begins = part.times[index] + periods * (part.period or 0.0)
        bends = slopes[:, None] / self.rates
        started_with = states.lags(np.eye(len(self.rates)), begins).T
        lags = started_with + bends
        follows = (self.direct + np.where(self.lag, 0.0, self.gains.sum(axis=1)))[:, None]
        moved, started = follows * slopes, follows * level - self.gains @ bends.T
        parts = [moved[..., None], started[..., None], self.gains[:, None] * lags]
        gentle = np.max(np.abs(bends), axis=1, initial=0.0) <= _STEEP * np.max(np.abs(part.after))
        gentle &= np.min(self.rates, initial=np.inf) * longest >= 1 / _STEEP
        return np.concatenate(parts, axis=2), follows * level + self.gains @ started_with.T, gentle

    def _in_pieces(
        self, states: BreakStates, time: Real, index: Indices, elapsed: Real, periods: Indices
    ) -> Real:
        """Return the outputs at times in known pieces, shape (outputs, n) [V]."""
        now = states.part.after[index] + elapsed * states.part.slope_of(index)
        found = np.outer(self.direct, now)
        found[self.lag] += states.lags(self.gains[self.lag], time)
        found[~self.lag] += states.sums(self.gains[~self.lag], index, elapsed, periods)
        return found


def chunks(samples: int, modes: int) -> list[slice]:
    """Split many times into intervals whose states fit in memory together."""
    length = max(1, CHUNK // modes)
    return [slice(first, first + length) for first in range(0, samples, length)]


def _marched(part: Linear, time: Real) -> tuple[Real, Real, Real | float] | None:
    """Return starts, ends and durations of the pieces between output times that include every break; otherwise None.

    The times are the first breaks themselves, or many times of an even grid that begins at 0.
    """
    end = float(time[-1])
    if part.begins_with(time):
        last = len(time) - 1
        steps = part.lengths[:last] if part.step is None else part.step
        return part.after[:last], part.before[1 : last + 1], steps
    if len(time) < MANY_SAMPLES or time[0] != 0 or part.count_breaks(end) > len(time):
        return None
    step, rounding, pieces = end / (len(time) - 1), ROUNDING * end, part.until(end)
    inside = pieces.times <= end + rounding
    places = np.round(pieces.times[inside] / step).astype(int)
    off = np.max(np.abs(pieces.times[inside] - step * places))
    if max(off, np.max(np.abs(time - step * np.arange(len(time))))) > rounding:
        return None
    after = pieces.value(time)
    before = after.copy()
    before[places], after[places] = pieces.before[inside], pieces.after[inside]
    return after[:-1], before[1:], step


def periodic_state(part: Linear, rates: Real) -> Real:
    """Compute the state of each mode at the beginning of a period, in the periodic state of a repeated drive.

    `rates` (..., modes); returns `state` (..., modes) [V].

    x0 = (state after one period from rest)/(1 - exp(-rate period)).
    """
    return BreakStates(part, rates.ravel(), None).state.reshape(rates.shape)


class BreakStates:
    """States of modes at the breaks of straight pieces; for repeated pieces in any period, without the periods between.

    Parameters
    ----------
    part : Linear
        The pieces.
    rates : ndarray, shape (modes,)
        Rates of the modes [1/s], > 0.
    state : ndarray, shape (modes,), or None
        States at time 0 [V]; None for the periodic state.
    wanted : ndarray of int, optional
        Breaks at which the states will be asked for; by default all.
    passed : dict, optional
        Breaks at which the states are known, 0 among them, and these states.
    """

    def __init__(
        self,
        part: Linear,
        rates: Real,
        state: Real | None,
        wanted: Indices | None = None,
        passed: dict[int, Real] | None = None,
    ) -> None:
        self.part, self.rates, rest = part, rates, np.zeros(len(rates))
        self.state = rest if state is None else state
        repeats = part.period is not None
        every = repeats or len(part.times) <= _FEW_BREAKS
        self.places = None if every or wanted is None else np.unique(wanted)
        self.states = self._found(passed or {0: rest if repeats else self.state})
        self.settled = None
        if part.period is not None:
            self.settled = self.states[:, -1] / -np.expm1(-rates * part.period)
            self.state = self.settled if state is None else state

    def _found(self, passed: dict[int, Real]) -> Real:
        """Return the states at the wanted breaks, each from the last break before it where they are known, (modes, places)."""
        part, rates, state = self.part, self.rates, passed[0]
        places = np.arange(len(part.times)) if self.places is None else self.places
        if part.is_step or not len(rates):
            return np.repeat(state[:, None], len(places), axis=1)
        if len(part.times) <= _FEWEST_BREAKS:
            return self._one_by_one(state)
        states = np.empty((len(rates), len(places)))
        begins = np.array(sorted(passed))
        nearest = np.searchsorted(begins, places, side="right") - 1
        for which in np.unique(nearest).tolist():
            own, begin = nearest == which, int(begins[which])
            stretch = slice(begin, len(part.times) - 1)
            if which + 1 < len(begins):
                stretch = slice(begin, max(int(places[own][-1]), begin + 1))
            steps = part.lengths[stretch] if part.step is None else part.step
            given = part.after[:-1][stretch], part.before[1:][stretch], steps
            for first in range(0, len(rates), _MODES_AT_ONCE):
                some = slice(first, first + _MODES_AT_ONCE)
                state = passed[begin][some]
                found = states_at(-rates[some], *given, state, places[own] - begin, record=len(part.times))
                states[some, own] = found
        return states

    def _one_by_one(self, state: Real) -> Real:
        """Return the states at all breaks, from each to the next, shape (modes, breaks)."""
        part, states = self.part, [state]
        decays, firsts, lasts = hold_weights(-np.outer(part.lengths, self.rates))
        pushes = firsts * part.after[:-1, None] + lasts * part.before[1:, None]
        for decay, push in zip(decays, pushes, strict=True):
            states.append(decay * states[-1] + push)
        return np.array(states).T

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

    def sums(self, gains: Real, index: Indices, elapsed: Real, periods: Indices) -> Real:
        """Compute sums of gain x over modes at times in known pieces, shape (outputs, n) [V]; `gains` (outputs, modes)."""
        part, rates = self.part, self.rates
        result = np.zeros((len(gains), len(index)))
        now = part.after[index] + elapsed * part.slope_of(index)
        for piece in chunks(len(index), len(rates)) if len(gains) else []:
            decay, begin, end = hold_weights(-rates[:, None] * elapsed[piece])
            known = self.at(index[piece], periods[piece])
            result[:, piece] = gains @ (decay * known + begin * part.after[index[piece]] + end * now[piece])
        return result

    def lags(self, gains: Real, time: Real) -> Real:
        """Compute sums of gain (x - v) over modes, v being the drive, shape (outputs, n) [V]; `gains` (outputs, modes).

        At a break they follow from the piece before it, where they are no small difference of x and v.
        """
        part, rates = self.part, self.rates
        result = np.zeros((len(gains), len(time)))
        if not result.size:
            return result
        index, elapsed = part.locate(time)
        periods = part.count_periods(time)
        back = (elapsed == 0) & ((index > 0) | (periods > 0))
        last = max(len(part.times) - 2, 0) if part.period is not None else 0
        before = np.where(back, np.where(index > 0, index - 1, last), index)
        periods = periods - (back & (index == 0))
        elapsed = np.where(back, part.length_of(before), elapsed)
        reached = part.before[np.where(index > 0, index, -1)]
        jump, slopes = np.where(back, part.after[index] - reached, 0.0), part.slope_of(before)
        for piece in chunks(len(time), len(rates)):
            fallen = np.expm1(-rates[:, None] * elapsed[piece])
            since = self.at(before[piece], periods[piece]) - part.after[before[piece]]
            lag = (1 + fallen) * since + slopes[piece] * fallen / rates[:, None] - jump[piece]
            result[:, piece] = gains @ lag
        return result


def exponentials(rates: Real, since: Real) -> Real:
    """Return 1 and exp(-rate s) of modes at increasing times s [s], shape (1 + modes, n), 0 where it is below rounding."""
    found = np.zeros((1 + len(rates), len(since)))
    found[0] = 1.0
    for row, rate, last in zip(found[1:], rates, np.searchsorted(since, _DECAYED / rates), strict=True):
        np.exp(-rate * since[:last], out=row[:last])
    return found


def graded(evaluate: Callable[[Real], Real], since: Real, fastest: float) -> list[Real]:
    """Compute sums of relaxations at many times by interpolation between a few.

    `evaluate` returns them at any times [s], shape (outputs, times); `since` (n,) [s] are increasing times after a corner, and
    `fastest` is the largest rate [1/s].
    """
    if len(since) <= STRETCHES * FEW_TIMES:
        return list(evaluate(since))
    doublings = int(np.ceil(np.log2(max(float(since[-1]) * fastest, 1.0)))) + 1
    growing = 2.0 ** np.arange(doublings)[:, None] * (1 + np.arange(STRETCHES) / STRETCHES)
    marks = np.concatenate([np.arange(1, STRETCHES) / STRETCHES, growing.ravel()]) / fastest
    edges = np.unique(np.concatenate([[0], np.searchsorted(since, marks), [len(since)]]))
    longer = np.diff(edges) > FEW_TIMES
    nodes, to_coefficients = chebyshev_rule(GRADED_DEGREE)
    first, last = since[edges[:-1]][longer], since[edges[1:] - 1][longer]
    middle, half = (first + last) / 2, (last - first) / 2
    scale = np.where(half > 0, half, 1.0)  # times that differ by less than their rounding
    alone = np.repeat(~longer, np.diff(edges))
    at_nodes = evaluate((middle[:, None] + half[:, None] * nodes).ravel())
    found = [np.empty(len(since)) for _ in at_nodes]
    if np.any(alone):
        for row, each in zip(found, evaluate(since[alone]), strict=True):
            row[alone] = each
    coefficients = at_nodes.reshape(len(at_nodes), -1, GRADED_DEGREE + 1) @ to_coefficients.T
    for place, (begin, end) in enumerate(
        zip(edges[:-1][longer].tolist(), edges[1:][longer].tolist(), strict=True)
    ):
        for at in range(begin, end, _AT_ONCE):
            some = slice(at, min(at + _AT_ONCE, end))
            powers = np.polynomial.chebyshev.chebvander(
                (since[some] - middle[place]) / scale[place], GRADED_DEGREE
            )
            for row, each in zip(found, coefficients[:, place] @ powers.T, strict=True):
                row[some] = each
    return found


@functools.cache
def chebyshev_rule(degree: int) -> tuple[Real, Real]:
    """Return the nodes of the first kind, increasing from -1 to 1, and the matrix from values there to coefficients."""
    nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
    return nodes, np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, degree)))


def fading(weights: Real, rates: Real, since: Real) -> list[Real]:
    """Compute the sum of weight exp(-rate t) over modes.

    `weights` (outputs, modes), `rates` (modes,) [1/s], `since` (n,) [s]; returns one array (n,) for each output.
    """

    def evaluate(moments: Real) -> Real:
        found = np.empty((len(weights), len(moments)))
        length = max(1, _HELD // len(rates))
        for first in range(0, len(moments), length):
            some = moments[first : first + length]
            left = rates * some[0] < _FORGOTTEN
            found[:, first : first + length] = weights[:, left] @ np.exp(-np.outer(rates[left], some))
        return found

    fastest = float(np.max(rates, initial=0.0))
    if not len(since) or not fastest:
        return [np.full(len(since), total) for total in weights.sum(axis=1)]
    return graded(evaluate, since, fastest)
