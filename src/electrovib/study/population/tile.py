"""A tile: some consecutive fingers, drawn, evaluated and reduced, in this process or on a worker."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from electrovib.study.population.counts import FingerCounts
from electrovib.study.population.declared import BLOCK
from electrovib.study.population.reduced import ReducedSignal, TileResult, binned, joined
from electrovib.study.population.tiles import largest_tile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.study.population.declared import DeclaredStudy


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
        self._scratch: dict[str, Real] = {}

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

    def _signals(self, start: int, stop: int, out: Mapping[str, Real] | None = None) -> dict[str, Real]:
        draws = self.declared.space.draw(self.declared.seed, start, stop)
        signals = self.population.signals(draws, out=out, threads=self.threads)
        return {name: np.asarray(signals[name], dtype=float) for name in self.declared.signals}

    def _memory(self, fingers: int) -> dict[str, Real]:
        """Return arrays for the signals of some fingers, the same for every call: new memory is slow at its first use."""
        if any(len(each) < fingers for each in self._scratch.values()) or not self._scratch:
            self._scratch = {name: np.empty((fingers, self.samples)) for name in self.declared.signals}
        return {name: each[:fingers] for name, each in self._scratch.items()}

    def _whole_blocks(
        self, start: int, stop: int, into: Mapping[str, NDArray[np.float32]]
    ) -> dict[str, ReducedSignal]:
        """Reduce fingers in parts whose signals stay small; return a histogram in place of the signals of many parts."""
        size = max(BLOCK, largest_tile(self.numbers))
        found: dict[str, ReducedSignal] = {}
        for begin in range(start, stop, size):
            end = min(begin + size, stop)
            rows = {name: each[begin:end] for name, each in into.items()}
            part = self.reduced(self._signals(begin, end, self._memory(end - begin)), rows)
            if stop - start > size and not self.kept:
                for each in part.values():
                    binned(each, self.threads)
            for name, each in part.items():
                found[name] = joined(found[name], each) if name in found else each
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


def kernels(of_signals: str) -> str:
    """Name the kernels of signals and statistics, on which the last bits of the results depend."""
    from electrovib.solve.population.kernels import kernel_name

    of_statistics = kernel_name()
    return of_statistics if of_signals == of_statistics else f"{of_signals}; statistics {of_statistics}"
