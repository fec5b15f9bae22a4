"""The recursion on an even grid, as small matrix products over blocks of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.hold import SLOW, hold_weights

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Indices, Numbers, Real
    from electrovib.solve.recursion.hold import Modes, StraightDrive

_BLOCK = 32  # samples: a shorter block needs more states, a longer one multiplies more zeros of the triangle
_LONG = 64  # the same where only the states at some samples are wanted
_HELD = 1 << 17  # numbers in memory together: they fit in the second-level cache
_SHAPE = 1 / 3  # columns of a scan over the root of its intervals: each column is five calls
# Multiplications in one product: OpenBLAS keeps these on one thread. More threads gain a quarter on idle
# cores, and lose up to a hundredfold when another process uses one of them.
PRODUCT = 4 * 65536


class _Weights(NamedTuple):
    """Weights of the signals of a drive in the recursion: its values or its rises, and its drops if it is discontinuous.

    `now`, `later` (signals, poles) are the weights of a sample in a mode, or in its lag behind the drive, at once and one step
    later.
    """

    now: Numbers
    later: Numbers


def _weights(z: Numbers, *, drops: bool, lag: bool = False) -> _Weights:
    """Return the weights of values of a drive in a mode, or of its rises in the lag of the mode.

    With values, the recursion's state is ``w = x - last v``, ``w' = decay w + (decay last + first) v``: a continuous
    drive enters once, and not as starts and ends. With rises it is the lag ``x - v`` itself, which becomes
    ``decay (x - v) - (1 - last) rise``: the small lag of a mode that follows the drive closely is then not the
    difference of two large numbers.
    """
    (decay, first, last), zero, count = hold_weights(z), np.zeros_like(z), 1 + drops
    if lag:
        now, later = [zero, zero + 1.0], [last - 1.0, decay]
    else:
        now, later = [last, last], [decay * last + first, decay * last]
    return _Weights(np.stack(now[:count]), np.stack(later[:count]))


class EvenMarch:
    """The response of relaxing or oscillating modes to a drive with pieces of equal duration, one part after the other.

    The state of a slow mode in the recursion is ``x - last v``, that of a fast one its lag ``x - v``: ``x - share v``. Within a
    block the output is a triangular matrix of the impulse response times the samples, plus the free decay of the states and of
    the value before the block that they lack. Outputs that take the modes have values as samples, those that take lags rises.
    """

    def __init__(self, modes: Modes, drive: StraightDrive, state: Numbers) -> None:
        self.drive, self.jumps = drive, drive.jumps()
        z, drops = modes.poles * drive.steps, self.jumps is not None
        fast = (-z.real > SLOW) & (np.any(modes.lag) and not np.iscomplexobj(z))
        self.order, self.slow = np.argsort(fast, kind="stable"), int(np.count_nonzero(~fast))
        self.z, gains = z[self.order], modes.gains[:, self.order]
        last = hold_weights(self.z)[2]
        self.share = np.where(fast[self.order], 1.0, last)
        self.state = state[self.order] - self.share * drive.starts[0]
        self.places = np.flatnonzero(modes.lag), np.flatnonzero(~modes.lag)
        self.onto_output: list[Real] = []
        for lag, places in zip((True, False), self.places, strict=True):
            weights = _weights(self.z, drops=drops, lag=lag)
            lacks = self.share - (1.0 if lag else last)
            self.onto_output.append(
                _onto_output(gains[places], modes.direct[places], weights, self.z, lacks, lag=lag)
            )
        self.onto_state = [
            _onto_state(_weights(some, drops=drops, lag=lag), some, _BLOCK)
            for some, lag in ((self.z[: self.slow], False), (self.z[self.slow :], True))
        ]

    def through(self, part: slice, output: Real) -> Numbers:
        """Write the outputs at the beginnings of some pieces, those after the ones before, and return the states at their end.

        `output` (outputs, n), or (outputs, n + 1) with the last point.
        """
        values, at_end = self.drive.starts[part], float(self.drive.ends[part.stop - 1])
        drops = [] if self.jumps is None else [self.jumps[part]]
        rises = [self.drive.ends[part] - values] if self.places[0].size else []
        signals = [*rises, *drops, values]
        blocks, rest = divmod(values.size, _BLOCK)
        end, length = blocks * _BLOCK, max(1, _HELD // max(1, self.z.size))
        whole = [signal[:end].reshape(blocks, _BLOCK) for signal in signals]
        for first in range(0, blocks, length):
            some = slice(first, min(first + length, blocks))
            seen = [signal[some] for signal in whole]
            states = states_before(self._pushes(seen), _BLOCK * self.z, self.state)
            self._put(seen, states[:-1], output[:, some.start * _BLOCK : some.stop * _BLOCK])
            self.state = states[-1]
        if rest or output.shape[1] > values.size:
            tail = np.zeros((len(signals), 1, _BLOCK))  # the samples left over and the last point
            tail[:, 0, :rest] = [signal[end:] for signal in signals]
            pushed = self._pushes(list(np.roll(tail, -rest, axis=2)))[0]
            tail[-1, 0, rest] = at_end
            last = np.empty((len(output), _BLOCK))
            self._put(list(tail), self.state[np.newaxis], last)
            output[:, end:] = last[:, : output.shape[1] - end]
            self.state = np.asarray(np.exp(rest * self.z) * self.state + pushed)
        states = np.empty_like(self.state)
        states[self.order] = self.state + self.share * at_end
        return states

    def _pushes(self, seen: Sequence[Real]) -> Numbers:
        """Return the increments of the states in every block: by its values of slow ones, by its rises of fast ones."""
        slow, fast = self.onto_state
        if not self.places[0].size:
            return _pushes(seen[::-1], slow).view(self.z.dtype)
        both = [_pushes(seen[:0:-1], slow), _pushes(seen[:-1], fast)]
        return np.concatenate(both, axis=1).view(self.z.dtype)

    def _put(self, seen: Sequence[Real], states: Numbers, output: Real) -> None:
        """Write the outputs in blocks, (outputs, blocks * samples), from the states before each."""
        *others, values = seen
        drops = others[-1:] if self.jumps is not None else []
        before = sum((each[:, :1] for each in drops), values[:, :1])
        given = np.concatenate([*others, numbers(states), before, values], axis=1)
        theirs = given[:, :-_BLOCK], given[:, _BLOCK if self.places[0].size else 0 :]
        for places, weights, own in zip(self.places, self.onto_output, theirs, strict=True):
            _multiply(own, weights, [output[place].reshape(len(given), _BLOCK) for place in places])


def even_states(modes: Modes, drive: StraightDrive, state: Numbers, places: Indices) -> Numbers:
    """Return the states at some points of a drive with pieces of equal duration.

    `places` (n,); returns `states` (poles, n).
    """
    z, jumps = modes.poles * drive.steps, drive.jumps()
    block = _LONG if len(places) * _LONG > drive.starts.size else 4 * _LONG
    weights, last = _weights(z, drops=jumps is not None), hold_weights(z)[2]
    onto_state, blocks = _onto_state(weights, z, block), drive.starts.size // block
    signals = [drive.starts] if jumps is None else [drive.starts, jumps]
    whole = [signal[: blocks * block].reshape(blocks, block) for signal in signals]
    states = _states_before_blocks(whole, onto_state, z, state - last * drive.starts[0])
    at, since = np.divmod(places, block)
    found = np.exp(since[:, np.newaxis] * z) * states[at]
    many = max(1, _HELD // block)
    for first in range(0, len(places), many):
        some = slice(first, first + many)
        before = places[some, np.newaxis] - block + np.arange(block)
        samples = [
            np.where(np.arange(block) >= block - since[some, np.newaxis], signal[np.maximum(before, 0)], 0.0)
            for signal in signals
        ]
        found[some] += _pushes(samples, onto_state).view(z.dtype)
    inside = np.minimum(places, drive.starts.size - 1)
    is_end = places == drive.starts.size
    for signal, now in zip(signals[1:], weights.now[1:], strict=True):  # the drop at a point itself
        found += np.where(is_end, 0.0, signal[inside])[:, np.newaxis] * now
    level = np.where(is_end, drive.ends[-1], drive.starts[inside])
    return np.asarray((found + level[:, np.newaxis] * last).T)


def _onto_output(
    gains: Numbers, direct: Real, weights: _Weights, z: Numbers, lacks: Numbers, *, lag: bool
) -> Real:
    """Return the weights in the outputs of a block, (outputs, numbers, block).

    They are those of rises, drops, states and the value before the block where outputs take lags, else of drops, states, value
    before the block and values: upper triangles of the impulse responses, and the free decay of every mode. A mode with a real
    pole is one number; with a complex pole it is two, real part and imaginary part, so that every product is one of real
    numbers. `lacks` (poles,) is the share of the value before the block that a mode, or its lag, has beyond the state.
    """
    responses = np.einsum("ok,snk->osn", gains, _responses(weights, z, _BLOCK - 1)).real
    decays = np.exp(np.multiply.outer(np.arange(_BLOCK), z))
    free = numbers(np.conj(gains[:, np.newaxis] * decays)).swapaxes(1, 2)
    before = (gains @ (lacks * decays).T).real[:, np.newaxis]
    if lag:  # the value is that before the block with the rises and without the drops since then
        responses[:, 0, 1:] += direct[:, np.newaxis]
        responses[:, 1:] -= direct[:, np.newaxis, np.newaxis]
        before += direct[:, np.newaxis, np.newaxis]
    else:
        responses[:, 0, 0] += direct
    since = np.arange(_BLOCK) - np.arange(_BLOCK)[:, np.newaxis]
    triangles = np.where(since >= 0, responses[:, :, np.maximum(since, 0)], 0.0).swapaxes(0, 1)
    parts = [*triangles[1:], free, before]
    return np.concatenate([triangles[0], *parts] if lag else [*parts, triangles[0]], axis=1)


def _onto_state(inputs: _Weights, z: Numbers, block: int) -> Real:
    """Return the share of every sample of a block in the state before the next block, (signals * block, numbers)."""
    shares = numbers(_responses(inputs, z, block)[:, :0:-1])
    return shares.reshape(len(inputs.now) * block, shares.shape[2])


def _responses(inputs: _Weights, z: Numbers, longest: int) -> Numbers:
    """Return the share of a sample in the state so many steps later, (signals, steps + 1, poles)."""
    decays = np.exp(np.multiply.outer(np.arange(longest), z))  # not decay**n, in which slow modes lose digits
    return np.concatenate([inputs.now[:, np.newaxis], inputs.later[:, np.newaxis] * decays], axis=1)


def numbers(modes: Numbers) -> Real:
    """Return the real and imaginary parts of modes side by side, (..., numbers); real modes are returned as they are."""
    return np.ascontiguousarray(modes).view(np.float64)


def _multiply(left: Real, weights: Sequence[Real] | Real, out: Sequence[Real]) -> None:
    """Write the products of an array (blocks, n) with each of the weights, on one thread."""
    height = max(1, PRODUCT // max(1, weights[0].size if len(weights) else 1))
    for begin in range(0, len(left) if len(out) else 0, height):
        tile = slice(begin, begin + height)
        for right, product in zip(weights, out, strict=True):
            np.matmul(left[tile], right, out=product[tile])


def _states_before_blocks(whole: Sequence[Real], onto_state: Real, z: Numbers, state: Numbers) -> Numbers:
    """Return the state before every whole block and after the last, (blocks + 1, poles)."""
    return states_before(_pushes(whole, onto_state).view(z.dtype), whole[0].shape[1] * z, state)


def _pushes(whole: Sequence[Real], onto_state: Real) -> Real:
    """Return the increment of the state in every block of samples, (blocks, numbers)."""
    samples = whole[0] if len(whole) == 1 else np.concatenate(whole, axis=1)
    pushes = np.empty((len(samples), onto_state.shape[1]))
    some = [slice(first, first + _BLOCK) for first in range(0, onto_state.shape[1], _BLOCK)]
    _multiply(samples, [onto_state[:, each] for each in some], [pushes[:, each] for each in some])
    return pushes


def states_before(pushes: Numbers, z: Numbers, state: Numbers, decays: Numbers | None = None) -> Numbers:
    """Return the states of modes before every interval and after the last, from the increment in each interval.

    `pushes` (intervals, poles), `z` (intervals, poles) or, of equal intervals, (poles,) [-], `state` (poles,), `decays` like
    `z`, its exponentials where they are known; returns `states` (intervals + 1, poles).

    The intervals are the entries of a table, row by row. All rows are computed in parallel from rest, their beginnings are
    chained by doubling the distance, then all rows are computed in parallel again. Rounding accumulates over one row plus the
    logarithm of their number, not over the whole record.
    """
    columns = int(np.ceil(_SHAPE * np.sqrt(len(pushes) + 1)))
    rows = -(-(len(pushes) + 1) // columns)
    table = _fold(pushes, columns, rows)
    each = np.exp(z) if decays is None else decays
    falls = columns * z if z.ndim == 1 else _sums(z, columns, rows)
    decays = np.broadcast_to(each if z.ndim == 1 else _fold(each, columns, rows), table.shape)
    carried = np.zeros_like(table[0])
    for decay, push in zip(decays, table, strict=True):
        carried *= decay
        carried += push
    of_rows = np.exp(falls) + np.zeros_like(carried)
    carried = np.concatenate([state[np.newaxis], carried[:-1]])
    apart = 1
    while apart < rows:
        carried[apart:] += of_rows[apart - 1 : -1] * carried[:-apart]
        of_rows[apart:] *= of_rows[:-apart]
        apart *= 2
    following = np.empty_like(carried)
    for decay, push in zip(decays, table, strict=True):
        np.multiply(carried, decay, out=following)
        following += push
        push[:] = carried
        carried, following = following, carried
    return table.swapaxes(0, 1).reshape(rows * columns, pushes.shape[1])[: len(pushes) + 1]


def _sums(intervals: Numbers, columns: int, rows: int) -> Numbers:
    """Return the sums of numbers of successive intervals, (intervals, poles), over each row of such a table, (rows, poles)."""
    sums = np.zeros((rows, intervals.shape[1]), intervals.dtype)
    found = np.add.reduceat(intervals, np.arange(0, len(intervals), columns), axis=0)
    sums[: len(found)] = found
    return sums


def _fold(intervals: Numbers, columns: int, rows: int) -> Numbers:
    """Return numbers of successive intervals, (intervals, poles), as a table (columns, rows, poles) filled up with zeros."""
    table = np.zeros((columns, rows, intervals.shape[1]), intervals.dtype)
    whole, rest = divmod(len(intervals), columns)
    table[:, :whole] = intervals[: whole * columns].reshape(whole, columns, intervals.shape[1]).swapaxes(0, 1)
    table[:rest, whole : whole + 1] = intervals[whole * columns :, np.newaxis]
    return table
