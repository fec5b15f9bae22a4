"""Modes under a piecewise linear drive, exact at any output times, from a given state.

The states at the breaks follow from one recursion, for a repeated drive in closed form in any period.
Each mode relaxes by itself, whichever case it belongs to: only a sum over modes knows the cases.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.solve.electrics.fading import MODES_AT_ONCE, by_output, fading, graded, over_modes
from electrovib.solve.recursion import March, hold_weights, states_at

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.parts import Linear
    from electrovib.solve.electrics.fading import Rows

InStretches: TypeAlias = "Callable[[slice], Rows]"
"""Outputs at the times of a stretch; the stretches follow one another."""
CHUNK = 1 << 16
"""Largest number of states in memory, so that a million samples need no gigabyte."""
MANY_SAMPLES = 20_000
"""Number of samples from which the block scan is faster than the closed form of each segment."""
_LONG = 8000
"""Mean number of times in each piece from which polynomials are faster than each time by itself."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""Largest deviation of an evenly spaced grid, over its last time."""
_FEWEST_BREAKS: Final = 16
"""Largest number of breaks at which the states are computed in a plain loop."""
_FEW_BREAKS: Final = 1000
"""Largest number of breaks at which the states at all of them are computed, whichever are asked for."""
TOGETHER: Final = 48
"""Modes of several cases in one recursion, about: each output of a case is a product with the modes of all."""
_FEW_PIECES: Final = 64
"""Largest number of pieces that are evaluated one after the other by one exponential of each mode."""
_SEVERAL: Final = 100
"""Mean number of times in each piece from which one exponential of each mode is faster than each time by itself."""
_STEEP: Final = 1e3
"""Ratio of slope over rate to the drive, and of a time constant to the time, above which a mode is a small difference."""


