"""The fingers of a study, drawn, evaluated and reduced in tiles: in this process, on threads, or on a Dask cluster."""

from __future__ import annotations

import functools
import importlib.util
import logging
import mmap
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.solve import population as signals_of_fingers
from electrovib.solve.population.fingers import KERNEL, TOGETHER
from electrovib.solve.population.percentiles import Histogram, thread_count
from electrovib.studies.population.declared import BLOCK, DeclaredStudy
from electrovib.studies.population.result import computing_versions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

    Rows = NDArray[np.float32]


class Statistics:
    """Statistics of one signal of n samples over some fingers, `binned` also with a histogram of its values.

    - `about`, `total`, `square`: values (n,) next to the mean, and the sums of the deviations from them and of
      their squares.
    - `above` (thresholds, n), `anywhere` (thresholds,): fingers that exceed a threshold at a sample, or at some.
    - `unknown`: fingers whose signal is nan at a sample (n,).
    """

    def __init__(self, thresholds: Sequence[float], samples: int, *, binned: bool = False) -> None:
        self.thresholds, self.fingers = tuple(thresholds), 0
        self.about, self.total, self.square = np.zeros((3, samples))
        self.above = np.zeros((len(self.thresholds), samples), np.int64)
        self.anywhere = np.zeros(len(self.thresholds), np.int64)
        self.unknown = np.zeros(samples, np.int64)
        self.histogram = Histogram(samples) if binned else None

    def add(self, values: Real) -> None:
        """Add the moments and counts of fingers.

        `values` (fingers, n).
        """
        for place, threshold in enumerate(self.thresholds):
            exceeded = values > threshold
            self.above[place] += np.count_nonzero(exceeded, axis=0)
            self.anywhere[place] += np.count_nonzero(exceeded.any(axis=1))
        if not self.fingers:  # the digits of a small variance stay
            with np.errstate(invalid="ignore"):  # infinities of both signs
                about = values.mean(axis=0)
            self.about = np.where(np.isfinite(about), about, 0.0)
        apart = values - self.about
        self.total += apart.sum(axis=0)
        self.square += np.einsum("ij,ij->j", apart, apart)
        self.fingers += len(values)
        if np.isnan(self.total).any():
            self.unknown += np.count_nonzero(np.isnan(values), axis=0)

    @property
    def mean(self) -> Real:
        """Mean of the fingers."""
        return self.about + self.total / max(1, self.fingers)

    @property
    def squares(self) -> Real:
        """Sum of the squared deviations from the mean."""
        with np.errstate(invalid="ignore"):  # infinities
            return np.maximum(self.square - self.total * (self.total / max(1, self.fingers)), 0.0)

    def variance(self) -> Real:
        """Return the variance of the population, estimated over n - 1; nan for one finger."""
        return self.squares / (self.fingers - 1) if self.fingers > 1 else np.full(self.mean.shape, np.nan)

    def merge(self, other: Statistics) -> None:
        """Add the statistics of other fingers."""
        count = self.fingers + other.fingers
        with np.errstate(invalid="ignore"):  # infinities
            mean, apart = self.mean, other.mean - self.mean
            self.square = self.squares + other.squares + apart**2 * (self.fingers * other.fingers / count)
            self.about, self.total = mean + apart * (other.fingers / count), np.zeros(mean.shape)
        self.fingers = count
        self.above += other.above
        self.anywhere += other.anywhere
        self.unknown += other.unknown
        if self.histogram is not None and other.histogram is not None:
            self.histogram.merge(other.histogram)

    def count(self, rows: Rows, threads: int | None) -> None:
        """Count fingers in the histogram; a value that is not known counts as 0, where no quantile is given.

        `rows` (fingers, n).
        """
        if self.histogram is not None:
            known = np.where(np.isnan(rows), np.float32(0.0), rows) if self.unknown.any() else rows
            self.histogram.add(known, threads=threads)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return everything as named arrays."""
        found = {"fingers": np.asarray([self.fingers]), "mean": self.mean, "squares": self.squares}
        found |= {"above": self.above, "anywhere": self.anywhere, "unknown": self.unknown}
        if self.histogram is not None:
            found["pages"] = self.histogram.pages
            found["bins"] = self.histogram.counts[: self.histogram.used]
        return found

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Continue from what `arrays` returned."""
        self.fingers = int(arrays["fingers"][0])
        self.about, self.square = arrays["mean"], arrays["squares"]
        self.above, self.anywhere, self.unknown = (arrays[name] for name in ("above", "anywhere", "unknown"))
        if self.histogram is not None:
            self.histogram.pages, self.histogram.counts = arrays["pages"], arrays["bins"]
            self.histogram.used, self.histogram.count = len(arrays["bins"]), self.fingers


