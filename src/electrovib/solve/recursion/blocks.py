"""The recursion on an even grid, as small matrix products over blocks of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.hold import hold_weights

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Indices, Numbers, Real
    from electrovib.solve.recursion.hold import Modes, StraightDrive

_BLOCK = 32  # samples: a shorter block needs more states, a longer one multiplies more zeros of the triangle
_LONG = 64  # the same where only the states at some samples are wanted
_HELD = 1 << 17  # numbers in memory together: they fit in the second-level cache
# Multiplications in one product: OpenBLAS keeps these on one thread. More threads gain a quarter on idle
# cores, and lose up to a hundredfold when another process uses one of them.
PRODUCT = 4 * 65536


class _Inputs(NamedTuple):
    """One number of each signal per step, and its weights in the recursion.

    Parameters
    ----------
    signals : list of ndarray, (pieces,)
        Values of the drive or its rises, and its drops at the beginning of each piece if it is discontinuous.
    at_end : float
        Value of the first signal at the last point.
    now, later : ndarray, (signals, poles)
        Weight of a sample in the recursion's state at once, and one step later.
    shift : ndarray, (poles,)
        Share of the drive that is added to the recursion's state to obtain the mode.
    """

    signals: list[Real]
    at_end: float
    now: Numbers
    later: Numbers
    shift: Numbers


def _inputs(drive: StraightDrive, z: Numbers, *, lag: bool = False) -> _Inputs:
    """Return the values of a drive as the signals of the recursion, or its rises.

    With values, the recursion's state is ``w = x - last v``, ``w' = decay w + (decay last + first) v``: a continuous
    drive enters once, and not as starts and ends. With rises it is the lag ``x - v`` itself, which becomes
    ``decay (x - v) - (1 - last) rise``: the small lag of a mode that follows the drive closely is then not the
    difference of two large numbers.
    """
    (decay, first, last), jumps, zero = hold_weights(z), drive.jumps(), np.zeros_like(z)
    if lag:
        signals, at_end = [drive.ends - drive.starts], 0.0
        now, later, shift = [zero, zero + 1.0], [last - 1.0, decay], zero
    else:
        signals, at_end = [drive.starts], float(drive.ends[-1])
        now, later, shift = [zero, last], [decay * last + first, decay * last], last
    signals += [] if jumps is None else [jumps]
    count = len(signals)
    return _Inputs(signals, at_end, np.stack(now[:count]), np.stack(later[:count]), shift)


def march_even(modes: Modes, drive: StraightDrive, state: Numbers, output: Real) -> Numbers:
    """Compute the response of relaxing or oscillating modes to a drive with pieces of equal duration.

    `state` (poles,), `output` (pieces + 1,); returns `final_state` (poles,).

    Within a block the output is a triangular matrix of the impulse response times the samples, plus the free decay of
    the recursion's states (``_Inputs``) from the beginning of the block.
    """
    z, lagging, others = modes.poles * drive.steps, np.flatnonzero(modes.lag), np.flatnonzero(~modes.lag)
    if len(lagging):
        rows, inputs = [output[place] for place in lagging], _inputs(drive, z, lag=True)
        _put_out(rows, modes.gains[lagging], np.zeros(len(rows)), inputs, z, state - drive.starts[0])
        for row, direct in zip(rows, modes.direct[lagging], strict=True):
            if direct:
                row[:-1] += direct * drive.starts
                row[-1] += direct * drive.ends[-1]
    rows, inputs = [output[place] for place in others], _inputs(drive, z)
    begins = state - inputs.shift * drive.starts[0]
    final = _put_out(rows, modes.gains[others], modes.direct[others], inputs, z, begins)
    return np.asarray(final + inputs.shift * drive.ends[-1])


def _put_out(
    rows: Sequence[Real], gains: Numbers, direct: Real, inputs: _Inputs, z: Numbers, state: Numbers
) -> Numbers:
    """Write some of the outputs, and return the recursion's state at the last point."""
    onto_state, onto_output = _onto_state(inputs, z, _BLOCK), _onto_output(gains, direct, inputs, z)
    blocks, rest = divmod(inputs.signals[0].size, _BLOCK)
    end, length = blocks * _BLOCK, max(1, _HELD // max(1, z.size))
    whole = [signal[:end].reshape(blocks, _BLOCK) for signal in inputs.signals]
    records = [row[:end].reshape(blocks, _BLOCK) for row in rows]
    for first in range(0, blocks, length):
        part = slice(first, min(first + length, blocks))
        seen = [signal[part] for signal in whole]
        states = _states_before_blocks(seen, onto_state, z, state)
        _multiply([*seen, numbers(states[:-1])], onto_output, [record[part] for record in records])
        state = states[-1]
    tail = np.zeros((len(whole), 1, _BLOCK))  # the samples left over and the last point
    tail[:, 0, :rest] = [signal[end:] for signal in inputs.signals]
    pushed = (np.roll(tail, -rest, axis=2).reshape(-1) @ onto_state).view(z.dtype)
    tail[0, 0, rest] = inputs.at_end
    last = np.empty((len(rows), 1, _BLOCK))
    _multiply([*tail, numbers(state[np.newaxis])], onto_output, list(last))
    for row, each in zip(rows, last, strict=True):
        row[end:] = each[0, : rest + 1]
    return np.asarray(np.exp(rest * z) * state + pushed)


def even_states(modes: Modes, drive: StraightDrive, state: Numbers, places: Indices) -> Numbers:
    """Return the states at some points of a drive with pieces of equal duration.

    `places` (n,); returns `states` (poles, n).
    """
    z = modes.poles * drive.steps
    inputs, block = _inputs(drive, z), _LONG if len(places) * _LONG > drive.starts.size else 4 * _LONG
    onto_state, blocks = _onto_state(inputs, z, block), drive.starts.size // block
    whole = [signal[: blocks * block].reshape(blocks, block) for signal in inputs.signals]
    states = _states_before_blocks(whole, onto_state, z, state - inputs.shift * drive.starts[0])
    at, since = np.divmod(places, block)
    found = np.exp(since[:, np.newaxis] * z) * states[at]
    many = max(1, _HELD // block)
    for first in range(0, len(places), many):
        some = slice(first, first + many)
        before = places[some, np.newaxis] - block + np.arange(block)
        samples = [
            np.where(np.arange(block) >= block - since[some, np.newaxis], signal[np.maximum(before, 0)], 0.0)
            for signal in inputs.signals
        ]
        found[some] += (np.concatenate(samples, axis=1) @ onto_state).view(z.dtype)
    for signal, now in zip(inputs.signals[1:], inputs.now[1:], strict=True):  # the drop at a point itself
        found += np.append(signal, 0.0)[places, np.newaxis] * now
    level = np.append(drive.starts, drive.ends[-1])[places, np.newaxis]
    return np.asarray((found + level * inputs.shift).T)


def _onto_output(gains: Numbers, direct: Real, inputs: _Inputs, z: Numbers) -> Real:
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


def _onto_state(inputs: _Inputs, z: Numbers, block: int) -> Real:
    """Return the share of every sample of a block in the state before the next block, (signals * block, numbers)."""
    shares = numbers(_responses(inputs, z, block)[:, :0:-1])
    return shares.reshape(len(inputs.now) * block, shares.shape[2])


def _responses(inputs: _Inputs, z: Numbers, longest: int) -> Numbers:
    """Return the share of a sample in the state so many steps later, (signals, steps + 1, poles)."""
    decays = np.exp(np.multiply.outer(np.arange(longest), z))  # not decay**n, in which slow modes lose digits
    return np.concatenate([inputs.now[:, np.newaxis], inputs.later[:, np.newaxis] * decays], axis=1)


def numbers(modes: Numbers) -> Real:
    """Return the real and imaginary parts of modes side by side, (..., numbers); real modes are returned as they are."""
    return np.ascontiguousarray(modes).view(np.float64)


def _multiply(parts: Sequence[Real], weights: Sequence[Real] | Real, out: Sequence[Real]) -> None:
    """Write the products of parts side by side, (blocks, n) each, with each of the weights, on one thread."""
    height = max(1, PRODUCT // max(1, weights[0].size if len(weights) else 1))
    for begin in range(0, len(parts[0]) if len(out) else 0, height):
        tile = slice(begin, begin + height)
        left = np.concatenate([part[tile] for part in parts], axis=1)
        for right, product in zip(weights, out, strict=True):
            np.matmul(left, right, out=product[tile])


def _states_before_blocks(whole: Sequence[Real], onto_state: Real, z: Numbers, state: Numbers) -> Numbers:
    """Return the state before every whole block and after the last, (blocks + 1, poles)."""
    pushes = np.empty((len(whole[0]), onto_state.shape[1]))
    _multiply(whole, [onto_state], [pushes])
    return states_before(pushes.view(z.dtype), whole[0].shape[1] * z, state)


def states_before(pushes: Numbers, z: Numbers, state: Numbers) -> Numbers:
    """Return the states of modes before every interval and after the last, from the increment in each interval.

    `pushes` (intervals, poles), `z` (intervals, poles) or, of equal intervals, (poles,) [-], `state` (poles,); returns
    `states` (intervals + 1, poles).

    The intervals are the entries of a nearly square table, row by row. All rows are computed in parallel from rest, then
    their beginnings are chained, then all rows are computed in parallel again. Rounding accumulates over one row plus one
    column, not over the whole record.
    """
    columns = int(np.ceil(np.sqrt(len(pushes) + 1)))
    rows = -(-(len(pushes) + 1) // columns)
    table = _fold(pushes, columns, rows)
    each = z if z.ndim == 1 else _fold(z, columns, rows)
    decays = np.broadcast_to(np.exp(each), table.shape)
    of_rows = np.broadcast_to(np.exp(columns * z if z.ndim == 1 else each.sum(axis=0)), table.shape[1:])
    carried = np.zeros_like(table[0])
    for decay, push in zip(decays, table, strict=True):
        carried *= decay
        carried += push
    for found, decay in zip(carried, of_rows, strict=True):
        after = decay * state + found
        found[:] = state
        state = after
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
