"""The fingers of a study in tiles of about equal computing time: in this process, on threads, or on a Dask cluster."""

from __future__ import annotations

import functools
import importlib.util
import logging
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.solve.population.kernels.percentiles import thread_count
from electrovib.studies.population.declared import BLOCK, DeclaredStudy
from electrovib.studies.population.fingers import Collected, Evaluator, Tile
from electrovib.studies.population.result import computing_versions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from electrovib.studies.population.fingers import Rows

_FIRST: Final = 16
"""Fingers of the first tile where they are solved one by one."""
_BYTES: Final = 64e6
"""Memory of the signals of a tile, about [bytes]: many are counted in a histogram in less time than few."""
_HERE: Final = 0.25
"""Computing time of a tile in this process, about [s]."""
_TASK: Final = 1.0
"""Computing time of a tile on a worker, about [s]: what a worker that is lost costs."""
_UNSENT: Final = 64 * BLOCK
"""Fingers of a tile on a worker whose signals are not sent back, at most."""
_AHEAD: Final = 3
"""Tiles for each worker that are given out before the first of them is merged."""
_POLL: Final = 0.2
"""Time after which the progress is reported while a tile is awaited [s]."""
_CONNECT: Final = 10.0
"""Time within which a scheduler has to answer [s]."""


def largest_tile(numbers: int) -> int:
    """Return the largest number of fingers of a tile whose signals, of so many numbers each, are in memory."""
    most = int(max(1.0, _BYTES / (4 * numbers)))
    return min(64 * BLOCK, most - most % BLOCK if most > BLOCK else most)


class TileSizes:
    """Numbers of fingers that take about a given time; from a block on, tiles end where a block of the store ends."""

    def __init__(self, fingers: int, most: int, *, seconds: float, in_arrays: bool = False) -> None:
        self.fingers, self.most, self.seconds = fingers, most, seconds
        self.least = min(BLOCK, most) if in_arrays else 1
        self.wanted = max(self.least, min(_FIRST, most))

    def stop(self, start: int) -> int:
        """Return the index after the last finger of the tile that begins at a finger."""
        stop = start + self.wanted
        return min(self.fingers, stop - stop % BLOCK if self.wanted >= BLOCK else stop)

    def measured(self, fingers: int, seconds: float) -> None:
        """Adapt the size to the measured computing time of a tile."""
        wanted = int(self.seconds * fingers / max(seconds, 1e-6))
        self.wanted = min(self.most, max(self.least, wanted))


def _in_order(
    sizes: TileSizes,
    start: int,
    submit: Callable[[int, int], Callable[[], Tile]],
    ahead: Callable[[], int],
) -> Iterator[Tile]:
    """Yield the tiles from a finger on in their order; `submit` gives one out and returns how to await it."""
    pending: deque[Callable[[], Tile]] = deque()
    given = start
    while start < sizes.fingers:
        while given < sizes.fingers and len(pending) < ahead():
            stop = sizes.stop(given)
            pending.append(submit(given, stop))
            given = stop
        tile = pending.popleft()()
        if tile.problems:
            raise InputError(tile.problems)
        sizes.measured(tile.stop - tile.start, tile.seconds)
        start = tile.stop
        yield tile


def tiles_of_process(evaluator: Evaluator, start: int, held: Mapping[str, Rows]) -> Iterator[Tile]:
    """Yield the tiles from a finger on, evaluated in this process; the next one overwrites signals that are not held.

    Where signals are held, tiles are evaluated on threads. Otherwise one tile at a time is in memory. Fingers that are
    solved one by one are evaluated by one thread, because Python runs one at a time.
    """
    declared, most = evaluator.declared, largest_tile(evaluator.numbers)
    sizes = TileSizes(declared.fingers, most, seconds=_HERE, in_arrays=evaluator.in_arrays)
    threads = thread_count(evaluator.threads) if evaluator.in_arrays and held else 1
    memory = {} if held else evaluator.memory(min(most, declared.fingers))

    def evaluated(begin: int, stop: int) -> Tile:
        rows = {name: each[begin:stop] for name, each in held.items()}
        rows |= {name: each[: stop - begin] for name, each in memory.items()}
        return evaluator.tile(begin, stop, rows)

    if threads == 1 or declared.fingers - start <= most:
        yield from _in_order(sizes, start, lambda *ends: lambda: evaluated(*ends), lambda: 1)
        return
    pool = ThreadPoolExecutor(threads)
    try:
        ahead = threads + 1
        yield from _in_order(sizes, start, lambda *ends: pool.submit(evaluated, *ends).result, lambda: ahead)
    finally:
        pool.shutdown(cancel_futures=True)