@dataclass
class Tile:
    """What is known of consecutive fingers, from `start` to the one before `stop`.

    Parameters
    ----------
    statistics : dict of str to Statistics
        Of each signal.
    rows : dict of str to ndarray of float32, shape (fingers, n)
        Signals, where they are needed.
    seconds : float
        Computing time [s].
    problems : list of str
        Mistakes for which it cannot be computed.
    """

    start: int
    stop: int
    statistics: dict[str, Statistics] = field(default_factory=dict)
    rows: dict[str, Rows] = field(default_factory=dict)
    seconds: float = 0.0
    problems: list[str] = field(default_factory=list)


class Evaluator:
    """A study that can be evaluated for any fingers; `threads` are those of histograms and percentiles alone.

    - `exact`: whether the signals of all fingers fit the memory.
    - `held`, `binned`: the two methods of percentiles, from all signals, or beyond the memory from a histogram.
    """

    def __init__(self, declared: DeclaredStudy, *, threads: int | None = None) -> None:
        self.declared, self.threads = declared, threads
        self.population = signals_of_fingers.Population(
            declared.scenario, free=tuple(declared.space.paths), signals=declared.signals
        )
        self.axis: Real = np.asarray(getattr(self.population, declared.axis), dtype=float)
        self.samples = self.axis.size
        self.method = str(self.population.method)
        self.in_arrays = self.method == TOGETHER
        self.kernel = _kernels(str(self.population.kernel))
        self.numbers = self.samples * len(declared.signals)
        self.exact = 4.0 * declared.fingers * self.numbers <= declared.memory
        self.held = self.exact and bool(declared.percentiles)
        self.binned = bool(declared.percentiles) and not self.exact

    def statistics(self, *, binned: bool) -> dict[str, Statistics]:
        """Return the statistics of no finger."""
        thresholds = self.declared.thresholds
        return {
            name: Statistics(thresholds.get(name, ()), self.samples, binned=binned)
            for name in self.declared.signals
        }

    def memory(self, fingers: int) -> dict[str, Rows]:
        """Return new memory for signals, if these are needed."""
        needed = self.held or self.binned or self.declared.records
        names = self.declared.signals if needed else ()
        return {name: np.empty((fingers, self.samples), np.float32) for name in names}

    def tile(self, start: int, stop: int, rows: Mapping[str, Rows] | None = None) -> Tile:
        """Evaluate consecutive fingers, and write their signals into `rows`, (fingers, n), or into new memory."""
        begun = time.perf_counter()
        found = Tile(start, stop, self.statistics(binned=False), dict(rows or {}))
        if rows is None:
            found.rows = self.memory(stop - start)
        draws = self.declared.space.draw(self.declared.seed, start, stop)
        for fingers, signals in self.population.parts(draws):
            for name, values in signals.items():
                if name in found.rows:
                    found.rows[name][fingers] = values
                found.statistics[name].add(np.ascontiguousarray(values, dtype=float))
        found.seconds = time.perf_counter() - begun
        return found


class Collected:
    """Everything that is known of the first fingers of a study; `hold` keeps the signals of each of them."""

    def __init__(self, evaluator: Evaluator, *, hold: bool) -> None:
        self.evaluator, self.fingers = evaluator, 0
        self.statistics = evaluator.statistics(binned=evaluator.binned)
        count, samples = evaluator.declared.fingers, evaluator.samples
        self.rows: dict[str, Rows] = {}
        if hold:
            self.rows = {name: _new_memory(count, samples) for name in evaluator.declared.signals}

    def add(self, tile: Tile) -> None:
        """Add the tile that follows."""
        assert tile.start == self.fingers
        for name, each in self.statistics.items():
            each.merge(tile.statistics[name])
            rows, held = tile.rows.get(name), self.rows.get(name)
            if rows is None:  # it has a histogram, or nothing is asked for
                continue
            each.count(rows, self.evaluator.threads)
            if held is not None and not np.may_share_memory(rows, held):
                held[tile.start : tile.stop] = rows
        self.fingers = tile.stop


def _new_memory(fingers: int, samples: int) -> Rows:
    """Return an array of zeros in pages of ordinary size.

    numpy asks for huge pages, whose first use took up to five times as long on the virtual machine of the benchmarks.
    """
    private = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_PRIVATE") else {}
    memory = mmap.mmap(-1, max(1, 4 * fingers * samples), **private)
    return np.frombuffer(memory, np.float32, fingers * samples).reshape(fingers, samples)


def _kernels(of_signals: str) -> str:
    """Name the kernels of signals and statistics, on which the last bits of the results depend."""
    return KERNEL if of_signals == KERNEL else f"{of_signals}; statistics {KERNEL}"


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
        if not (evaluator.held or declared.records):  # a histogram is sent back, or nothing but sums
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
        if evaluator.held or evaluator.declared.records:
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
                f"workers = {scheduler}: no answer ({error}); expected the address that 'dask scheduler' prints, for"
                " instance tcp://10.0.0.1:8786"
            ) from None
        if not client.scheduler_info(n_workers=-1)["workers"]:
            raise InputError(
                f"workers = {scheduler}: has no worker; start one with 'dask worker {scheduler}'"
            )
        yield client
