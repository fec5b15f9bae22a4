"""The recursion on an even grid: small matrix products over blocks of samples, and the exact weights of one straight piece."""

from __future__ import annotations

from math import factorial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.arrays import Indices, Numbers, Real

if TYPE_CHECKING:
    from collections.abc import Sequence

# 1/2!, 1/3!, ...: the first term left out is below 1e-17 of the sum for every |z| < 1
_SERIES = [1.0 / factorial(order) for order in range(2, 19)]
SLOW: Final = 1 / 32
"""Rate times usual step up to which the state of a mode is advanced in an uneven record; of faster modes it is the lag."""


class Modes(NamedTuple):
    """Modes and their shares in each output.

    Parameters
    ----------
    poles : ndarray, (poles,)
        Rates [1/s]: negative, or complex with a negative real part.
    gains : ndarray, (outputs, poles)
        Share of every mode in every output [-], doubled for a mode that represents a pair. The output is the real part
        of the sum.
    direct : ndarray, (outputs,)
        Share of the drive itself in every output [-].
    lag : ndarray of bool, (outputs,)
        Whether an output takes the lag of every mode behind the drive in the place of the mode.
    """

    poles: Numbers
    gains: Numbers
    direct: Real
    lag: NDArray[np.bool_]


class StraightDrive(NamedTuple):
    """A drive of straight pieces.

    Parameters
    ----------
    starts, ends : ndarray, (pieces,)
        Drive just after the beginning and just before the end of each piece.
    steps : ndarray, (pieces,) or ()
        Durations [s]; one number when all are equal.
    """

    starts: Real
    ends: Real
    steps: Real

    def jumps(self) -> Real | None:
        """Return the drop of the drive at the beginning of each piece, or None for a continuous drive."""
        before, after = self.ends[:-1], self.starts[1:]
        same_memory = before.ctypes.data == after.ctypes.data  # both are contiguous and equally long
        if same_memory or np.array_equal(before, after):
            return None
        return np.concatenate(([0.0], before - after))


def gather(*given: ArrayLike, lag: ArrayLike = False) -> tuple[Modes, StraightDrive, Numbers]:
    """Convert the arguments of `march` into contiguous arrays.

    Returns `state` (poles,).
    """
    poles, gains, direct, starts, ends, steps, initial_state = given
    kind = np.complex128 if np.iscomplexobj(poles) else np.float64
    shares = np.ascontiguousarray(direct, np.float64)
    modes = Modes(
        np.ascontiguousarray(poles, kind),
        np.ascontiguousarray(gains, kind),
        shares,
        np.broadcast_to(np.asarray(lag, bool), shares.shape),
    )
    sides = [np.ascontiguousarray(each, np.float64) for each in (starts, ends)]
    drive = StraightDrive(sides[0], sides[1], np.asarray(steps, np.float64))
    state: Numbers = np.array(initial_state, kind)
    if kind is np.complex128:
        modes = modes._replace(gains=modes.gains * np.where(modes.poles.imag == 0.0, 1.0, 2.0))
    if drive.steps.ndim and drive.steps.min() == drive.steps.max():
        drive = drive._replace(steps=drive.steps[0])
    return modes, drive, state


def hold_weights(z: ArrayLike) -> tuple[Numbers, Numbers, Numbers]:
    """Compute the weights of the old state and of both ends of a straight piece of drive, for a real or a complex mode.

    For ``x' = p (x - v)``, ``z = p h`` and ``u = -z`` the step is ``x(h) = decay x(0) + first v(0+) + last v(h-)`` with
    ``decay = exp(-u)``, ``first = (1 - exp(-u))/u - exp(-u)`` and ``last = 1 - (1 - exp(-u))/u``. Both differences cancel
    for small ``u``; there ``first = exp(-u) (u/2! + u^2/3! + ...)`` and ``last = 1 - exp(-u) - first``, which keep every
    digit. The relative error is about 1e-15 for every real ``z`` between -1e300 and -1e-300 (``decay`` itself becomes
    subnormal below -708); of an oscillating mode with ``|z| > 1`` it is that of the larger of the two terms of ``first``,
    which itself passes through zero near u = 2.1 + 7.5j (and further out). A positive ``z`` is a growing mode and gives
    meaningless weights.
    """
    exponent = np.asarray(z, np.complex128 if np.iscomplexobj(z) else np.float64)
    fall, is_small = -exponent, np.abs(exponent) < 1.0
    decay, rise = np.exp(exponent), -np.expm1(exponent)
    small = np.where(is_small, fall, 0.0)
    series = np.full_like(small, _SERIES[-1])
    for term in _SERIES[-2::-1]:
        series *= small
        series += term
    series *= small
    mean = rise / np.where(is_small, 1.0, fall)
    first = np.where(is_small, decay * series, mean - decay)
    last = np.where(is_small, rise - first, 1.0 - mean)
    return decay, first, last