def tiles_of_cluster(
    evaluator: Evaluator,
    start: int,
    *,
    workers: int | None,
    scheduler: str | None,
    waiting: Callable[[], None],
) -> Iterator[Tile]:
    """Yield the tiles from a finger on, evaluated by a Dask cluster.

    A task receives the study as text and the indices of its fingers. The task of a worker that is lost is
    given to another one by the scheduler.
    """
    with _client(workers, scheduler) as client:
        declared, versions = evaluator.declared, computing_versions()
        text, most = declared.to_text(), largest_tile(evaluator.numbers)
        if not (evaluator.held or declared.draws):  # a histogram is sent back, or nothing but sums
            most = max(most, _UNSENT)
        sizes = TileSizes(declared.fingers, most, seconds=_TASK, in_arrays=evaluator.in_arrays)

        def submit(begin: int, stop: int) -> Callable[[], Tile]:
            task = client.submit(tile_on_worker, text, begin, stop, versions, pure=False)
            return functools.partial(_awaited, task, begin, stop, waiting)

        def ahead() -> int:
            return _AHEAD * max(1, len(client.scheduler_info(n_workers=-1)["workers"]))

        yield from _in_order(sizes, start, submit, ahead)


def _awaited(task: Any, start: int, stop: int, waiting: Callable[[], None]) -> Tile:
    """Wait for a task."""
    from distributed import TimeoutError as DaskTimeoutError
    from distributed.scheduler import KilledWorker

    while True:
        try:
            found: Tile = task.result(timeout=_POLL)
        except (DaskTimeoutError, TimeoutError):
            waiting()
        except KilledWorker as error:
            raise InputError(
                f"workers: several were lost while they evaluated fingers {start} to {stop - 1}, the last"
                f" {error.last_worker.address}; its log states why, for instance too little memory"
            ) from None
        else:
            return found


@functools.lru_cache(maxsize=1)
def _evaluator(text: str, threads: int | None) -> Evaluator:
    return Evaluator(DeclaredStudy.from_text(text), threads=threads)


def tile_on_worker(text: str, start: int, stop: int, expected: Mapping[str, str]) -> Tile:
    """Evaluate a tile of a study that is given as text; a mistake is part of the result."""
    here = computing_versions()
    differing = [
        f"{name} {here.get(name)} instead of {each}"
        for name, each in expected.items()
        if here.get(name) != each
    ]
    if differing:
        what = ", ".join(differing)
        return Tile(start, stop, problems=[f"workers: one has {what}; install the same versions everywhere"])
    try:
        evaluator = _evaluator(text, _threads())
        if evaluator.held or evaluator.declared.draws:
            return evaluator.tile(start, stop)
        return _without_signals(evaluator, start, stop)
    except ElectrovibError as error:
        return Tile(start, stop, problems=[str(each) for each in error.problems])


def _without_signals(evaluator: Evaluator, start: int, stop: int) -> Tile:
    """Evaluate fingers in parts whose signals fit the memory, and count these signals in a histogram."""
    found, seconds, size = Collected(evaluator, hold=False), 0.0, largest_tile(evaluator.numbers)
    found.fingers, memory = start, evaluator.memory(min(size, stop - start))
    for begin in range(start, stop, size):
        end = min(begin + size, stop)
        part = evaluator.tile(begin, end, {name: each[: end - begin] for name, each in memory.items()})
        found.add(part)
        seconds += part.seconds
    return Tile(start, stop, found.statistics, seconds=seconds)


def _threads() -> int | None:
    """Return the number of threads of the Dask worker that runs this; None elsewhere."""
    from distributed import get_worker

    try:
        return int(get_worker().state.nthreads)
    except ValueError:
        return None


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster on this machine for the time of the block."""
    if importlib.util.find_spec("distributed") is None:
        raise InputError(
            "workers, scheduler: need Dask, which is not installed: pip install 'electrovib[study]'"
        )
    import dask
    import distributed

    make_cluster: Any = distributed.LocalCluster
    base: Any = distributed.Client

    class Quiet(base):  # type: ignore[misc]
        """A client that is closed by its ``with`` statement; one that met no scheduler would print a traceback at its end."""

        def __del__(self) -> None:
            """Do nothing."""

    alone = {
        f"distributed.nanny.pre-spawn-environ.{name}_NUM_THREADS": 1 for name in ("NUMBA", "OMP", "OPENBLAS")
    }
    quiet = {"distributed.admin.large-graph-warning-threshold": "1GB"}
    local = {"threads_per_worker": 1, "processes": True, "host": "127.0.0.1", "dashboard_address": None}
    local |= {"memory_limit": 0, "silence_logs": logging.CRITICAL}
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(alone | quiet))
        if workers is not None:
            yield stack.enter_context(Quiet(stack.enter_context(make_cluster(n_workers=workers, **local))))
            return
        try:
            client = stack.enter_context(Quiet(scheduler, timeout=_CONNECT, set_as_default=False))
        except (OSError, ValueError, TypeError) as error:  # TypeError: encryption that is not set up
            raise InputError(
                f"scheduler = {scheduler}: no answer ({error}); expected the address that 'dask scheduler' prints, for"
                " instance tcp://10.0.0.1:8786"
            ) from None
        if not client.scheduler_info(n_workers=-1)["workers"]:
            raise InputError(
                f"scheduler = {scheduler}: has no worker; start one with 'dask worker {scheduler}'"
            )
        yield client
