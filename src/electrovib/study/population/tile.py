"""A tile: some consecutive fingers, drawn, evaluated and reduced, in this process or on a worker."""

from __future__ import annotations

import functools
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.versions import versions
from electrovib.study.population.counts import FingerCounts
from electrovib.study.population.declared import BLOCK, DeclaredStudy
from electrovib.study.population.tiles import largest_tile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels import Histogram, Moments


@dataclass
class ReducedSignal:
    """Statistics of one signal over some consecutive fingers.

    Parameters
    ----------
    blocks : list of Moments
        Of each block of 1024 fingers.
    counts : FingerCounts
        Of all fingers.
    values : ndarray of float32, shape (fingers, n), or None
        Signals of the fingers, where they are needed.
    histogram : Histogram or None
        Of the signals, in place of them where it is smaller.
    """

    blocks: list[Moments]
    counts: FingerCounts
    values: NDArray[np.float32] | None
    histogram: Histogram | None


@dataclass
class TileResult:
    """What is known of a tile of fingers.

    Parameters
    ----------
    start, stop : int
        Indices of the first finger and of the one after the last.
    kernel : str
        Kernels and vector width with which it was computed.
    seconds : float
        Computing time [s].
    raw : dict of str to ndarray, shape (fingers, n)
        Signals of a tile that is part of a block; empty otherwise.
    reduced : dict of str to ReducedSignal
        Signals of a tile of whole blocks; empty otherwise.
    problems : list of str
        Mistakes for which it cannot be computed.
    """

    start: int
    stop: int
    kernel: str = ""
    seconds: float = 0.0
    raw: dict[str, Real] = field(default_factory=dict)
    reduced: dict[str, ReducedSignal] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)


