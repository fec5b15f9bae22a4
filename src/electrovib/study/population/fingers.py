"""Consecutive fingers of a study: drawn, evaluated, and reduced to moments, counts and float32 signals."""

from __future__ import annotations

import mmap
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.study.population.declared import BLOCK

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels import Histogram
    from electrovib.study.population.declared import DeclaredStudy

    Rows = NDArray[np.float32]

_COUNTED: Final = 8192
"""Fingers that are counted in a histogram together: a page of its counts is then used often while it is in the cache."""


class Statistics:
    """Statistics of one signal over some fingers.

    Parameters
    ----------
    thresholds : sequence of float
        Values whose exceedance is counted.
    samples : int
        Number of samples n of the signal.
    binned : bool
        Whether values are counted in a histogram too.

    Attributes
    ----------
    moments : Moments
        Mean and squares.
    above, anywhere, unknown : ndarray of int, shapes (thresholds, n), (thresholds,), (n,)
        Fingers that exceed a threshold at a sample, or at some sample; fingers whose signal is nan at a sample.
    histogram : Histogram or None
        Without the last fingers, which `counted` adds.
    """

    def __init__(self, thresholds: Sequence[float], samples: int, *, binned: bool = False) -> None:
        from electrovib.solve.population.kernels import Histogram, Moments

        self.thresholds = tuple(thresholds)
        self.moments = Moments(0, np.zeros(samples), np.zeros(samples))
        self.above = np.zeros((len(self.thresholds), samples), np.int64)
        self.anywhere = np.zeros(len(self.thresholds), np.int64)
        self.unknown = np.zeros(samples, np.int64)
        self.histogram = Histogram(samples) if binned else None
        self._waiting: Rows | None = None
        self._count = 0

    def add(self, values: Real, threads: int | None) -> None:
        """Add the moments and counts of fingers.

        `values` (fingers, n).
        """
        from electrovib.solve.population.kernels import block_moments, merged

        found = block_moments(values, threads=threads)
        self.moments = merged([self.moments, *found])
        for place, threshold in enumerate(self.thresholds):
            exceeded = values > threshold
            self.above[place] += np.count_nonzero(exceeded, axis=0)
            self.anywhere[place] += np.count_nonzero(exceeded.any(axis=1))
        if any(np.isnan(each.mean).any() for each in found):
            self.unknown += np.count_nonzero(np.isnan(values), axis=0)

    def merge(self, other: Statistics) -> None:
        """Add the statistics of other fingers."""
        from electrovib.solve.population.kernels import merged

        self.moments = merged([self.moments, other.moments])
        self.above += other.above
        self.anywhere += other.anywhere
        self.unknown += other.unknown
        if self.histogram is not None and other.histogram is not None:
            self.histogram.merge(other.counted(None))

    def count(self, rows: Rows, threads: int | None) -> None:
        """Count fingers in the histogram, many together.

        `rows` (fingers, n).
        """
        if self._waiting is None:
            self._waiting = np.empty((_COUNTED, rows.shape[1]), np.float32)
        while len(rows):
            room = len(self._waiting) - self._count
            part, rows = rows[:room], rows[room:]
            self._waiting[self._count : self._count + len(part)] = part
            self._count += len(part)
            if self._count == len(self._waiting):
                self.counted(threads)

    def counted(self, threads: int | None) -> Histogram:
        """Return the histogram of all fingers; a value that is not known is counted as 0, where no quantile is given."""
        assert self.histogram is not None
        if self._waiting is not None and self._count:
            rows = self._waiting[: self._count]
            rows[np.isnan(rows)] = 0.0
            self.histogram.add(rows, threads=threads)
            self._count = 0
        return self.histogram

    def sendable(self, threads: int | None) -> Statistics:
        """Return itself without the memory for fingers that are to be counted."""
        if self.histogram is not None:
            self.counted(threads)
        self._waiting = None
        return self

    def arrays(self, threads: int | None) -> dict[str, NDArray[Any]]:
        """Return everything as named arrays."""
        count, mean, squares = self.moments
        found = {"count": np.asarray([count]), "mean": mean, "squares": squares}
        found |= {"above": self.above, "anywhere": self.anywhere, "unknown": self.unknown}
        if self.histogram is not None:
            histogram = self.counted(threads)
            found |= {"pages": histogram.pages, "bins": histogram.counts[: histogram.used]}
        return found

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Continue from what `arrays` returned."""
        from electrovib.solve.population.kernels import Moments

        count = int(arrays["count"][0])
        self.moments = Moments(count, arrays["mean"], arrays["squares"])
        self.above, self.anywhere, self.unknown = (arrays[name] for name in ("above", "anywhere", "unknown"))
        if self.histogram is not None:
            self.histogram.pages, self.histogram.counts = arrays["pages"], arrays["bins"]
            self.histogram.used, self.histogram.count = len(arrays["bins"]), count


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
    """A study that can be evaluated for any fingers.

    Parameters
    ----------
    declared : DeclaredStudy
        The study.
    threads : int, optional
        Threads of the kernels; by default one for each available processor.

    Attributes
    ----------
    exact : bool
        Whether the signals of all fingers fit the memory.
    held, binned : bool
        The two ways to percentiles: from the signals of all fingers, or beyond the memory from a histogram.
    """

    def __init__(self, declared: DeclaredStudy, *, threads: int | None = None) -> None:
        from electrovib.solve.population import population
        from electrovib.solve.population.fingers import TOGETHER

        self.declared, self.threads = declared, threads
        self.population = population(
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
        self._scratch: dict[str, Real] = {}

    def statistics(self, *, binned: bool) -> dict[str, Statistics]:
        """Return the statistics of no finger."""
        thresholds = self.declared.thresholds
        return {
            name: Statistics(thresholds.get(name, ()), self.samples, binned=binned)
            for name in self.declared.signals
        }

    def tile(self, start: int, stop: int, into: Mapping[str, Rows] | None = None) -> Tile:
        """Evaluate consecutive fingers, and write their signals into those of all fingers where these are held."""
        begun = time.perf_counter()
        found = Tile(start, stop, self.statistics(binned=False))
        if into:
            found.rows = {name: rows[start:stop] for name, rows in into.items()}
        elif self.held or self.binned or self.declared.draws:
            shape = (stop - start, self.samples)
            found.rows = {name: np.empty(shape, np.float32) for name in self.declared.signals}
        draws = self.declared.space.draw(self.declared.seed, start, stop)
        for begin in range(0, stop - start, BLOCK):
            part = slice(begin, min(begin + BLOCK, stop - start))
            some = {path: values[part] for path, values in draws.items()}
            for name, values in self._signals(some, part.stop - begin).items():
                found.statistics[name].add(values, self.threads)
                if name in found.rows:
                    found.rows[name][part] = values
        found.seconds = time.perf_counter() - begun
        return found

    def _signals(self, draws: Mapping[str, Real], fingers: int) -> dict[str, Real]:
        """Return the signals of at most a block of fingers in the same memory at every call: new memory is slow."""
        if len(next(iter(self._scratch.values()), ())) < fingers:
            self._scratch = {name: np.empty((fingers, self.samples)) for name in self.declared.signals}
        out = {name: each[:fingers] for name, each in self._scratch.items()}
        signals = self.population.signals(draws, out=out, threads=self.threads)
        return {name: np.asarray(signals[name], dtype=float) for name in self.declared.signals}


class Collected:
    """Everything that is known of the first fingers of a study.

    Parameters
    ----------
    evaluator : Evaluator
        The study.
    hold : bool
        Hold the signals of every finger.
    """

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
            if each.histogram is not None and tile.statistics[name].histogram is None:
                each.count(tile.rows[name], self.evaluator.threads)
            if name in self.rows and not np.may_share_memory(tile.rows[name], self.rows[name]):
                self.rows[name][tile.start : tile.stop] = tile.rows[name]
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
    from electrovib.solve.population.kernels import kernel_name

    of_statistics = kernel_name()
    return of_statistics if of_signals == of_statistics else f"{of_signals}; statistics {of_statistics}"