@dataclass(frozen=True, eq=False)
class SharedModes:
    """Outputs of modes x' = rate (v - x) under a drive v: direct v + sum gain x, or gain (x - v) in outputs with a lag.

    `rates` (modes,) > 0 [1/s], `gains` (outputs, modes), `direct`, `lag` (outputs,), each but `lag` with an axis of cases before
    these where it differs between cases; `known` holds the states at the breaks of parts of straight pieces, and `passed` those
    at some breaks of a record that the recursion has passed.
    """

    rates: Real
    gains: Real
    direct: Real
    lag: NDArray[np.bool_]
    known: dict[int, BreakStates] = field(default_factory=dict)
    passed: dict[int, dict[int, Real]] = field(default_factory=dict)

    @functools.cached_property
    def cases(self) -> tuple[int, ...]:
        """The number of cases, or nothing."""
        return np.broadcast_shapes(self.rates.shape[:-1], self.gains.shape[:-2], self.direct.shape[:-1])

    def in_groups(self, size: int, respond: Callable[[SharedModes], InStretches]) -> InStretches:
        """Return the response of some cases after the others, each group as modes of one case with the outputs of all."""
        outputs, modes = len(self.lag), self.rates.shape[-1]
        rates, gains, direct = (
            np.broadcast_to(array, self.cases + array.shape[-axes:])
            for array, axes in ((self.rates, 1), (self.gains, 2), (self.direct, 1))
        )
        driven = []
        for first in range(0, len(rates), size):
            some = slice(first, min(first + size, len(rates)))
            count = some.stop - first
            shares = np.zeros((count, outputs, count, modes))
            shares[range(count), :, range(count)] = gains[some]
            whole = shares.reshape(count * outputs, count * modes)
            one = SharedModes(rates[some].ravel(), whole, direct[some].ravel(), np.tile(self.lag, count))
            driven.append(respond(one))

        def through(stretch: slice) -> Rows:
            rows = np.concatenate([np.asarray(each(stretch)) for each in driven])
            return by_output(rows.reshape(len(rates), outputs, -1))

        return through

    def along(self, part: Linear, time: Real, state: Real | None) -> InStretches:
        """Return the response to straight pieces as a function of successive stretches of times, as from `straight`.

        At the breaks themselves, and on an even grid that contains them, one recursion computes all outputs.
        """
        marched = _marched(part, time)
        if marched is not None and not self.cases:
            return self._recursion(part, time, marched, state)
        if marched is not None and np.ndim(marched[2]) == 0 and state is not None and not np.any(state):
            size = max(1, TOGETHER // self.rates.shape[-1])
            return self.in_groups(size, lambda some: some.along(part, time, np.zeros(len(some.rates))))
        if part.period is None and len(part.times) > _FEW_BREAKS:
            whole = self._piece_by_piece(part, time, state)
            return lambda stretch: [row[..., stretch] for row in whole]
        return lambda stretch: self._piece_by_piece(part, time[stretch], state)

    def straight(self, part: Linear, time: Real, state: Real | None) -> Rows:
        """Compute the response to straight pieces at any times, each output in an array of its own.

        `time` (n,) [s], `state` as `rates` [V] at time 0, or None for the periodic state; returns one `response` (n,) [V] for
        each output.
        """
        return self.along(part, time, state)(slice(0, len(time)))

    def _piece_by_piece(self, part: Linear, time: Real, state: Real | None) -> Rows:
        """Return the outputs at any times from the states at the beginnings of their pieces."""
        index, elapsed = part.locate(time)
        periods = part.count_periods(time)
        begins = np.flatnonzero(np.append(True, (np.diff(index) != 0) | (np.diff(periods) != 0)))
        states = self._at_breaks(part, state, index[begins])
        weights, at_begin, gentle = np.zeros(0), np.zeros(0), np.zeros(len(begins), bool)
        few = len(begins) <= _FEW_PIECES and self.rates.shape[-1] <= MODES_AT_ONCE
        if few and len(time) >= _SEVERAL * len(begins):
            where, when = index[begins], periods[begins]
            weights, at_begin, gentle = self.in_exponentials(
                states, where, when, longest=float(np.max(elapsed))
            )
        if not np.any(gentle) and len(time) < _LONG * len(begins):
            return by_output(self._in_pieces(states, time, index, elapsed, periods))
        result = [np.empty((*self.cases, len(time))) for _ in self.lag]
        for place, (first, last) in enumerate(zip(begins, [*begins[1:], len(time)], strict=True)):
            since, now = elapsed[first:last], slice(first, last)
            if gentle[place]:
                line, of_modes = np.split(weights[..., place, :], [2], axis=-1)
                rows = fading(of_modes, self.rates, since, line=line, late=float(time[-1]))
                for row, each, exact in zip(result, rows, by_output(at_begin), strict=True):
                    row[..., now] = each
                    if since[0] == 0:  # exactly 0 from rest
                        row[..., first] = exact[..., place]
                continue
            where, period = index[first], periods[first]
            start = float(part.times[where] + period * (part.period or 0.0))

            def evaluate(
                since: Real, where: Indices = where, period: Indices = period, start: float = start
            ) -> Real:
                same = np.zeros(len(since), np.intp)
                return self._in_pieces(states, start + since, same + where, since, same + period)

            fastest = float(np.max(self.rates))
            found = by_output(evaluate(since)) if self.cases else graded(evaluate, since, fastest)
            for row, each in zip(result, found, strict=True):
                row[..., now] = each
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

        `longest` is the longest time since the begin of a piece [s]. Returns `weights` (..., outputs, pieces, 2 + modes), and
        what they are at the begin of each piece without differences of large numbers, shape (..., outputs, pieces).
        With a drive v + v' s every mode is v + v' s + lag, and the lag (lag_0 + v'/r) exp(-r s) - v'/r.
        """
        part = states.part
        level, slopes = part.after[index], part.slope_of(index)
        begins = part.times[index] + periods * (part.period or 0.0)
        bends = slopes / self.rates[..., None]
        started_with = states.lags(begins).reshape(*self.rates.shape, -1)
        follows = self.follows[..., None]
        moved, started = follows * slopes, follows * level - over_modes(self.gains, bends)
        weights = self.gains[..., :, None, :] * np.swapaxes(started_with + bends, -1, -2)[..., None, :, :]
        lines = np.broadcast_arrays(moved[..., None], started[..., None], weights[..., :1])
        around = tuple(range(bends.ndim - 1))
        gentle = np.max(np.abs(bends), axis=around, initial=0.0) <= _STEEP * np.max(np.abs(part.after))
        gentle &= np.min(self.rates, initial=np.inf) * longest >= 1 / _STEEP
        found = np.concatenate(
            [*lines[:2], np.broadcast_to(weights, (*lines[0].shape[:-1], weights.shape[-1]))], axis=-1
        )
        return found, follows * level + over_modes(self.gains, started_with), gentle

    def _in_pieces(
        self, states: BreakStates, time: Real, index: Indices, elapsed: Real, periods: Indices
    ) -> Real:
        """Return the outputs at times in known pieces, shape (..., outputs, n) [V]."""
        now = states.part.after[index] + elapsed * states.part.slope_of(index)
        found = np.zeros((*self.cases, len(self.lag), len(time)))
        found += self.direct[..., None] * now
        for lag in {*self.lag.tolist()}:
            own = np.flatnonzero(self.lag == lag)
            gains = np.take(self.gains, own, axis=-2)
            sums = np.empty((*self.cases, len(own), len(time)))
            for some in chunks(len(time), self.rates.size):
                rows = (
                    states.lags(time[some])
                    if lag
                    else states.sums(index[some], elapsed[some], periods[some], now[some])
                )
                sums[..., some] = over_modes(gains, rows.reshape(*self.rates.shape, -1))
            found[..., own, :] += sums
        return found

    @functools.cached_property
    def follows(self) -> Real:
        """Outputs under a constant drive of 1, to which all modes have settled, shape (..., outputs)."""
        return np.asarray(self.direct + np.where(self.lag, 0.0, self.gains.sum(axis=-1)))


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

    `rates` (modes,); returns `state` (modes,) [V].

    x0 = (state after one period from rest)/(1 - exp(-rate period)).
    """
    return BreakStates(part, rates, None).state


class BreakStates:
    """States of modes at the breaks of straight pieces; for repeated pieces in any period, without the periods between.

    Parameters
    ----------
    part : Linear
        The pieces.
    rates : ndarray, shape (modes,) or (cases, modes)
        Rates of the modes [1/s], > 0; their states are those of all cases in one row.
    state : ndarray, shape of `rates`, or None
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
        self.part, self.rates, rest = part, rates.ravel(), np.zeros(rates.size)
        self.state = rest if state is None else state.ravel()
        repeats = part.period is not None
        every = repeats or len(part.times) <= _FEW_BREAKS
        self.places = None if every or wanted is None else np.unique(wanted)
        self.states = self._found(passed or {0: rest if repeats else self.state})
        self.settled = None
        if part.period is not None:
            self.settled = self.states[:, -1] / -np.expm1(-self.rates * part.period)
            self.state = self.settled if state is None else self.state

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
            for first in range(0, len(rates), MODES_AT_ONCE):
                some = slice(first, first + MODES_AT_ONCE)
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

    def sums(self, index: Indices, elapsed: Real, periods: Indices, now: Real) -> Real:
        """Compute the states at times in known pieces, `now` being the drive there, shape (modes, n) [V]."""
        if not np.any(elapsed):
            return self.at(index, periods)
        decay, begin, end = hold_weights(-self.rates[:, None] * elapsed)
        return np.asarray(decay * self.at(index, periods) + begin * self.part.after[index] + end * now)

    def lags(self, time: Real) -> Real:
        """Compute the states less the drive at increasing times, shape (modes, n) [V].

        At a break they follow from the piece before it, where they are no small difference of two large numbers.
        """
        part, rates = self.part, self.rates[:, None]
        index, elapsed = part.locate(time)
        periods = part.count_periods(time)
        back = (elapsed == 0) & ((index > 0) | (periods > 0))
        last = max(len(part.times) - 2, 0) if part.period is not None else 0
        before = np.where(back, np.where(index > 0, index - 1, last), index)
        periods = periods - (back & (index == 0))
        elapsed = np.where(back, part.length_of(before), elapsed)
        reached = part.before[np.where(index > 0, index, -1)]
        jump = np.where(back, part.after[index] - reached, 0.0)
        fallen = np.expm1(-rates * elapsed)
        since = self.at(before, periods) - part.after[before]
        return np.asarray((1 + fallen) * since + part.slope_of(before) * fallen / rates - jump)
