"""Very long records on an even grid, for which loading the compiled recursion costs less than it saves."""

from __future__ import annotations

import functools
import os
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.inputs import Inputs

_WORTH: Final = 100_000_000
"""Samples times outputs from which loading the compiled code costs less time than it saves."""
_ALIGNED: Final = 8  # numbers in a line of the cache
_LEAST: Final = 1024  # groups of blocks (4 million samples) from which a second thread is faster
_THREADS: Final = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_long(gains: Numbers, inputs: Inputs, keep: int) -> bool:
    """Return whether a record goes through the compiled recursion.

    `gains` (outputs, poles).

    The choice depends on the size of the record alone, so that a result does not depend on what ran before it.
    """
    many = inputs.signals[0].size * len(gains) >= _WORTH
    if not many or keep > 1 or len(inputs.signals) > 1 or np.iscomplexobj(gains) or not gains.size:
        return False
    return _kernel() is not None


def follow_long(
    gains: Real, direct: Real, inputs: Inputs, z: Real, state: Real, records: Sequence[Real]
) -> Real:
    """Write the outputs at all points, and return the state of the recursion at the last one.

    `gains` (outputs, poles) [-], `direct` (outputs,) [-], `z` (poles,) [-], `state` (poles,), `records`
    (pieces + 1,); returns `state` (poles,).

    With vectors of as many samples as a block has, the outputs of a block are y = T v + P z and the next state is
    a^block z + G v: each column of T and P is a vector of outputs, each column of G vectors of modes. The rounding of
    a^block, of which the state takes a high power, is compensated after each 512 blocks.

    A second thread computes the end of the record. It obtains the state there by the same operations as the first
    thread, without the outputs before it, so that the result does not depend on the number of threads.
    """
    kernel = _kernel()
    assert kernel is not None
    block, modes = int(kernel.WIDTH), z.size
    size = modes + -modes % block
    onto_output = aligned(len(gains) * (block + modes) * block).reshape(len(gains), -1)
    onto_output[:] = 0.0
    both = aligned((block + 2) * size)
    both[:] = 0.0
    onto_state, decays = both[: block * size], both[block * size :].reshape(2, size)
    level = direct + gains @ inputs.shift
    kernel.write_weights(z, gains, level, inputs.later[0], onto_output, onto_state, decays)
    signal, blocks = inputs.signals[0], inputs.signals[0].size // block
    addresses = np.array([record.ctypes.data for record in records], np.int64)
    weights = signal, addresses, onto_output, onto_state, *decays

    def follow(first: int, last: int) -> Real:
        """Return the state after `last` blocks; outputs are written from the block `first` on."""
        memory = aligned((kernel.BLOCKS + 1) * size)
        memory[:size] = 0.0
        memory[:modes] = state
        kernel.follow_blocks(*weights, memory[:size], memory[size:], first, last)
        return memory[:modes]

    cut = _cut(blocks, size * (block + 1), len(gains) * block * (block + modes), int(kernel.COMPENSATED))
    if cut and _THREADS > 1:
        with ThreadPoolExecutor(1) as pool:
            other = pool.submit(follow, 0, cut)
            found = follow(cut, blocks)
            other.result()
    else:
        found = follow(0, blocks)
    rest = signal.size - blocks * block
    ends = np.empty((len(gains), rest + 1))
    at_end = signal[blocks * block :], z, gains, level, inputs.later[0], float(inputs.at_end[0])
    kernel.write_end(*at_end, found, ends)
    for record, end in zip(records, ends, strict=True):
        record[blocks * block :] = end
    return found


def _cut(blocks: int, states: int, outputs: int, whole: int) -> int:
    """Return the blocks that the first of two threads follows, so that both take the same time; 0 for few blocks.

    `states` and `outputs` are the products of a block that give its state and its outputs; the second thread needs the
    states of all blocks.
    """
    share = (states + outputs) / (states + 2 * outputs)
    return int(blocks * share) // whole * whole if blocks >= _LEAST * whole else 0


def aligned(size: int) -> Real:
    """Return memory that begins at a line of the cache.

    Returns `memory` (size,).
    """
    whole = np.empty(size + _ALIGNED)
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