_BLOCK = 32  # samples: a shorter block needs more states, a longer one multiplies more zeros of the triangle
_LONG = 64  # the same where only the states at some samples are wanted
_HELD = 1 << 17  # numbers in memory together: they fit in the second-level cache
_SHAPE = 1 / 3  # columns of a scan over the root of its intervals: each column is five calls
# Multiplications in one product: OpenBLAS keeps these on one thread. More threads gain a quarter on idle
# cores, and lose up to a hundredfold when another process uses one of them.
PRODUCT = 4 * 65536


class _Weights(NamedTuple):
    """Weights of the signals of a drive in the recursion: its values or its rises, and its drops if it is discontinuous.

    Parameters
    ----------
    lag : bool
        Whether the recursion's state is the lag behind the drive.
    now, later : ndarray, (signals, poles)
        Weight of a sample in the recursion's state at once, and one step later.
    shift : ndarray, (poles,)
        Share of the drive that is added to the recursion's state to obtain the mode.
    """

    lag: bool
    now: Numbers
    later: Numbers
    shift: Numbers


def _weights(z: Numbers, *, drops: bool, lag: bool = False) -> _Weights:
    """Return the weights of values of a drive in the recursion, or of its rises.

    With values, the recursion's state is ``w = x - last v``, ``w' = decay w + (decay last + first) v``: a continuous
    drive enters once, and not as starts and ends. With rises it is the lag ``x - v`` itself, which becomes
    ``decay (x - v) - (1 - last) rise``: the small lag of a mode that follows the drive closely is then not the
    difference of two large numbers.
    """
    (decay, first, last), zero, count = hold_weights(z), np.zeros_like(z), 1 + drops
    if lag:
        now, later, shift = [zero, zero + 1.0], [last - 1.0, decay], zero
    else:
        now, later, shift = [zero, last], [decay * last + first, decay * last], last
    return _Weights(lag, np.stack(now[:count]), np.stack(later[:count]), shift)


def _signals(drive: StraightDrive, jumps: Real | None, part: slice, *, lag: bool) -> list[Real]:
    """Return one number of each signal for every step of a part of the drive."""
    first = drive.ends[part] - drive.starts[part] if lag else drive.starts[part]
    return [first] if jumps is None else [first, jumps[part]]


