"""Everything that is known of the fingers evaluated so far, merged in the order of their index."""

from __future__ import annotations

import mmap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.study.population.counts import FingerCounts
from electrovib.study.population.declared import BLOCK
from electrovib.study.population.reduced import count_in

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels import Histogram, Moments
    from electrovib.study.population.reduced import Form, ReducedSignal, TileResult
    from electrovib.study.population.tile import Evaluator


@dataclass
class MergedSignal:
    """One signal of the fingers merged so far.

    Parameters
    ----------
    moments : Moments or None
        Over complete blocks; None before the first.
    counts : FingerCounts
        Over complete blocks.
    histogram : Histogram or None
        Over complete blocks, where percentiles are taken from it.
    values : ndarray of float32, shape (fingers of the study, n), or None
        Signals of all fingers, where percentiles are exact.
    block : list of ndarray, shape (fingers, n)
        Signals of the fingers of the block that is not complete.
    forms : list of SquareForm or ndarray of float32, shape (fingers, n)
        Signals of each complete block, where they are computed again for the percentiles.
    """

    moments: Moments | None
    counts: FingerCounts
    histogram: Histogram | None
    values: NDArray[np.float32] | None
    block: list[Real]
    forms: list[Form]


class MergedFingers:
    """Statistics of the first fingers of a study.

    Parameters
    ----------
    evaluator : Evaluator
        The study.
    hold : bool
        Hold the signals of every finger, also where no percentile is taken from them.

    Notes
    -----
    Tiles are merged in the order of their first finger. Fingers of an incomplete block are kept as they are until it is
    complete, because the sums of a block are formed at once.
    """

    def __init__(self, evaluator: Evaluator, *, hold: bool = False) -> None:
        from electrovib.solve.population.kernels import Histogram

        self.fingers, self.evaluator, self.declared = 0, evaluator, evaluator.declared
        samples, declared = evaluator.samples, evaluator.declared
        held = hold or (evaluator.kept and evaluator.exact and bool(declared.percentiles))
        self.signals = {
            name: MergedSignal(
                moments=None,
                counts=FingerCounts.empty(len(declared.thresholds.get(name, ())), samples),
                histogram=Histogram(samples) if evaluator.binned else None,
                values=_new_memory(declared.fingers, samples) if held else None,
                block=[],
                forms=[],
            )
            for name in declared.signals
        }

    @property
    def blocks(self) -> int:
        """Number of fingers in complete blocks."""
        return self.fingers if self.fingers == self.declared.fingers else self.fingers - self.fingers % BLOCK

    def add(self, tile: TileResult) -> dict[str, tuple[int, NDArray[np.float32]]]:
        """Merge the tile that follows the fingers merged so far."""
        assert tile.start == self.fingers
        whole, start = tile.reduced, tile.start
        self.fingers = tile.stop
        if tile.raw:
            start -= start % BLOCK
            whole = self._completed(tile.raw)
        rows = {}
        for name, found in whole.items():
            self._merge(self.signals[name], found, start)
            if found.values is not None:
                rows[name] = (start, found.values)
        return rows

    @property
    def values(self) -> dict[str, NDArray[np.float32]]:
        """Signals of all fingers of the study, where they are held; their rows are valid up to `blocks`."""
        return {name: each.values for name, each in self.signals.items() if each.values is not None}

    def _completed(self, raw: Mapping[str, Real]) -> dict[str, ReducedSignal]:
        """Keep the fingers of an incomplete block; reduce them once it is complete."""
        for name, values in raw.items():
            self.signals[name].block.append(values)
        if self.blocks != self.fingers:
            return {}
        blocks = {name: np.concatenate(each.block) for name, each in self.signals.items()}
        for each in self.signals.values():
            each.block = []
        count = len(next(iter(blocks.values())))
        return self.evaluator.reduced(self.fingers - count, self.fingers, signals=blocks)

    def _merge(self, into: MergedSignal, found: ReducedSignal, start: int) -> None:
        from electrovib.solve.population.kernels import merged

        into.moments = merged([*([into.moments] if into.moments is not None else []), *found.blocks])
        into.counts.merge(found.counts)
        if self.evaluator.recomputed:
            into.forms.extend(found.forms)
        if into.histogram is not None and found.histogram is not None:
            into.histogram.merge(found.histogram)
        elif into.histogram is not None and self.evaluator.counted:
            self.evaluator.histogram_of(found.forms, into.histogram)
        elif into.histogram is not None:
            count_in(into.histogram, found, self.evaluator.threads)
        if into.values is not None and found.values is not None and found.values.base is not into.values:
            into.values[start : start + len(found.values)] = found.values

    def state(self) -> dict[str, NDArray[Any]]:
        """Return a copy of everything except the kept signals, as named arrays; later merges do not change them."""
        found: dict[str, NDArray[Any]] = {}
        for place, each in enumerate(self.signals.values()):
            if each.moments is not None:
                found[f"count_{place}"] = np.asarray([each.moments.fingers])
                found[f"mean_{place}"], found[f"squares_{place}"] = each.moments.mean, each.moments.squares
            counts = each.counts.copy()
            found[f"above_{place}"], found[f"anywhere_{place}"] = counts.above, counts.anywhere
            found[f"unknown_{place}"] = counts.unknown
            if each.block:
                found[f"block_{place}"] = np.concatenate(each.block)
            if each.histogram is not None:
                found[f"pages_{place}"] = each.histogram.pages.copy()
                found[f"bins_{place}"] = each.histogram.counts[: each.histogram.used].copy()
        return found

    def restore(self, fingers: int, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from the arrays of `state`; the kept signals are restored by the caller."""
        from electrovib.solve.population.kernels import Moments

        self.fingers = fingers
        for place, each in enumerate(self.signals.values()):
            if f"count_{place}" in state:
                count = int(state[f"count_{place}"][0])
                each.moments = Moments(count, state[f"mean_{place}"], state[f"squares_{place}"])
            each.counts = FingerCounts(
                state.get(f"above_{place}", each.counts.above),
                state.get(f"anywhere_{place}", each.counts.anywhere),
                state[f"unknown_{place}"],
            )
            each.block = [state[f"block_{place}"]] if f"block_{place}" in state else []
            if each.histogram is not None and f"bins_{place}" in state:
                each.histogram.pages = state[f"pages_{place}"]
                each.histogram.counts = state[f"bins_{place}"]
                each.histogram.used = len(each.histogram.counts)
                each.histogram.count = self.blocks
            if self.evaluator.recomputed:
                each.forms = self.evaluator.forms(0, self.blocks)


def _new_memory(fingers: int, samples: int) -> NDArray[np.float32]:
    """Return an array of zeros in pages of ordinary size.

    numpy asks for huge pages, whose first use took up to five times as long on the virtual machine of the benchmarks.
    """
    size = fingers * samples * np.dtype(np.float32).itemsize
    if size == 0:
        return np.zeros((fingers, samples), np.float32)
    private = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_PRIVATE") else {}
    return np.frombuffer(mmap.mmap(-1, size, **private), np.float32).reshape(fingers, samples)
