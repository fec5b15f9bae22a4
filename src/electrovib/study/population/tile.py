"""A tile: some consecutive fingers, drawn, evaluated and reduced, in this process or on a worker."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.study.population.counts import FingerCounts
from electrovib.study.population.declared import BLOCK
from electrovib.study.population.reduced import (
    ReducedSignal,
    SquareForm,
    TileResult,
    binned,
    joined,
    of_blocks,
)
from electrovib.study.population.tiles import largest_tile

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels import Histogram
    from electrovib.solve.population.together.forces import Squares
    from electrovib.study.population.declared import DeclaredStudy
    from electrovib.study.population.reduced import Form


_FEWEST_SAMPLES: Final = 128
"""Samples from which the signals of a finger take more memory than the form from which they are computed again."""


_COUNTED: Final = 8
"""Blocks whose signals are computed again for a histogram together."""


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
    kept, binned : bool
        Whether signals are stored, or counted in histograms.
    recomputed, counted : bool
        Whether signals are computed again for the percentiles, or for the histogram.

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
        self.streamed = self.population.is_streamed
        self.kernel = kernels(str(self.population.kernel))
        self.numbers = self.samples * len(declared.signals)
        self.exact = 4.0 * declared.fingers * self.numbers <= declared.memory
        percentiles = bool(declared.percentiles)
        self.recomputed = (
            percentiles
            and self.exact
            and self.streamed
            and not declared.draws
            and self.samples >= _FEWEST_SAMPLES
        )
        self.counted = percentiles and not self.exact and self.streamed and not declared.draws
        self.kept = declared.draws or (percentiles and self.exact and not self.recomputed)
        self.binned = percentiles and not self.exact
        self._scratch: dict[str, Real] = {}

    def tile(
        self, start: int, stop: int, into: Mapping[str, NDArray[np.float32]] | None = None
    ) -> TileResult:
        """Evaluate consecutive fingers."""
        begun = time.perf_counter()
        found = TileResult(start, stop, kernel=self.kernel)
        if start % BLOCK == 0 and (stop % BLOCK == 0 or stop == self.declared.fingers):
            found.reduced = self._whole_blocks(start, stop, into or {})
        else:
            found.raw = self._signals(self._draws(start, stop))
        found.seconds = time.perf_counter() - begun
        return found

    def _draws(self, start: int, stop: int) -> dict[str, Real]:
        return self.declared.space.draw(self.declared.seed, start, stop)

    def _signals(self, draws: Mapping[str, Real], out: Mapping[str, Real] | None = None) -> dict[str, Real]:
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
            part = self.reduced(begin, end, {name: each[begin:end] for name, each in into.items()})
            if stop - start > size and not self.kept:
                for each in part.values():
                    binned(each, self.threads)
            for name, each in part.items():
                found[name] = joined(found[name], each) if name in found else each
        return found

    def histogram_of(self, forms: Sequence[Form], into: Histogram | None = None) -> Histogram:
        """Count signals that are computed again; a value that is not known counts as 0."""
        from electrovib.solve.population.kernels import Histogram

        found = Histogram(self.samples) if into is None else into
        voltage, steps, places = self.population.grid
        for begin in range(0, len(forms), _COUNTED):
            whole, known = of_blocks(forms[begin : begin + _COUNTED])
            known = {
                first: np.nan_to_num(rows, posinf=np.inf, neginf=-np.inf) for first, rows in known.items()
            }
            if whole is None:
                for rows in known.values():
                    found.add(rows, threads=self.threads)
                continue
            found.add_squares(
                whole.rates,
                whole.residues,
                whole.direct,
                whole.state,
                voltage,
                steps,
                factor=whole.factor,
                outputs=places,
                known=known,
                threads=self.threads,
            )
        return found

    def reduced(
        self,
        start: int,
        stop: int,
        rows: Mapping[str, NDArray[np.float32]] | None = None,
        signals: Mapping[str, Real] | None = None,
    ) -> dict[str, ReducedSignal]:
        """Reduce the signals of consecutive fingers, the first of which begins a block.

        Moments are streamed where the population has that form, whether the signals are known or not: which
        sums are formed depends on the fingers of the block alone.
        """
        draws, fingers = self._draws(start, stop), stop - start
        found = {name: self._nothing(name, fingers, (rows or {}).get(name)) for name in self.declared.signals}
        step = BLOCK if self.streamed else fingers
        for begin in range(0, fingers, step):
            part = slice(begin, min(begin + step, fingers))
            some = {path: values[part] for path, values in draws.items()}
            known = None if signals is None else {name: values[part] for name, values in signals.items()}
            if not self.streamed or not self._stream(found, part, some, known):
                self._store(found, part, known or self._signals(some, self._memory(part.stop - begin)))
        return found

    def forms(self, start: int, stop: int) -> list[Form]:
        """Return the signals of consecutive fingers as `reduced` does, of each block, where they are computed again."""
        (name,) = self.declared.signals
        found: list[Form] = []
        for begin in range(start, stop, BLOCK):
            draws = self._draws(begin, min(begin + BLOCK, stop))
            squares = self.population.squares(draws, threads=self.threads)
            if squares is None:
                found.append(self._signals(draws)[name].astype(np.float32))
            else:
                found.append(_form(squares))
        return found

    def _nothing(self, name: str, fingers: int, rows: NDArray[np.float32] | None) -> ReducedSignal:
        """Return the statistics of no finger, with memory for the float32 signals where they are kept or counted."""
        if rows is None and (self.kept or (self.binned and not self.counted)):
            rows = np.empty((fingers, self.samples), np.float32)
        counts = FingerCounts.empty(len(self.declared.thresholds.get(name, ())), self.samples)
        return ReducedSignal(blocks=[], counts=counts, values=rows, histogram=None)

    def _store(self, found: Mapping[str, ReducedSignal], part: slice, signals: Mapping[str, Real]) -> None:
        """Add fingers whose signals are known."""
        from electrovib.solve.population.kernels import block_moments

        for name, values in signals.items():
            each, blocks = found[name], block_moments(values, threads=self.threads)
            each.blocks.extend(blocks)
            each.counts.merge(FingerCounts.of(values, self.declared.thresholds.get(name, ()), blocks))
            if each.values is not None:
                each.values[part] = values
            if self.recomputed or self.counted:
                each.forms.append(values.astype(np.float32))

    def _stream(
        self,
        found: Mapping[str, ReducedSignal],
        part: slice,
        draws: Mapping[str, Real],
        signals: Mapping[str, Real] | None,
    ) -> bool:
        """Add the fingers of a block with streamed moments, or return False if one of them has another form.

        Thresholds are compared with signals in float64; without them the signals are only written as float32.
        """
        from electrovib.solve.population.kernels import Moments, square_moments_many

        ((name, each),) = found.items()
        thresholds = self.declared.thresholds.get(name, ())
        rows = None if each.values is None else each.values[part]
        out = {name: rows} if rows is not None and signals is None and not thresholds else None
        squares = self.population.squares(draws, out=out, threads=self.threads)
        if squares is None:
            return False
        *numbers, factor, places = squares
        (block,) = square_moments_many(*numbers, factor=factor, threads=self.threads)
        block = Moments(block.fingers, block.mean[places], block.squares[places])
        each.blocks.append(block)
        if out is None and (rows is not None or thresholds or np.isnan(block.mean).any()):
            signals = signals or self._signals(draws, self._memory(block.fingers))
            if rows is not None:
                rows[:] = signals[name]
        values: Any = rows if out is not None else None if signals is None else signals[name]
        if self.counted and np.isnan(block.mean).any():
            each.forms.append(values.astype(np.float32))
        elif self.recomputed or self.counted:
            each.forms.append(_form(squares))
        if values is not None:
            each.counts.merge(FingerCounts.of(values, thresholds, [block]))
        return True


def _form(squares: Squares) -> SquareForm:
    """Return what differs between the fingers of a block."""
    return SquareForm(squares.rates, squares.residues, squares.direct, squares.state, squares.factor)


def kernels(of_signals: str) -> str:
    """Name the kernels of signals and statistics, on which the last bits of the results depend."""
    from electrovib.solve.population.kernels import kernel_name

    of_statistics = kernel_name()
    return of_statistics if of_signals == of_statistics else f"{of_signals}; statistics {of_statistics}"