class _Together:
    """Outputs that take the modes, or their lags, with the recursion's state at the point that is reached."""

    def __init__(
        self, modes: Modes, z: Numbers, state: Numbers, start: float, *, lag: bool, drops: bool
    ) -> None:
        self.places, self.z = np.flatnonzero(modes.lag == lag), z
        self.direct = modes.direct[self.places]
        self.weights = _weights(z, drops=drops, lag=lag)
        self.state = state - (start if lag else self.weights.shift * start)
        self.onto_state = _onto_state(self.weights, z, _BLOCK)
        direct = np.zeros_like(self.direct) if lag else self.direct
        self.onto_output = _onto_output(modes.gains[self.places], direct, self.weights, z)

    def put_out(self, signals: Sequence[Real], at_end: float, output: Real) -> None:
        """Write the outputs at the beginnings of steps, and where there is one number more at the end of the last."""
        rows, z = [output[place] for place in self.places], self.z
        count = signals[0].size
        blocks, rest = divmod(count, _BLOCK)
        end, length = blocks * _BLOCK, max(1, _HELD // max(1, z.size))
        whole = [signal[:end].reshape(blocks, _BLOCK) for signal in signals]
        records = [row[:end].reshape(blocks, _BLOCK) for row in rows]
        for first in range(0, blocks, length):
            part = slice(first, min(first + length, blocks))
            seen = [signal[part] for signal in whole]
            states = _states_before_blocks(seen, self.onto_state, z, self.state)
            given = np.concatenate([*seen, numbers(states[:-1])], axis=1)
            _multiply(given, self.onto_output, [record[part] for record in records])
            self.state = states[-1]
        if not rest and output.shape[1] == count:
            return
        tail = np.zeros((len(whole), 1, _BLOCK))  # the samples left over and the last point
        tail[:, 0, :rest] = [signal[end:] for signal in signals]
        pushed = (np.roll(tail, -rest, axis=2).reshape(-1) @ self.onto_state).view(z.dtype)
        tail[0, 0, rest] = at_end
        last = np.empty((len(rows), 1, _BLOCK))
        given = np.concatenate([*tail, numbers(self.state[np.newaxis])], axis=1)
        _multiply(given, self.onto_output, list(last))
        for row, each in zip(rows, last, strict=True):
            row[end:] = each[0, : output.shape[1] - end]
        self.state = np.asarray(np.exp(rest * z) * self.state + pushed)


class EvenMarch:
    """The response of relaxing or oscillating modes to a drive with pieces of equal duration, one part after the other.

    Within a block the output is a triangular matrix of the impulse response times the samples, plus the free decay of
    the recursion's states (``_Weights``) from the beginning of the block.
    """

    def __init__(self, modes: Modes, drive: StraightDrive, state: Numbers) -> None:
        self.drive, self.jumps, z = drive, drive.jumps(), modes.poles * drive.steps
        given, drops = (modes, z, state, drive.starts[0]), self.jumps is not None
        self.lagging = _Together(*given, lag=True, drops=drops) if np.any(modes.lag) else None
        self.others = _Together(*given, lag=False, drops=drops)

    def through(self, part: slice, output: Real) -> Numbers:
        """Write the outputs at the beginnings of some pieces, those after the ones before, and return the states at their end.

        `output` (outputs, n), or (outputs, n + 1) with the last point.
        """
        drive, at_end = self.drive, float(self.drive.ends[part.stop - 1])
        if (lagging := self.lagging) is not None:
            lagging.put_out(_signals(drive, self.jumps, part, lag=True), 0.0, output)
            for place, direct in zip(lagging.places, lagging.direct, strict=True):
                if direct:
                    count = part.stop - part.start
                    output[place, :count] += direct * drive.starts[part]
                    output[place, count:] += direct * at_end
        self.others.put_out(_signals(drive, self.jumps, part, lag=False), at_end, output)
        return np.asarray(self.others.state + self.others.weights.shift * at_end)


def even_states(modes: Modes, drive: StraightDrive, state: Numbers, places: Indices) -> Numbers:
    """Return the states at some points of a drive with pieces of equal duration.

    `places` (n,); returns `states` (poles, n).
    """
    z, jumps = modes.poles * drive.steps, drive.jumps()
    block = _LONG if len(places) * _LONG > drive.starts.size else 4 * _LONG
    weights = _weights(z, drops=jumps is not None)
    onto_state, blocks = _onto_state(weights, z, block), drive.starts.size // block
    signals = _signals(drive, jumps, slice(None), lag=False)
    whole = [signal[: blocks * block].reshape(blocks, block) for signal in signals]
    states = _states_before_blocks(whole, onto_state, z, state - weights.shift * drive.starts[0])
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
    return np.asarray((found + level[:, np.newaxis] * weights.shift).T)


def _onto_output(gains: Numbers, direct: Real, inputs: _Weights, z: Numbers) -> Real:
    """Return the weights of the samples of a block and of the state before it in the outputs of the block.

    Returns `weights` (outputs, signals * block + numbers, block): upper triangles of the impulse responses, then the free
    decay of every mode. A mode with a real pole is one number; with a complex pole it is two, real part and imaginary
    part, so that every product is one of real numbers.
    """
    responses = np.einsum("ok,snk->osn", gains, _responses(inputs, z, _BLOCK - 1)).real
    responses[:, 0, 0] += direct + (gains @ inputs.shift).real
    since = np.arange(_BLOCK) - np.arange(_BLOCK)[:, np.newaxis]
    triangles = np.where(since >= 0, responses[:, :, np.maximum(since, 0)], 0.0)
    decays = np.exp(np.multiply.outer(np.arange(_BLOCK), z))
    free = numbers(np.conj(gains[:, np.newaxis] * decays)).swapaxes(1, 2)
    return np.concatenate([triangles.reshape(len(gains), len(inputs.now) * _BLOCK, _BLOCK), free], axis=1)


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


def states_before(pushes: Numbers, z: Numbers, state: Numbers) -> Numbers:
    """Return the states of modes before every interval and after the last, from the increment in each interval.

    `pushes` (intervals, poles), `z` (intervals, poles) or, of equal intervals, (poles,) [-], `state` (poles,); returns
    `states` (intervals + 1, poles).

    The intervals are the entries of a table, row by row. All rows are computed in parallel from rest, their beginnings are
    chained by doubling the distance, then all rows are computed in parallel again. Rounding accumulates over one row plus the
    logarithm of their number, not over the whole record.
    """
    columns = int(np.ceil(_SHAPE * np.sqrt(len(pushes) + 1)))
    rows = -(-(len(pushes) + 1) // columns)
    table = _fold(pushes, columns, rows)
    each = z if z.ndim == 1 else _fold(z, columns, rows)
    decays = np.broadcast_to(np.exp(each), table.shape)
    carried = np.zeros_like(table[0])
    for decay, push in zip(decays, table, strict=True):
        carried *= decay
        carried += push
    of_rows = np.exp(columns * z if z.ndim == 1 else each.sum(axis=0)) + np.zeros_like(carried)
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


def _fold(intervals: Numbers, columns: int, rows: int) -> Numbers:
    """Return numbers of successive intervals, (intervals, poles), as a table (columns, rows, poles) filled up with zeros."""
    table = np.zeros((columns, rows, intervals.shape[1]), intervals.dtype)
    whole, rest = divmod(len(intervals), columns)
    table[:, :whole] = intervals[: whole * columns].reshape(whole, columns, intervals.shape[1]).swapaxes(0, 1)
    table[:rest, whole : whole + 1] = intervals[whole * columns :, np.newaxis]
    return table
