"""Two linear systems in series with a formula between them, without storing the intermediate signals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.recursion.blocks import PRODUCT, block_states, block_weights, march_even, numbers
from electrovib.solve.recursion.inputs import of_values
from electrovib.solve.recursion.record import StraightDrive, gather
from electrovib.solve.recursion.scan import fold_length, states_before

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.record import Modes

    System = tuple[ArrayLike, ArrayLike, float]

_BLOCK, _SHORTEST = 64, 16  # largest and smallest number of samples of the first system in a block
_PRODUCTS = 4  # products of the first system before the formula: some 20 000 samples, which fit in the second-level cache


def march_chain(
    first: System,
    formula: Callable[[NDArray[np.float64]], object],
    second: System,
    samples: ArrayLike,
    step: float,
    *,
    keep: int,
    settled: bool = False,
) -> NDArray[np.float64]:
    """Compute relaxing modes, a formula of their output, and oscillating modes driven by it, at every k-th sample.

    `samples` (n,); returns `output` (ceil(n / keep),).

    The result equals that of ``march``, the formula and ``march_pairs`` with ``keep``, up to rounding. Intermediate
    signals are computed in tiles that stay in the cache, and of the second system only the state at every k-th sample.
    Where ``keep`` has no divisor from 16 to 64, whole records are computed one after the other.
    """
    values = np.ascontiguousarray(samples, np.float64)
    if values.size < 2:
        raise InputError(f"march.samples has {values.size} numbers: give at least two.")
    sides = values[:-1], values[1:], step
    front, drive, rest = gather(
        first[0], np.atleast_2d(first[1]), [first[2]], *sides, np.zeros(np.size(first[0]))
    )
    none = np.zeros(np.size(second[0]))
    back, _, _ = gather(second[0], np.atleast_2d(second[1]), [second[2]], *sides, none, keep=keep, pairs=True)
    block = max(size for size in range(1, min(keep, _BLOCK) + 1) if keep % size == 0)
    if block < _SHORTEST:
        whole = np.empty(values.size)
        march_even(front, drive, rest, 1, [whole])
        formula(whole)
        start = np.full(back.poles.size, settled * whole[0], complex)
        kept = np.empty((values.size - 1) // keep + 1)
        march_even(back, StraightDrive(whole[:-1], whole[1:], drive.steps), start, keep, [kept])
        return kept
    z, rows = back.poles * step, (values.size - 1) // keep
    inputs = of_values(StraightDrive(values[:-1], values[1:], drive.steps), z)
    onto_state = block_weights(back.gains, back.direct, inputs, z, keep, keep).onto_state[0]
    columns, lines = fold_length(rows + 1)
    states, seen = np.zeros((lines * columns, onto_state.shape[1])), np.empty(rows + 1)
    for part, between in _between(front, formula, values, step, keep, block, rest):
        seen[part] = between[:, 0]
        if between.shape[1] == keep:
            np.matmul(between, onto_state, out=states[part])
    start = (float(settled) - inputs.shift) * seen[0]
    table = states.view(z.dtype).reshape(lines, columns, z.size).swapaxes(0, 1)
    states_before(table, np.exp(keep * z), np.exp(keep * columns * z), start)
    free = numbers(np.conj(back.gains[0]))
    output: Real = states[: rows + 1] @ free
    output += (back.direct[0] + float((back.gains[0] @ inputs.shift).real)) * seen
    return output


def _between(
    front: Modes,
    formula: Callable[[Real], object],
    values: Real,
    step: float,
    keep: int,
    block: int,
    state: Numbers,
) -> Iterator[tuple[slice, Real]]:
    """Yield the input of the second system, some rows of ``keep`` samples at a time, then the first remaining sample.

    The arrays share their memory: each has to be used before the next one is requested.
    """
    z, rows = front.poles * step, (values.size - 1) // keep
    inputs = of_values(StraightDrive(values[:-1], values[1:], np.asarray(step)), z)
    weights = block_weights(front.gains, front.direct, inputs, z, block, 1)
    whole = values[: rows * keep].reshape(rows * (keep // block), block)
    states = block_states([whole], weights.onto_state, z, state - inputs.shift * values[0])
    onto_output, each = weights.onto_output[0], keep // block
    height = max(1, PRODUCT // onto_output.size // each) * each  # blocks in one product
    seen, made = np.empty((height, len(onto_output))), np.empty((_PRODUCTS * height, block))
    for begin in range(0, len(whole), len(made)):
        stop = min(begin + len(made), len(whole))
        for first in range(begin, stop, height):
            part = slice(first, min(first + height, stop))
            size = part.stop - first
            np.concatenate([whole[part], states[part]], axis=1, out=seen[:size])
            np.matmul(seen[:size], onto_output, out=made[first - begin : part.stop - begin])
        formula(made[: stop - begin].reshape(-1))
        yield slice(begin // each, stop // each), made[: stop - begin].reshape(-1, keep)
    end = values[rows * keep]
    at_end = front.gains @ (states[-1] + inputs.shift * end) + front.direct * end
    formula(at_end)
    yield slice(rows, rows + 1), at_end[:, np.newaxis]
