"""The recursion on an even grid, as small matrix products over blocks of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.inputs import of_rises, of_values
from electrovib.solve.recursion.long_records import follow_long, is_long
from electrovib.solve.recursion.scan import fold_length, states_before

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Numbers, Real
    from electrovib.solve.recursion.inputs import Inputs
    from electrovib.solve.recursion.record import Modes, StraightDrive

_BLOCK = 32  # samples: a shorter block needs more states, a longer one multiplies more zeros of the triangle
_LONG = 64  # the same where only the states at some samples are wanted
_HELD = 1 << 17  # states before blocks in memory together: they fit in the second-level cache
# Multiplications in one product: OpenBLAS keeps these on one thread. More threads gain a quarter on idle
# cores, and lose up to a hundredfold when another process uses one of them.
PRODUCT = 4 * 65536


class BlockWeights(NamedTuple):
    """Weights of the samples of a block and of the state before it in its outputs and in the next state.

    Parameters
    ----------
    onto_output : ndarray, (outputs, signals * used + numbers, kept)
        Upper triangles of the impulse responses, then the free decay of every mode. Samples after the last
        output of a block are not used.
    onto_state : ndarray, (signals, block, numbers)
        Share of every sample in the state before the next block.

    Notes
    -----
    A mode with a real pole is one number; with a complex pole it is two, real part and imaginary part, so
    that every product is one of real numbers.
    """

    onto_output: Real
    onto_state: Real


def march_even(
    modes: Modes, drive: StraightDrive, state: Numbers, keep: int, output: Sequence[Real]
) -> Numbers:
    """Compute the response of relaxing or oscillating modes to a drive with pieces of equal duration.

    `state` (poles,), `output` (pieces // keep + 1,); returns `final_state` (poles,).

    Within a block the output is a triangular matrix of the impulse response times the samples, plus the free decay of
    the recursion's states (``Inputs``) from the beginning of the block.
    """
    final = None
    z = modes.poles * drive.steps
    if not np.all(modes.lag):
        final = _put_out(output, ~modes.lag, modes, of_values(drive, z), z, state, drive, keep)
    if np.any(modes.lag):
        lags = _put_out(output, modes.lag, modes, of_rises(drive, z), z, state - drive.starts[0], drive, keep)
        for place in np.flatnonzero(modes.lag & (modes.direct != 0)).tolist():
            output[place][: -(-drive.starts.size // keep)] += modes.direct[place] * drive.starts[::keep]
            if drive.starts.size % keep == 0:
                output[place][-1] += modes.direct[place] * drive.ends[-1]
        final = lags + drive.ends[-1] if final is None else final
    assert final is not None
    return final


def _put_out(
    output: Sequence[Real],
    chosen: NDArray[np.bool_],
    modes: Modes,
    inputs: Inputs,
    z: Numbers,
    state: Numbers,
    drive: StraightDrive,
    keep: int,
) -> Numbers:
    """Write some of the outputs, and return the states at the last point, the share of the drive included."""
    gains, direct = modes.gains[chosen], np.where(modes.lag, 0.0, modes.direct)[chosen]
    places = np.flatnonzero(chosen).tolist()
    begins = state - inputs.shift * drive.starts[0]
    if is_long(gains, inputs, keep):
        last = follow_long(gains, direct, inputs, z, begins, [output[place] for place in places])
        return np.asarray(last + inputs.shift * drive.ends[-1])
    block = keep * max(1, _BLOCK // keep)
    weights = block_weights(gains, direct, inputs, z, block, keep)
    blocks, rest = divmod(drive.starts.size, block)
    whole = [signal[: blocks * block].reshape(blocks, block) for signal in inputs.signals]
    kept, used = block // keep, block - keep + 1
    records = [output[place][: blocks * kept].reshape(blocks, kept) for place in places]
    length = max(1, _HELD // max(1, z.size))
    for first in range(0, blocks, length):
        part = slice(first, min(first + length, blocks))
        seen = [signal[part] for signal in whole]
        states = block_states(seen, weights.onto_state, z, begins)
        begins = states[-1].view(z.dtype)
        seen = [signal[:, :used] for signal in seen]
        _fill([record[part] for record in records], seen, states[:-1], weights.onto_output)
    tail = np.zeros((len(whole), block))  # the samples left over and the last point
    tail[:, :rest] = [signal[blocks * block :] for signal in inputs.signals]
    final = inputs.shift * drive.ends[-1] + np.exp(rest * z) * begins
    final += np.einsum("sm,smk->k", tail[:, :rest], weights.onto_state[:, block - rest :]).view(z.dtype)
    tail[:, rest] = inputs.at_end
    end = np.concatenate([*tail[:, :used], numbers(begins)])
    for place, onto_output in zip(places, weights.onto_output, strict=True):
        output[place][blocks * kept :] = end @ onto_output[:, : rest // keep + 1]
    return np.asarray(final)


def even_states(modes: Modes, drive: StraightDrive, state: Numbers, places: Indices) -> Numbers:
    """Return the states at some points of a drive with pieces of equal duration.

    `places` (n,); returns `states` (poles, n).
    """
    z = modes.poles * drive.steps
    inputs = of_values(drive, z)
    block = _LONG if len(places) * _LONG > drive.starts.size else 4 * _LONG
    none = np.zeros((0, z.size), z.dtype)
    onto_state = block_weights(none, np.zeros(0), inputs, z, block, 1).onto_state
    blocks = drive.starts.size // block
    whole = [signal[: blocks * block].reshape(blocks, block) for signal in inputs.signals]
    begins, length = state - inputs.shift * drive.starts[0], max(1, _HELD // max(1, z.size))
    found = np.empty((len(places), z.size), z.dtype)
    for first in range(0, blocks + 1, length):
        last = min(first + length, blocks)
        states = block_states([signal[first:last] for signal in whole], onto_state, z, begins).view(z.dtype)
        here = slice(*np.searchsorted(places, [first * block, (first + length) * block]))
        at, since = np.divmod(places[here], block)
        found[here] = np.exp(since[:, np.newaxis] * z) * states[at - first]
        begins = states[-1]
    _add_samples(found, places, inputs, onto_state)
    level = np.append(drive.starts, drive.ends[-1])[places]
    return np.asarray((found + level[:, np.newaxis] * inputs.shift).T)


def _add_samples(found: Numbers, places: Indices, inputs: Inputs, onto_state: Real) -> None:
    """Add the response to the samples between the beginnings of blocks and some points to the states there."""
    block, many = onto_state.shape[1], max(1, _HELD // onto_state.shape[1])
    for first in range(0, len(places), many):
        some = slice(first, first + many)
        since = places[some, np.newaxis] % block
        before = places[some, np.newaxis] - block + np.arange(block)
        for signal, weights in zip(inputs.signals, onto_state, strict=True):
            samples = np.where(np.arange(block) >= block - since, signal[np.maximum(before, 0)], 0.0)
            found[some] += (samples @ weights).view(found.dtype)
    if len(inputs.signals) > 1:  # the drop at a point itself
        drops = np.append(inputs.signals[1], 0.0)[places]
        found += drops[:, np.newaxis] * inputs.now[1]


def block_weights(
    gains: Numbers, direct: Real, inputs: Inputs, z: Numbers, block: int, keep: int
) -> BlockWeights:
    """Compute the weights of a block from those of one step, for each signal of the drive.

    `gains` (outputs, poles) [-], `direct` (outputs,) [-], `z` (poles,) [-].
    """
    powers = np.exp(
        np.multiply.outer(np.arange(block + 1), z)
    )  # not decay**n, in which slow modes lose digits
    after = inputs.later[:, np.newaxis] * powers[:-1]
    kernels = np.concatenate([inputs.now[:, np.newaxis], after], axis=1)  # (signals, samples since, poles)
    responses = np.einsum("ok,snk->osn", gains, kernels).real
    responses[:, 0, 0] += direct + (gains @ inputs.shift).real
    since = np.arange(0, block, keep) - np.arange(block - keep + 1)[:, np.newaxis]
    triangles = np.where(since >= 0, responses[:, :, np.maximum(since, 0)], 0.0)
    free = numbers(np.conj(gains[:, np.newaxis] * powers[:block:keep])).swapaxes(1, 2)
    onto_output = np.concatenate(
        [triangles.reshape(len(gains), len(kernels) * len(since), block // keep), free], axis=1
    )
    return BlockWeights(onto_output, numbers(np.ascontiguousarray(kernels[:, :0:-1])))


def numbers(modes: Numbers) -> Real:
    """Return the real and imaginary parts of modes side by side; real modes are returned as they are.

    `modes` (..., poles); returns `parts` (..., numbers).
    """
    return np.ascontiguousarray(modes).view(np.float64)


def block_states(whole: Sequence[Real], onto_state: Real, z: Numbers, state: Numbers) -> Real:
    """Return the state before every whole block and after the last.

    `whole` (blocks, block), `onto_state` (signals, block, numbers), `z` (poles,) [-], `state` (poles,);
    returns `states` (blocks + 1, numbers).
    """
    blocks, block, width = len(whole[0]), *onto_state.shape[1:]
    columns, rows = fold_length(blocks + 1)
    together = onto_state.reshape(len(whole) * block, width)
    states = np.empty((rows * columns, width))
    states[blocks:] = 0.0
    for tile in _tiles(blocks, onto_state):
        np.matmul(np.concatenate([signal[tile] for signal in whole], axis=1), together, out=states[tile])
    table = states.view(z.dtype).reshape(rows, columns, z.size).swapaxes(0, 1)
    states_before(table, np.exp(block * z), np.exp(block * columns * z), state)
    return states[: blocks + 1]


def _fill(records: Sequence[Real], whole: Sequence[Real], states: Real, onto_output: Real) -> None:
    """Write the outputs of all whole blocks, (blocks, kept) each, tile by tile."""
    if not records:
        return
    for tile in _tiles(len(states), onto_output[0]):
        inputs = np.concatenate([*(signal[tile] for signal in whole), states[tile]], axis=1)
        for record, weights in zip(records, onto_output, strict=True):
            np.matmul(inputs, weights, out=record[tile])


def _tiles(blocks: int, weights: Real) -> Iterator[slice]:
    """Yield slices of the blocks whose product with the weights stays on one thread."""
    height = max(1, PRODUCT // max(1, weights.size))  # no poles, no weights
    for begin in range(0, blocks, height):
        yield slice(begin, min(begin + height, blocks))
