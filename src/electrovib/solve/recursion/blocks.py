"""The recursion on an even grid, as small matrix products over blocks of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.hold import hold_weights
from electrovib.solve.recursion.scan import fold_length, states_before

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from electrovib.solve.recursion.record import Array, Drive, Modes

_BLOCK = 64  # samples; shorter costs more in states, longer costs more in the empty half of the triangle
# Multiplications in one product: OpenBLAS keeps these on one thread. More threads gain a quarter on idle
# cores, and lose up to a hundredfold when another process holds one of them.
_PRODUCT = 4 * 65536


class BlockWeights(NamedTuple):
    """What the samples of a block and the state before it give to its output and to the next state.

    Parameters
    ----------
    onto_output : ndarray, (outputs, signals * block + poles, block)
        Upper triangles of the impulse responses, then the free decay of every mode.
    onto_state : ndarray, (signals, block, poles)
        Share of every sample in the state before the next block.
    """

    onto_output: Array
    onto_state: Array


def march_even(modes: Modes, drive: Drive, state: Array) -> tuple[Array, Array]:
    """Follow relaxing modes through a drive whose pieces last equally long.

    Parameters
    ----------
    modes : Modes
        Poles, gains and direct share.
    drive : Drive
        Pieces with one duration for all.
    state : ndarray, (poles,)
        State at the first point.

    Returns
    -------
    output : ndarray, (outputs, pieces + 1)
        As in ``march``.
    state : ndarray, (poles,)
        State at the last point.

    Notes
    -----
    ``w = x - last v`` takes one input a step, ``w' = decay w + (decay last + first) v``, so a drive without
    jumps enters once and not as starts and ends. A jump adds ``last`` times its drop to ``w``. Within a
    block the output is a triangle of the impulse response times the samples, plus the free decay of ``w``
    from the beginning of the block.
    """
    z, jumps = modes.poles * drive.steps, drive.jumps()
    last = hold_weights(z)[2]
    signals = [drive.starts] if jumps is None else [drive.starts, jumps]
    weights = _block_weights(modes, z, len(signals))
    blocks, rest = divmod(drive.starts.size, _BLOCK)
    whole = [signal[: blocks * _BLOCK].reshape(blocks, _BLOCK) for signal in signals]
    tail = np.zeros((len(signals), 1, _BLOCK))  # the samples left over and the last point
    tail[:, 0, :rest] = [signal[blocks * _BLOCK :] for signal in signals]
    states = _block_states(whole, weights.onto_state, z, state - last * drive.starts[0])
    final = last * drive.ends[-1] + np.exp(rest * z) * states[blocks]
    final += np.einsum("sm,smk->k", tail[:, 0, :rest], weights.onto_state[:, _BLOCK - rest :])
    tail[0, 0, rest] = drive.ends[-1]
    output = np.empty((modes.direct.size, drive.starts.size + 1))
    for record, onto_output in zip(output, weights.onto_output, strict=True):
        _fill(record[: blocks * _BLOCK].reshape(blocks, _BLOCK), whole, states[:blocks], onto_output)
        end = np.concatenate([*tail[:, 0], states[blocks]])
        record[blocks * _BLOCK :] = end @ onto_output[:, : rest + 1]
    return output, final


def _block_weights(modes: Modes, z: Array, signals: int) -> BlockWeights:
    """Spread the one-step weights over a block, for the drive alone or for the drive and its jumps."""
    decay, first, last = hold_weights(z)
    powers = np.exp(np.multiply.outer(np.arange(_BLOCK + 1), z))  # not decay**n: slow modes lose digits
    after_drive = np.vstack([np.zeros_like(z), (decay * last + first) * powers[:-1]])
    kernels = np.stack([after_drive, last * powers])[:signals]  # (signals, samples since, poles)
    responses = np.einsum("ok,snk->osn", modes.gains, kernels)
    responses[:, 0, 0] += modes.direct + modes.gains @ last
    since = np.arange(_BLOCK) - np.arange(_BLOCK)[:, np.newaxis]
    triangles = np.where(since >= 0, responses[:, :, np.maximum(since, 0)], 0.0)
    free = modes.gains[:, :, np.newaxis] * powers[:_BLOCK].T
    onto_output = np.concatenate([triangles.reshape(modes.direct.size, -1, _BLOCK), free], axis=1)
    return BlockWeights(onto_output, np.ascontiguousarray(kernels[:, :0:-1]))


def _block_states(whole: Sequence[Array], onto_state: Array, z: Array, state: Array) -> Array:
    """Give the state before every whole block and after the last, (blocks + 1, poles)."""
    blocks = len(whole[0])
    columns, rows = fold_length(blocks + 1)
    states = np.zeros((rows * columns, z.size))
    for signal, weights in zip(whole, onto_state, strict=True):
        for tile in _tiles(blocks, weights):
            states[tile] += signal[tile] @ weights
    table = states.reshape(rows, columns, z.size).swapaxes(0, 1)
    states_before(table, np.exp(_BLOCK * z), np.exp(_BLOCK * columns * z), state)
    return states[: blocks + 1]


def _fill(output: Array, whole: Sequence[Array], states: Array, onto_output: Array) -> None:
    """Write the output of all whole blocks, (blocks, block), tile by tile."""
    for tile in _tiles(len(output), onto_output):
        inputs = np.concatenate([*(signal[tile] for signal in whole), states[tile]], axis=1)
        np.matmul(inputs, onto_output, out=output[tile])


def _tiles(blocks: int, weights: Array) -> Iterator[slice]:
    """Cut the blocks into tiles whose product with the weights stays on one thread."""
    height = max(1, _PRODUCT // max(1, weights.size))  # no poles, no weights
    for begin in range(0, blocks, height):
        yield slice(begin, min(begin + height, blocks))
