"""Everything that is known of the fingers evaluated so far, merged in the order of their index."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.study.population.declared import BLOCK
from electrovib.study.population.histogram import BandHistogram
from electrovib.study.population.sums import Counts, Sums
from electrovib.study.population.tile import ReducedSignal, reduced

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.study.population.tile import Evaluator, TileResult


@dataclass
class MergedSignal:
    """One signal of the fingers merged so far.

    Parameters
    ----------
    sums : Sums
        Over complete blocks.
    counts : Counts
        Over complete blocks.
    histogram : BandHistogram or None
        Over complete blocks, where percentiles are taken from it.
    values : ndarray of float32, shape (fingers of the study, n), or None
        Signals of all fingers, where percentiles are exact.
    block : list of ndarray, shape (fingers, n)
        Signals of the fingers of the block that is not complete.
    """

    sums: Sums
    counts: Counts
    histogram: BandHistogram | None
    values: NDArray[np.float32] | None
    block: list[Real]


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
        self.fingers = 0
        self.declared, self.kept, self.exact = evaluator.declared, evaluator.kept, evaluator.exact
        samples, declared = evaluator.samples, evaluator.declared
        held = hold or (bool(declared.percentiles) and evaluator.exact)
        self.signals = {
            name: MergedSignal(
                sums=Sums.empty(samples),
                counts=Counts.empty(len(declared.thresholds.get(name, ())), samples),
                histogram=BandHistogram(samples) if evaluator.kept.histogram else None,
                values=np.empty((declared.fingers, samples), np.float32) if held else None,
                block=[],
            )
            for name in declared.signals
        }

    @property
    def blocks(self) -> int:
        """Number of fingers in complete blocks."""
        return self.fingers if self.fingers == self.declared.fingers else self.fingers - self.fingers % BLOCK

    def add(self, tile: TileResult) -> dict[str, tuple[int, NDArray[np.float32]]]:
        """Merge the tile that follows the fingers merged so far.

        Parameters
        ----------
        tile : TileResult
            Its first finger is the next one.

        Returns
        -------
        rows : dict of str to (int, ndarray of float32, shape (fingers, n))
            Signal to the first finger and the signals of the blocks that the tile completes, where they are kept.
        """
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

    def _completed(self, raw: Mapping[str, Real]) -> dict[str, ReducedSignal]:
        """Keep the fingers of an incomplete block; reduce them once it is complete."""
        for name, values in raw.items():
            self.signals[name].block.append(values)
        if self.blocks != self.fingers:
            return {}
        blocks = {name: np.concatenate(each.block) for name, each in self.signals.items()}
        for each in self.signals.values():
            each.block = []
        return reduced(blocks, self.declared.thresholds, self.kept)

    @staticmethod
    def _merge(merged: MergedSignal, found: ReducedSignal, start: int) -> None:
        for sums in found.sums:
            merged.sums.merge(sums)
        merged.counts.merge(found.counts)
        if merged.histogram is not None and found.histogram is not None:
            merged.histogram.merge(found.histogram)
        if merged.values is not None and found.values is not None:
            merged.values[start : start + len(found.values)] = found.values

    def state(self) -> dict[str, NDArray[Any]]:
        """Return a copy of everything except the kept signals, as named arrays; later merges do not change them."""
        found: dict[str, NDArray[Any]] = {}
        for place, each in enumerate(self.signals.values()):
            sums, counts = each.sums.copy(), each.counts.copy()
            found[f"count_{place}"] = np.asarray([sums.count])
            found[f"mean_{place}"], found[f"squares_{place}"] = sums.mean, sums.squares
            found[f"above_{place}"], found[f"anywhere_{place}"] = counts.above, counts.anywhere
            found[f"unknown_{place}"] = counts.unknown
            if each.block:
                found[f"block_{place}"] = np.concatenate(each.block)
            if each.histogram is not None:
                found[f"first_{place}"] = np.asarray([each.histogram.first])
                found[f"histogram_{place}"] = each.histogram.counts.copy()
        return found

    def restore(self, fingers: int, state: Mapping[str, NDArray[Any]]) -> None:
        """Continue from the arrays of `state`; the kept signals are restored by the caller.

        Parameters
        ----------
        fingers : int
            Number of fingers that were merged.
        state : mapping of str to ndarray
            As `state` returned it.
        """
        self.fingers = fingers
        for place, each in enumerate(self.signals.values()):
            each.sums = Sums(
                int(state[f"count_{place}"][0]), state[f"mean_{place}"], state[f"squares_{place}"]
            )
            each.counts = Counts(
                state.get(f"above_{place}", each.counts.above),  # an array without elements is not stored
                state.get(f"anywhere_{place}", each.counts.anywhere),
                state[f"unknown_{place}"],
            )
            each.block = [state[f"block_{place}"]] if f"block_{place}" in state else []
            if each.histogram is not None and f"histogram_{place}" in state:
                each.histogram.first = int(state[f"first_{place}"][0])
                each.histogram.counts = state[f"histogram_{place}"]
