"""Very long records on an even grid, for which loading the compiled recursion costs less than it saves."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.blocks import BlockWeights
    from electrovib.solve.recursion.inputs import Inputs

_WORTH: Final = 100_000_000
"""Samples times outputs from which loading the compiled code costs less time than it saves."""
_ALIGNED: Final = 8  # numbers in a line of the cache


def long_block(gains: Numbers, inputs: Inputs, keep: int) -> int:
    """Return the samples in a block of the compiled recursion, where it is faster.

    Parameters
    ----------
    gains : ndarray, (outputs, poles)
        Share of every mode in every output; only real ones are supported.
    inputs : Inputs
        Signals that drive the modes; only a continuous drive is supported.
    keep : int
        Outputs are computed at every ``keep``-th sample; only 1 is supported.

    Returns
    -------
    block : int
        Number of samples; 0 where the recursion by matrix products is to be used.

    Notes
    -----
    The choice depends on the size of the record alone, so that a result does not depend on what ran before it.
    """
    many = inputs.signals[0].size * len(gains) >= _WORTH
    if not many or keep > 1 or len(inputs.signals) > 1 or np.iscomplexobj(gains) or not gains.size:
        return 0
    kernel = _kernel()
    return 0 if kernel is None else int(kernel.WIDTH)


def follow_long(signal: Real, records: Sequence[Real], weights: BlockWeights, z: Real, state: Real) -> Real:
    """Write the outputs of all whole blocks, and return the state after the last one.

    Parameters
    ----------
    signal : ndarray, (blocks * block,)
        Samples.
    records : sequence of ndarray, (blocks, block)
        One contiguous array for each output, which is written into it.
    weights : BlockWeights
        For blocks of as many samples as `long_block` returns.
    z : ndarray, (poles,)
        Poles times step [-].
    state : ndarray, (poles,)
        State of the recursion before the first block.

    Returns
    -------
    state : ndarray, (poles,)
        State of the recursion after the last block.

    Notes
    -----
    With vectors of as many samples as a block has, the outputs of a block are y = T v + P z and the next state is
    a^block z + G v: each column of T and P is a vector of outputs, each column of G vectors of modes. The rounding of
    a^block, of which the state takes a high power, is compensated after each 512 blocks.
    """
    kernel = _kernel()
    assert kernel is not None
    block, modes = int(kernel.WIDTH), z.size
    size = modes + -modes % block
    onto_output = _aligned(len(records) * (block + modes) * block).reshape(len(records), -1)
    onto_output[:] = weights.onto_output.reshape(len(records), -1)
    onto_state, own = _aligned(block * size).reshape(block, size), _aligned(3 * size).reshape(3, size)
    onto_state[:, :modes] = weights.onto_state[0]
    decay = np.exp(block * z)
    own[0, :modes], own[2, :modes] = decay, state
    # 1 - decay is exact: the difference from -expm1 is the error of the decay as rounded
    error = np.where(decay > 0.5, (np.expm1(block * z) + (1.0 - decay)) / np.maximum(decay, 0.5), 0.0)
    own[1, :modes] = 1.0 + kernel.COMPENSATED * error
    addresses = np.array([record.ctypes.data for record in records], np.int64)
    states = _aligned(kernel.BLOCKS * size)
    kernel.follow_blocks(
        signal, addresses, onto_output, onto_state.reshape(-1), own[0], own[1], own[2], states
    )
    return np.array(own[2, :modes])


def _aligned(size: int) -> Real:
    """Return zeros that begin at a line of the cache."""
    whole = np.zeros(size + _ALIGNED)
    begin = -(whole.ctypes.data // whole.itemsize) % _ALIGNED
    return whole[begin : begin + size]


@functools.cache
def _kernel() -> Any:
    """Return the compiled recursion; None where numba is not installed, or the processor has no vectors that it uses."""
    try:
        from electrovib.solve.recursion.vectors.width import WIDTH

        if WIDTH == 1:
            return None
        from electrovib.solve.recursion import compiled_blocks
    except ImportError:
        return None
    return compiled_blocks
