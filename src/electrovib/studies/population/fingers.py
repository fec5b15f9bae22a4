"""Consecutive fingers of a study: drawn, evaluated, and reduced to moments, counts and float32 signals."""

from __future__ import annotations

import mmap
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.studies.population.declared import DeclaredStudy

    Rows = NDArray[np.float32]


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
    fingers : int
        Number of fingers.
    about, total, square : ndarray, shape (n,)
        Values next to the mean, and the sums of the deviations from them and of their squares.
    above, anywhere, unknown : ndarray of int, shapes (thresholds, n), (thresholds,), (n,)
        Fingers that exceed a threshold at a sample, or at some sample; fingers whose signal is nan at a sample.
    histogram : Histogram or None
        Of the values.
    """

    def __init__(self, thresholds: Sequence[float], samples: int, *, binned: bool = False) -> None:
        from electrovib.solve.population.kernels import Histogram

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
        from electrovib.solve.population.kernels import loops

        for place, threshold in enumerate(self.thresholds):
            exceeded = values > threshold
            self.above[place] += np.count_nonzero(exceeded, axis=0)
            self.anywhere[place] += np.count_nonzero(exceeded.any(axis=1))
        if not self.fingers:  # the digits of a small variance stay
            with np.errstate(invalid="ignore"):  # infinities of both signs
                about = values.mean(axis=0)
            self.about = np.where(np.isfinite(about), about, 0.0)
        loops.add_moments(values, self.about, self.total, self.square)
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
    """A study that can be evaluated for any fingers.

    Parameters
    ----------
    declared : DeclaredStudy
        The study.
    threads : int, optional
        Threads of histograms and percentiles; by default one for each available processor. Signals are computed by one.

    Attributes
    ----------
    exact : bool
        Whether the signals of all fingers fit the memory.
    held, binned : bool
        The two methods of percentiles: from the signals of all fingers, or beyond the memory from a histogram.
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

    def statistics(self, *, binned: bool) -> dict[str, Statistics]:
        """Return the statistics of no finger."""
        thresholds = self.declared.thresholds
        return {
            name: Statistics(thresholds.get(name, ()), self.samples, binned=binned)
            for name in self.declared.signals
        }

    def memory(self, fingers: int) -> dict[str, Rows]:
        """Return new memory for signals, if these are needed."""
        needed = self.held or self.binned or self.declared.draws
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
    from electrovib.solve.population.kernels import kernel_name

    of_statistics = kernel_name()
    return of_statistics if of_signals == of_statistics else f"{of_signals}; statistics {of_statistics}"
