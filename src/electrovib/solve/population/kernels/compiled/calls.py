"""Calls of the compiled kernels: memory, threads, and the order in which results are put together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.solve.population.kernels.compiled import tiles
from electrovib.solve.population.kernels.compiled.stepping import TIMES
from electrovib.solve.population.kernels.threads import in_threads, ranges
from electrovib.solve.population.kernels.time_steps import BLOCK
from electrovib.solve.recursion.vectors.width import WIDTH

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Indices, Real

_KNOWN: Final = 64  # durations of steps whose weights are in memory together
_TOGETHER: Final = 128  # fingers of one call
_INTERVAL: Final = 4096  # times whose moments are formed together
_ALIGNED: Final = 8  # numbers in a line of the cache


def name() -> str:
    """Return the version of numba and the width of the vectors."""
    import numba

    return f"numba {numba.__version__}, width {WIDTH}"


def aligned(size: int) -> Real:
    """Return memory that begins at a line of the cache.

    Returns `memory` (size,).
    """
    whole = np.empty(size + _ALIGNED)
    begin = -(whole.ctypes.data // whole.itemsize) % _ALIGNED
    return whole[begin : begin + size]


class SharedArguments:
    """Arguments that all tiles share."""

    def __init__(self, fingers: Any) -> None:
        kind, duration = fingers.steps
        starts = np.flatnonzero(np.diff(kind, prepend=-1)).astype(np.int64)
        self.pieces = np.append(starts, kind.size), kind[starts].astype(np.int64), duration
        self.fingers = fingers.rates, fingers.residues, fingers.direct, fingers.state
        self.voltage, self.kinds = fingers.voltage, max(1, duration.size)
        self.modes = fingers.rates.shape[1]

    def memory(self, tiles_: int) -> tuple[Real, Indices, Indices]:
        """Return memory of some tiles: for numbers, and for the indices and counts of durations."""
        slots = min(self.kinds, _KNOWN)
        size = (2 * self.modes + 2 + TIMES + slots * (5 * self.modes + 1)) * WIDTH
        size += -size % _ALIGNED
        return (
            aligned(tiles_ * size),
            np.zeros((tiles_, slots), np.int64),
            np.zeros((tiles_, self.kinds), np.int64),
        )


def step(fingers: Any, factor: Real | None, result: Any, threads: int | None) -> None:
    """Write the responses of fingers, or factor times their squares.

    `factor` (fingers,), `result` (fingers, n).
    """
    drive, factors = SharedArguments(fingers), np.zeros(0) if factor is None else factor

    def work(part: tuple[int, int]) -> None:
        memory, state = drive.memory(1), aligned(drive.modes * WIDTH)
        tiles.step_tiles(drive.fingers, factors, drive.voltage, drive.pieces, *part, *memory, state, result)

    in_threads(work, ranges(len(result), _TOGETHER), threads)


def square_moments(fingers: Any, factor: Real, threads: int | None) -> Sequence[tuple[int, Real, Real]]:
    """Return the moments of factor times the squared responses of each block.

    `factor` (fingers,).
    """
    drive = SharedArguments(fingers)
    found = _blocks(len(factor), fingers.voltage.size)
    parts = ranges(len(factor), BLOCK)
    length = min(_INTERVAL, fingers.voltage.size)

    def work(place: int) -> None:
        states = aligned(BLOCK * drive.modes)
        sums = aligned(2 * length * WIDTH).reshape(2, -1)
        memory, into = drive.memory(tiles.FOUR), found[place][1:]
        tiles.square_moments_of_block(
            drive.fingers,
            factor,
            drive.voltage,
            drive.pieces,
            parts[place],
            *memory,
            states,
            sums,
            *into,
        )

    in_threads(work, range(len(parts)), threads)
    return found


def moments(values: Any, threads: int | None) -> Sequence[tuple[int, Real, Real]]:
    """Return the moments of each block of rows of a table.

    `values` (fingers, n).
    """
    found = _blocks(*values.shape)
    parts = ranges(len(values), BLOCK)
    in_threads(
        lambda place: tiles.moments_of_block(values, *parts[place], *found[place][1:]),
        range(len(parts)),
        threads,
    )
    return found


def _blocks(count: int, times: int) -> list[tuple[int, Real, Real]]:
    """Return the number of fingers of each block, and memory for its moments."""
    return [(end - begin, np.empty(times), np.empty(times)) for begin, end in ranges(count, BLOCK)]
