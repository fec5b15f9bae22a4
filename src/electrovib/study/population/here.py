"""Evaluation of the tiles of a study in this process, on several threads where arrays over fingers are computed."""

from __future__ import annotations

import queue
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Final

from electrovib.solve.population.kernels.threads import thread_count
from electrovib.study.population.declared import BLOCK
from electrovib.study.population.tile import Evaluator
from electrovib.study.population.tiles import TileSizes, largest_tile

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from electrovib.study.population.reduced import TileResult

_SECONDS: Final = 0.25
"""Computing time of a tile, about [s]."""
_COUNTED: Final = 16 * BLOCK
"""Fingers of a tile whose signals are computed again for the histogram, at most."""


def tiles_of_process(
    evaluator: Evaluator, start: int, into: Mapping[str, NDArray[np.float32]]
) -> Iterator[TileResult]:
    """Yield the tiles from a finger on, in order.

    Each thread has an evaluator of its own, whose kernels use one thread. Fingers that are solved one by one
    are evaluated by one thread, because Python runs one at a time.
    """
    declared = evaluator.declared
    most = largest_tile(evaluator.numbers)
    if evaluator.counted:
        most = max(most, _COUNTED)
    sizes = TileSizes(declared.fingers, most, seconds=_SECONDS, in_arrays=evaluator.in_arrays)
    threads = thread_count(evaluator.threads) if evaluator.in_arrays else 1
    if threads == 1 or declared.fingers - start <= sizes.most:
        while start < declared.fingers:
            tile = evaluator.tile(start, sizes.stop(start), into)
            sizes.measured(tile.stop - tile.start, tile.seconds)
            start = tile.stop
            yield tile
        return
    free: queue.SimpleQueue[Evaluator] = queue.SimpleQueue()
    for _ in range(threads):
        free.put(Evaluator(declared, threads=1))
    pending: deque[Future[TileResult]] = deque()
    given = start
    pool = ThreadPoolExecutor(threads)
    try:
        while start < declared.fingers:
            while given < declared.fingers and len(pending) <= threads:
                stop = sizes.stop(given)
                pending.append(pool.submit(_tile, free, given, stop, into))
                given = stop
            tile = pending.popleft().result()
            sizes.measured(tile.stop - tile.start, tile.seconds)
            start = tile.stop
            yield tile
    finally:
        pool.shutdown(cancel_futures=True)


def _tile(
    free: queue.SimpleQueue[Evaluator], start: int, stop: int, into: Mapping[str, NDArray[np.float32]]
) -> TileResult:
    evaluator = free.get()
    try:
        return evaluator.tile(start, stop, into)
    finally:
        free.put(evaluator)