class Evaluator:
    """A study that can be evaluated for any fingers.

    Parameters
    ----------
    declared : DeclaredStudy
        The study.
    threads : int, optional
        Threads of the kernels; by default one for each available processor.

    Raises
    ------
    InputError
        If the scenario has no such signal or parameter.
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
        self.kernel = kernels(str(self.population.kernel))
        self.numbers = self.samples * len(declared.signals)
        self.exact = 4.0 * declared.fingers * self.numbers <= declared.memory
        percentiles = bool(declared.percentiles)
        self.kept = declared.draws or (percentiles and self.exact)
        self.binned = percentiles and not self.exact

    def tile(
        self, start: int, stop: int, into: Mapping[str, NDArray[np.float32]] | None = None
    ) -> TileResult:
        """Evaluate consecutive fingers.

        Parameters
        ----------
        start, stop : int
            Indices of the first finger and of the one after the last.
        into : mapping of str to ndarray of float32, shape (fingers of the study, n), optional
            Signal to the array that receives the signals of whole blocks in the rows of the fingers.

        Returns
        -------
        result : TileResult
            Reduced if `start` begins a block and the fingers fill whole blocks, or end the study; raw otherwise.
        """
        begun = time.perf_counter()
        found = TileResult(start, stop, kernel=self.kernel)
        if start % BLOCK == 0 and (stop % BLOCK == 0 or stop == self.declared.fingers):
            found.reduced = self._whole_blocks(start, stop, into or {})
        else:
            found.raw = self._signals(start, stop)
        found.seconds = time.perf_counter() - begun
        return found

    def _signals(self, start: int, stop: int) -> dict[str, Real]:
        draws = self.declared.space.draw(self.declared.seed, start, stop)
        signals = self.population.signals(draws, threads=self.threads)
        return {name: np.asarray(signals[name], dtype=float) for name in self.declared.signals}

    def _whole_blocks(
        self, start: int, stop: int, into: Mapping[str, NDArray[np.float32]]
    ) -> dict[str, ReducedSignal]:
        """Reduce fingers in parts whose signals stay small; return a histogram in place of the signals of many parts."""
        size = max(BLOCK, largest_tile(self.numbers))
        found: dict[str, ReducedSignal] = {}
        for begin in range(start, stop, size):
            end = min(begin + size, stop)
            rows = {name: each[begin:end] for name, each in into.items()}
            part = self.reduced(self._signals(begin, end), rows)
            if stop - start > size and not self.kept:
                for each in part.values():
                    _bin(each, self.threads)
            for name, each in part.items():
                found[name] = _joined(found[name], each) if name in found else each
        return found

    def reduced(
        self, signals: Mapping[str, Real], rows: Mapping[str, NDArray[np.float32]] | None = None
    ) -> dict[str, ReducedSignal]:
        """Reduce the signals of consecutive fingers, the first of which begins a block.

        Parameters
        ----------
        signals : mapping of str to ndarray, shape (fingers, n)
            Signals by name.
        rows : mapping of str to ndarray of float32, shape (fingers, n), optional
            Arrays that receive them; new ones by default.

        Returns
        -------
        reduced : dict of str to ReducedSignal
            By name, with the signals where they are kept or counted in a histogram.
        """
        from electrovib.solve.population.kernels import block_moments

        found = {}
        for name, values in signals.items():
            blocks = block_moments(values, threads=self.threads)
            found[name] = ReducedSignal(
                blocks=blocks,
                counts=FingerCounts.of(values, self.declared.thresholds.get(name, ()), blocks),
                values=self._single(values, (rows or {}).get(name)),
                histogram=None,
            )
        return found

    def _single(self, values: Real, rows: NDArray[np.float32] | None) -> NDArray[np.float32] | None:
        """Return the signals as float32, where they are kept or counted."""
        if rows is not None:
            rows[:] = values
            return rows
        return values.astype(np.float32) if self.kept or self.binned else None


def count_in(histogram: Histogram, part: ReducedSignal, threads: int | None) -> None:
    """Count signals in a histogram; a value that is not known is counted as 0, because no quantile is given at its sample.

    Parameters
    ----------
    histogram : Histogram
        Receives the values.
    part : ReducedSignal
        Signals, with the number of those that are not known.
    threads : int or None
        Of the kernel.
    """
    values = part.values
    if values is not None:
        if part.counts.unknown.any():
            values = np.where(np.isnan(values), np.float32(0), values)
        histogram.add(values, threads=threads)


def _bin(part: ReducedSignal, threads: int | None) -> None:
    from electrovib.solve.population.kernels import Histogram

    if part.values is not None:
        part.histogram = Histogram(part.values.shape[1])
        count_in(part.histogram, part, threads)
        part.values = None


def _joined(one: ReducedSignal, other: ReducedSignal) -> ReducedSignal:
    """Return the statistics of fingers that follow each other."""
    one.counts.merge(other.counts)
    found = ReducedSignal([*one.blocks, *other.blocks], one.counts, None, None)
    if one.values is not None and other.values is not None:
        found.values = np.concatenate([one.values, other.values])
    if one.histogram is not None and other.histogram is not None:
        found.histogram = one.histogram + other.histogram
    return found


@functools.lru_cache(maxsize=1)
def _evaluator(text: str, threads: int | None) -> Evaluator:
    return Evaluator(DeclaredStudy.from_text(text), threads=threads)


def tile_on_worker(text: str, start: int, stop: int, expected: Mapping[str, str]) -> TileResult:
    """Evaluate a tile of a study that is given as text; a mistake is part of the result.

    Parameters
    ----------
    text : str
        Text of `DeclaredStudy.to_text`.
    start, stop : int
        Indices of the first finger and of the one after the last.
    expected : mapping of str to str
        Versions with which the other fingers are computed.

    Returns
    -------
    result : TileResult
        As from `Evaluator.tile`, or with the problems of the worker.
    """
    here = computing_versions()
    differing = [
        f"{name} {here.get(name)} instead of {each}"
        for name, each in expected.items()
        if here.get(name) != each
    ]
    if differing:
        what = ", ".join(differing)
        return TileResult(
            start, stop, problems=[f"workers: one has {what}; install the same versions everywhere"]
        )
    try:
        return _evaluator(text, _threads()).tile(start, stop)
    except ElectrovibError as error:
        return TileResult(start, stop, problems=[str(each) for each in error.problems])


def _threads() -> int | None:
    """Return the number of threads of the Dask worker that runs this; None elsewhere."""
    from distributed import get_worker

    try:
        return int(get_worker().state.nthreads)
    except ValueError:
        return None


def kernels(of_signals: str) -> str:
    """Name the kernels of signals and statistics, on which the last bits of the results depend."""
    from electrovib.solve.population.kernels import kernel_name

    of_statistics = kernel_name()
    return of_statistics if of_signals == of_statistics else f"{of_signals}; statistics {of_statistics}"


def computing_versions() -> dict[str, str]:
    """Return the versions of the packages on which the numbers of a study depend."""
    found = versions()
    return {name: found[name] for name in ("electrovib", "numpy", "scipy", "numba") if name in found}


def refuse_problems(result: TileResult) -> None:
    """Raise the problems of a tile as an error.

    Raises
    ------
    InputError
        If it has any.
    """
    if result.problems:
        raise InputError(result.problems)
