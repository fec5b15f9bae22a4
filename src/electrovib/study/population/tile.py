"""A tile: some consecutive fingers, drawn, evaluated and reduced, in this process or on a worker."""

from __future__ import annotations

import functools
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.versions import versions
from electrovib.study.population.declared import BLOCK, DeclaredStudy
from electrovib.study.population.histogram import BandHistogram
from electrovib.study.population.sums import Counts, Sums, sums_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


@dataclass
class ReducedSignal:
    """Statistics of one signal over some consecutive fingers.

    Parameters
    ----------
    sums : list of Sums
        Of each block of 1024 fingers.
    counts : Counts
        Of all fingers.
    values : ndarray of float32, shape (fingers, n), or None
        Signals of the fingers, where they are kept.
    histogram : BandHistogram or None
        Where percentiles are taken from a histogram.
    """

    sums: list[Sums]
    counts: Counts
    values: NDArray[np.float32] | None
    histogram: BandHistogram | None


@dataclass
class TileResult:
    """What is known of a tile of fingers.

    Parameters
    ----------
    start, stop : int
        Indices of the first finger and of the one after the last.
    kernel : str
        Kernel and vector width with which it was computed.
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


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What of the signals is kept beside the sums.

    Parameters
    ----------
    values : bool
        The signals of every finger, as float32.
    histogram : bool
        A histogram of the signals.
    """

    values: bool
    histogram: bool


class Evaluator:
    """A study that can be evaluated for any fingers.

    Parameters
    ----------
    declared : DeclaredStudy
        The study.

    Raises
    ------
    InputError
        If the scenario has no such signal or parameter.
    """

    def __init__(self, declared: DeclaredStudy) -> None:
        from electrovib.solve.population import population

        self.declared = declared
        self.population = population(
            declared.scenario, free=tuple(declared.space.paths), signals=declared.signals
        )
        self.axis: Real = np.asarray(getattr(self.population, declared.axis), dtype=float)
        self.samples = self.axis.size
        self.method = str(self.population.method)
        self.kernel = str(self.population.kernel)
        values = 4.0 * declared.fingers * self.samples * len(declared.signals)
        self.exact = values <= declared.memory
        percentiles = bool(declared.percentiles)
        self.kept = Kept(
            values=declared.draws or (percentiles and self.exact), histogram=percentiles and not self.exact
        )

    def tile(self, start: int, stop: int) -> TileResult:
        """Evaluate consecutive fingers.

        Parameters
        ----------
        start, stop : int
            Indices of the first finger and of the one after the last.

        Returns
        -------
        result : TileResult
            Reduced if `start` begins a block and the fingers fill whole blocks, or end the study; raw otherwise.
        """
        begun = time.perf_counter()
        draws = self.declared.space.draw(self.declared.seed, start, stop)
        signals = {
            name: np.asarray(each, dtype=float) for name, each in self.population.signals(draws).items()
        }
        signals = {name: signals[name] for name in self.declared.signals}
        found = TileResult(start, stop, kernel=self.kernel)
        if start % BLOCK == 0 and (stop % BLOCK == 0 or stop == self.declared.fingers):
            found.reduced = reduced(signals, self.declared.thresholds, self.kept)
        else:
            found.raw = signals
        found.seconds = time.perf_counter() - begun
        return found


def reduced(
    signals: Mapping[str, Real], thresholds: Mapping[str, tuple[float, ...]], kept: Kept
) -> dict[str, ReducedSignal]:
    """Reduce the signals of consecutive fingers, the first of which begins a block.

    Parameters
    ----------
    signals : mapping of str to ndarray, shape (fingers, n)
        Signals by name.
    thresholds : mapping of str to tuple of float
        Signal to the values whose exceedance is counted.
    kept : Kept
        What is kept beside the sums.

    Returns
    -------
    reduced : dict of str to ReducedSignal
        By name.
    """
    found = {}
    for name, values in signals.items():
        single = values.astype(np.float32) if kept.values or kept.histogram else None
        histogram = None
        if kept.histogram and single is not None:
            histogram = BandHistogram(values.shape[1])
            histogram.add(single)
        found[name] = ReducedSignal(
            sums=[sums_of(values[begin : begin + BLOCK]) for begin in range(0, len(values), BLOCK)],
            counts=Counts.of(values, thresholds.get(name, ())),
            values=single if kept.values else None,
            histogram=histogram,
        )
    return found


@functools.lru_cache(maxsize=1)
def _evaluator(text: str) -> Evaluator:
    return Evaluator(DeclaredStudy.from_text(text))


def tile_on_worker(text: str, start: int, stop: int, expected: dict[str, Any]) -> TileResult:
    """Evaluate a tile of a study that is given as text; a mistake is part of the result.

    Parameters
    ----------
    text : str
        Text of `DeclaredStudy.to_text`.
    start, stop : int
        Indices of the first finger and of the one after the last.
    expected : dict of str to str
        Versions with which the other fingers are computed.

    Returns
    -------
    result : TileResult
        As from `Evaluator.tile`, or with the problems of the worker.
    """
    here = computing_versions()
    if here != expected:
        differing = ", ".join(
            f"{name} {here.get(name)} instead of {each}"
            for name, each in expected.items()
            if here.get(name) != each
        )
        return TileResult(
            start, stop, problems=[f"workers: one has {differing}; install the same versions everywhere"]
        )
    try:
        return _evaluator(text).tile(start, stop)
    except ElectrovibError as error:
        return TileResult(start, stop, problems=[str(each) for each in error.problems])


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
