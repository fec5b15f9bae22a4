"""The recursion on an even grid, as small matrix products over blocks of samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.recursion.hold import weights_of
from electrovib.solve.recursion.scan import fold_length, states_before

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.record import Drive, Modes

_BLOCK = 64  # samples; shorter costs more in states, longer costs more in the empty half of the triangle
# Multiplications in one product: OpenBLAS keeps these on one thread. More threads gain a quarter on idle
# cores, and lose up to a hundredfold when another process holds one of them.
PRODUCT = 4 * 65536


class BlockWeights(NamedTuple):
    """What the samples of a block and the state before it give to its output and to the next state.

    Parameters
    ----------
    onto_output : ndarray, (outputs, signals * used + numbers, kept)
        Upper triangles of the impulse responses, then the free decay of every mode. Samples after the last
        one kept are not used.
    onto_state : ndarray, (signals, block, numbers)
        Share of every sample in the state before the next block.

    Notes
    -----
    A mode with a real pole is one number; with a complex pole it is two, real part and imaginary part, so
    that every product is one of real numbers.
    """

    onto_output: Real
    onto_state: Real


def march_even(modes: Modes, drive: Drive, state: Numbers, keep: int) -> tuple[Real, Numbers]:
    """Follow relaxing or ringing modes through a drive whose pieces last equally long.

    Parameters
    ----------
    modes : Modes
        Poles, gains and direct share.
    drive : Drive
        Pieces with one duration for all.
    state : ndarray, (poles,)
        State at the first point.
    keep : int
        Every so many points one is put out; what lies between is not computed.

    Returns
    -------
    output : ndarray, (outputs, pieces // keep + 1)
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
    last = weights_of(z)[2]
    signals = [drive.starts] if jumps is None else [drive.starts, jumps]
    block = keep * max(1, _BLOCK // keep)
    weights = block_weights(modes, z, len(signals), block, keep)
    blocks, rest = divmod(drive.starts.size, block)
    whole = [signal[: blocks * block].reshape(blocks, block) for signal in signals]
    tail = np.zeros((len(signals), 1, block))  # the samples left over and the last point
    tail[:, 0, :rest] = [signal[blocks * block :] for signal in signals]
    states = block_states(whole, weights.onto_state, z, state - last * drive.starts[0])
    final = last * drive.ends[-1] + np.exp(rest * z) * states[blocks].view(z.dtype)
    final += np.einsum("sm,smk->k", tail[:, 0, :rest], weights.onto_state[:, block - rest :]).view(z.dtype)
    tail[0, 0, rest] = drive.ends[-1]
    kept, used = block // keep, block - keep + 1
    output = np.empty((modes.direct.size, drive.starts.size // keep + 1))
    for record, onto_output in zip(output, weights.onto_output, strict=True):
        inputs = [signal[:, :used] for signal in whole]
        _fill(record[: blocks * kept].reshape(blocks, kept), inputs, states[:blocks], onto_output)
        end = np.concatenate([*tail[:, 0, :used], states[blocks]])
        record[blocks * kept :] = end @ onto_output[:, : rest // keep + 1]
    return output, final


def block_weights(modes: Modes, z: Numbers, signals: int, block: int, keep: int) -> BlockWeights:
    """Spread the one-step weights over a block, for the drive alone or for the drive and its jumps.

    Parameters
    ----------
    modes : Modes
        Poles, gains and direct share.
    z : ndarray, (poles,)
        Poles times step [-].
    signals : int
        1 for the drive alone, 2 for the drive and its jumps.
    block : int
        Samples in a block.
    keep : int
        Every so many samples of a block one is put out.

    Returns
    -------
    BlockWeights
        What a block gives [-].
    """
    decay, first, last = weights_of(z)
    powers = np.exp(np.multiply.outer(np.arange(block + 1), z))  # not decay**n: slow modes lose digits
    after_drive = np.vstack([np.zeros_like(z), (decay * last + first) * powers[:-1]])
    kernels = np.stack([after_drive, last * powers])[:signals]  # (signals, samples since, poles)
    responses = np.einsum("ok,snk->osn", modes.gains, kernels).real
    responses[:, 0, 0] += modes.direct + (modes.gains @ last).real
    since = np.arange(0, block, keep) - np.arange(block - keep + 1)[:, np.newaxis]
    triangles = np.where(since >= 0, responses[:, :, np.maximum(since, 0)], 0.0)
    free = numbers(np.conj(modes.gains[:, np.newaxis] * powers[:block:keep])).swapaxes(1, 2)
    shape = (modes.direct.size, -1, block // keep)
    onto_output = np.concatenate([triangles.reshape(shape), free], axis=1)
    return BlockWeights(onto_output, numbers(np.ascontiguousarray(kernels[:, :0:-1])))


def numbers(modes: Numbers) -> Real:
    """Lay real and imaginary parts side by side, or leave real modes as they are.

    Parameters
    ----------
    modes : ndarray, (..., poles)
        float64 or complex128.

    Returns
    -------
    ndarray, (..., numbers)
        float64, in the unit of the modes.
    """
    return np.ascontiguousarray(modes).view(np.float64)


def block_states(whole: Sequence[Real], onto_state: Real, z: Numbers, state: Numbers) -> Real:
    """Give the state before every whole block and after the last.

    Parameters
    ----------
    whole : sequence of ndarray, (blocks, block)
        Drive, and its jumps if there are any.
    onto_state : ndarray, (signals, block, numbers)
        From ``block_weights``.
    z : ndarray, (poles,)
        Poles times step [-].
    state : ndarray, (poles,)
        Before the first block, as ``w`` of ``march_even``.

    Returns
    -------
    ndarray, (blocks + 1, numbers)
        ``w``, in the unit of the drive.
    """
    blocks, block, width = len(whole[0]), *onto_state.shape[1:]
    columns, rows = fold_length(blocks + 1)
    states = np.zeros((rows * columns, width))
    for signal, weights in zip(whole, onto_state, strict=True):
        for tile in _tiles(blocks, weights):
            states[tile] += signal[tile] @ weights
    table = states.view(z.dtype).reshape(rows, columns, z.size).swapaxes(0, 1)
    states_before(table, np.exp(block * z), np.exp(block * columns * z), state)
    return states[: blocks + 1]


def _fill(output: Real, whole: Sequence[Real], states: Real, onto_output: Real) -> None:
    """Write the output of all whole blocks, (blocks, block), tile by tile."""
    for tile in _tiles(len(output), onto_output):
        inputs = np.concatenate([*(signal[tile] for signal in whole), states[tile]], axis=1)
        np.matmul(inputs, onto_output, out=output[tile])


def _tiles(blocks: int, weights: Real) -> Iterator[slice]:
    """Cut the blocks into tiles whose product with the weights stays on one thread."""
    height = max(1, PRODUCT // max(1, weights.size))  # no poles, no weights
    for begin in range(0, blocks, height):
        yield slice(begin, min(begin + height, blocks))
