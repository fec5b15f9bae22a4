"""Modes of many cases under straight pieces at any times: within a row of even times a response is a product of matrices.

A row crosses no break. A time s after its begin, the lag of a mode behind the drive is exp(-r s) lag + (exp(-r s) - 1) slope/r,
and the state exp(-r s) x + (1 - exp(-r s)) v + w(s) slope: numbers of the row times functions of s that all rows share. The lag
of a fast mode, and the state of a slow one, are no small differences of large numbers.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.physics.drive.parts import SLACK, Linear
from electrovib.solve.recursion import hold_weights
from electrovib.solve.recursion.blocks import PRODUCT, states_before

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Indices, Real
    from electrovib.solve.electrics.straight import InStretches, SharedModes

_ROUNDING: Final = 4 * float(np.finfo(float).eps)
"""Deviation of even times, over the last of them."""
_SLOW: Final = 1e-2
"""Rate times the last output time below which a mode is computed by its state, which is then that much smaller than the drive."""
_LEAST: Final = 1e-200
"""Rate in the place of 0 [1/s]."""
_FEW: Final = 16
"""Pieces that are followed one after the other."""
NOTHING: Final = Linear(np.zeros(1), np.zeros(1), np.zeros(1))
"""A drive of 0 V."""


class Rows:
    """Output times (n,) [s] in rows, and the drive of straight pieces at the begins of these.

    Attributes
    ----------
    piece, elapsed : ndarray, shape (rows,)
        Piece of each row, and the time from the begin of that to the begin of the row [s].
    since : ndarray, shape (longest,)
        Times since the begin of a row [s].
    places : ndarray of int, shape (n,)
        Where the outputs are in a table (rows, longest).
    """

    def __init__(self, part: Linear, time: Real) -> None:
        self.part, count = part.until(float(time[-1])), len(time)
        index, elapsed = self.part.locate(time)
        if part.period is not None:  # the times of a repeated break are rounded
            elapsed = np.where(elapsed > SLACK * time, elapsed, 0.0)
        step = float(time[-1] - time[0]) / max(count - 1, 1)
        even = np.max(np.abs(time - time[0] - step * np.arange(count))) <= _ROUNDING * time[-1]
        first = np.flatnonzero(np.diff(index, prepend=-1))
        inside = np.arange(count) - np.repeat(first, np.diff(first, append=count))
        begins = np.flatnonzero(inside % (math.isqrt(count) if even else 1) == 0)
        lengths = np.diff(begins, append=count)
        self.piece, self.elapsed = index[begins], elapsed[begins]
        self.since = step * np.arange(np.max(lengths))
        gaps = np.arange(len(begins)) * len(self.since) - begins
        self.places: Indices = np.arange(count) + np.repeat(gaps, lengths)
        self.slope = self.part.slope_of(self.piece)
        self.drive = self.part.after[self.piece] + self.elapsed * self.slope

    def lags(self, rates: Real, begin: Real) -> tuple[list[Real], list[Real]]:
        """Return numbers of the rows (cases, rows, modes) and functions (cases, modes, longest), whose products are the lags.

        `rates`, and the lags at time 0 `begin`, are (cases, modes).
        """
        part, last, rates = self.part, int(self.piece[-1]), np.maximum(rates, _LEAST)
        bends = part.slopes()[: last + 1, None] / rates[:, None]
        fallen = np.expm1(-rates[:, None] * part.lengths[:last, None])
        pushes = fallen * bends[:, :last] - part.jumps[1 : last + 1, None]
        at_breaks = self._chained(pushes, rates, begin)
        fallen = np.expm1(-rates[:, None] * self.elapsed[:, None])
        bends = bends.take(self.piece, axis=1)
        lags = fallen * bends
        fallen += 1
        lags += fallen * at_breaks.take(self.piece, axis=1)
        then = np.expm1(-rates[..., None] * self.since)
        return [lags, bends], [1 + then, then]

    def states(self, rates: Real, begin: Real) -> tuple[list[Real], list[Real]]:
        """Return the same of the states, which are `begin` at time 0."""
        part, every = self.part, slice(0, int(self.piece[-1]))
        _, first, last = hold_weights(-rates[:, None] * part.lengths[every, None])
        pushes = first * part.after[:-1][every, None] + last * part.before[1:][every, None]
        at_breaks = self._chained(pushes, rates, begin)
        drive, slope = self.drive[:, None], self.slope[:, None]
        decay, first, last = hold_weights(-rates[:, None] * self.elapsed[:, None])
        states = decay * at_breaks[:, self.piece] + first * part.after[self.piece][:, None] + last * drive
        decay, first, last = hold_weights(-rates[..., None] * self.since)
        rows = [states, np.broadcast_to(drive, states.shape), np.broadcast_to(slope, states.shape)]
        return rows, [decay, first + last, last * self.since]

    def _chained(self, pushes: Real, rates: Real, begin: Real) -> Real:
        """Return what decays from break to break, each time plus a push (cases, breaks - 1, modes): at all breaks."""
        count, fall = pushes.shape[1], -rates[:, None] * self.part.lengths[: pushes.shape[1], None]
        if count > _FEW:
            flat = [np.moveaxis(each, 1, 0).reshape(count, rates.size) for each in (pushes, fall)]
            found = states_before(flat[0], flat[1], begin.ravel())
            return np.moveaxis(found.reshape(count + 1, *rates.shape), 0, 1)
        found, decays = np.empty((len(rates), count + 1, rates.shape[1])), np.exp(fall)
        found[:, 0] = begin
        for place in range(count):
            found[:, place + 1] = decays[:, place] * found[:, place] + pushes[:, place]
        return found


def in_rows(modes: SharedModes, part: Linear, time: Real, begin: Real) -> InStretches:
    """Return the outputs (cases, n) of the modes of a stretch of cases under straight pieces at any times.

    `time` (n,) [s]; `begin` (cases or 1, modes) are the states at time 0 [V].
    """
    rows, lag = Rows(part, time), modes.lag.tolist()
    slow = np.any(modes.rates * time[-1] < _SLOW, axis=0) & ~np.all(lag)
    tables: dict[tuple[int, ...], Real] = {}  # kept: new memory takes longer than the products
    level = np.stack([np.ones(len(rows.since)), rows.since])[None]
    drive = np.stack([rows.drive, rows.slope], axis=1)

    def through(stretch: slice) -> list[Real]:
        mine, first = modes.some(stretch), some_cases(begin, stretch)
        lags, fading = rows.lags(mine.rates, first - part.after[0])
        states, following = rows.states(mine.rates[:, slow], first[:, slow]) if np.any(slow) else ([], [])
        then, found = _side_by_side([*fading, *following, level], axis=1), []
        for place, lagging in enumerate(lag):
            gains, follows = mine.gains[:, None, place], mine.direct[:, place, None]
            behind, state = gains, 0.0 * gains[..., slow]
            if not lagging:
                behind, state = np.where(slow, 0.0, gains), gains[..., slow]
                follows = follows + behind.sum(axis=2)
            weights = [behind * each for each in lags] + [state * each for each in states]
            left = _side_by_side([*weights, follows[..., None] * drive], axis=2)
            shape = len(left), left.shape[1], then.shape[2]
            if shape not in tables:
                tables[shape] = np.empty(shape)
            _multiply(left, then, tables[shape])
            found.append(tables[shape].reshape(len(left), -1).take(rows.places, axis=1))
        return found

    return through


def some_cases(numbers: Any, stretch: slice) -> Any:
    """Return the numbers of some cases; those that all cases share as they are."""
    return numbers if np.ndim(numbers) == 0 or len(numbers) == 1 else numbers[stretch]


def _side_by_side(arrays: Sequence[Real], axis: int) -> Real:
    """Return arrays of cases side by side; what cases share is repeated."""
    count = max(len(each) for each in arrays)
    same = [
        each if len(each) == count else np.broadcast_to(each, (count, *each.shape[1:])) for each in arrays
    ]
    return np.concatenate(same, axis=axis)


def _multiply(left: Real, right: Real, product: Real) -> None:
    """Write the products of the matrices of each case, each on one thread."""
    height = max(1, PRODUCT // max(1, right[0].size))
    for first in range(0, left.shape[1], height):
        some = slice(first, first + height)
        np.matmul(left[:, some], right, out=product[:, some])
