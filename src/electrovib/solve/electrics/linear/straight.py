"""Modes under a piecewise linear drive, exact at any output times, from a given state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.electrics.linear.break_states import BreakStates
from electrovib.solve.electrics.linear.graded import graded
from electrovib.solve.recursion import hold_weights, march

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.drive.pieces import Linear

CHUNK = 1 << 16
"""Largest number of states in memory, so that a million samples need no gigabyte."""
MANY_SAMPLES = 20_000
"""Number of samples from which the block scan is faster than the closed form of each segment."""
_LONG = 8000
"""Mean number of times in each piece from which polynomials are faster than each time by itself."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""Largest deviation of an evenly spaced grid, over its last time."""


def straight_response(
    part: Linear,
    rates: Real,
    gains: Real,
    time: Real,
    state: Real,
    *,
    direct: Real | None = None,
    lag: NDArray[np.bool_] | None = None,
) -> Real:
    """Compute the response of modes to straight pieces at any times.

    `rates` (modes,), `gains` (outputs, modes), `time` (n,) [s], `state` (modes,) [V], `direct` (outputs,),
    `lag` (outputs,); returns `response` (outputs, n) [V].

    At the breaks themselves, and on an even grid that contains them, one recursion computes all outputs.
    """
    direct = np.zeros(len(gains)) if direct is None else direct
    lag = np.zeros(len(gains), bool) if lag is None else lag
    return np.array(straight_rows(part, rates, gains, time, state, direct=direct, lag=lag))


def straight_rows(
    part: Linear,
    rates: Real,
    gains: Real,
    time: Real,
    state: Real,
    *,
    direct: Real,
    lag: NDArray[np.bool_],
) -> list[Real]:
    """Compute the response of modes to straight pieces at any times, each output in an array of its own.

    Returns `response` (n,) [V].
    """
    marched = _marched(part, time)
    if marched is not None:
        output, _ = march(-rates, gains, direct, *marched, state, lag=lag)
        jump = float(part.value(time[-1:])[0] - marched[1][-1])
        if jump:  # at a discontinuity the value after it, at the last time as well
            for row, more in zip(
                output, (direct - np.where(lag, gains.sum(axis=1), 0.0)) * jump, strict=True
            ):
                row[-1] += more
        return list(output)
    index, elapsed = part.locate(time)
    periods = part.count_periods(time)
    states = BreakStates(part, rates, state, np.unique(np.concatenate([index, np.maximum(index - 1, 0)])))
    asked = _Asked(states, gains, direct, lag)
    begins = np.flatnonzero(np.append(True, (np.diff(index) != 0) | (np.diff(periods) != 0)))
    if len(time) < _LONG * len(begins):
        return list(asked.at(time, index, elapsed, periods))
    result = [np.empty(len(time)) for _ in gains]
    for first, last in zip(begins, [*begins[1:], len(time)], strict=True):
        where, period = index[first], periods[first]
        start = float(part.times[where] + period * (part.period or 0.0))

        def evaluate(
            since: Real, where: Indices = where, period: Indices = period, start: float = start
        ) -> Real:
            same = np.zeros(len(since), np.intp)
            return asked.at(start + since, same + where, since, same + period)

        for row, each in zip(
            result, graded(evaluate, elapsed[first:last], float(np.max(rates))), strict=True
        ):
            row[first:last] = each
    return result


@dataclass(frozen=True)
class _Asked:
    """Outputs of modes under straight pieces, from their states at the breaks."""

    states: BreakStates
    gains: Real
    direct: Real
    lag: NDArray[np.bool_]

    def at(self, time: Real, index: Indices, elapsed: Real, periods: Indices) -> Real:
        """Return the outputs at times [s] in known pieces [V], shape (outputs, n)."""
        part, rates = self.states.part, self.states.rates
        now = part.after[index] + elapsed * part.slope_of(index)
        result = np.outer(self.direct, now)
        if np.any(self.lag):
            result[self.lag] += lag_since_breaks(self.states, self.gains[self.lag], time)
        if not np.all(self.lag):
            own = self.gains[~self.lag]
            for piece in chunks(len(time), len(rates)):
                decay, begin, end = hold_weights(-rates[:, None] * elapsed[piece])
                began = part.after[index[piece]]
                known = self.states.at(index[piece], periods[piece])
                result[~self.lag, piece] += own @ (decay * known + begin * began + end * now[piece])
        return result


def lag_since_breaks(states: BreakStates, gains: Real, time: Real) -> Real:
    """Compute the response of modes to straight pieces less the drive itself, from the states at the breaks.

    Returns `response` (outputs, n) [V].
    """
    part, rates = states.part, states.rates
    result = np.zeros((len(gains), len(time)))
    index, elapsed = part.locate(time)
    periods = part.count_periods(time)
    first = (index == 0) & (periods == 0)
    back = (elapsed == 0) & ~first
    last = max(len(part.times) - 2, 0) if part.period is not None else 0
    before = np.where(back, np.where(index > 0, index - 1, last), index)
    periods = periods - (back & (index == 0))
    elapsed = np.where(back, part.length_of(before), elapsed)
    reached = part.before[np.where(index > 0, index, -1)]
    jump, slopes = np.where(back, part.after[index] - reached, 0.0), part.slope_of(before)
    for piece in chunks(len(time), len(rates)):
        fallen = np.expm1(-rates[:, None] * elapsed[piece])
        since = states.at(before[piece], periods[piece]) - part.after[before[piece]]
        lag = (1 + fallen) * since + slopes[piece] * fallen / rates[:, None] - jump[piece]
        result[:, piece] = gains @ lag
    return result


def chunks(samples: int, modes: int) -> list[slice]:
    """Split many times into intervals whose states fit in memory together."""
    length = max(1, CHUNK // modes)
    return [slice(first, first + length) for first in range(0, samples, length)]


def _marched(part: Linear, time: Real) -> tuple[Real, Real, Real | float] | None:
    """Return starts, ends and durations of the pieces between output times that include every break; otherwise None."""
    if part.begins_with(time):
        last = len(time) - 1
        steps = part.lengths[:last] if part.step is None else part.step
        return part.after[:last], part.before[1 : last + 1], steps
    even = _even_step(part, time)
    if even is None:
        return None
    before, after = _sides(part.until(float(time[-1])), time)
    return after[:-1], before[1:], even


def _even_step(part: Linear, time: Real) -> float | None:
    """Return the step of an even grid that begins at 0 and includes every break, if there are many samples."""
    if len(time) < MANY_SAMPLES or time[0] != 0:
        return None
    end = float(time[-1])
    if part.count_breaks(end) > len(time):
        return None
    step, rounding = end / (len(time) - 1), ROUNDING * end
    times = part.until(end).times
    breaks = times[times <= end + rounding]
    off = np.max(np.abs(breaks - step * np.round(breaks / step)))
    uneven = np.max(np.abs(time - step * np.arange(len(time))))
    return step if max(off, uneven) <= rounding else None


def _sides(part: Linear, time: Real) -> tuple[Real, Real]:
    """Return the drive just before and just after each time of a grid that includes every break."""
    step = float(time[-1]) / (len(time) - 1)
    after = part.value(time)
    before = after.copy()
    inside = part.times <= time[-1] * (1 + ROUNDING)
    places = np.round(part.times[inside] / step).astype(int)
    before[places], after[places] = part.before[inside], part.after[inside]
    return before, after
