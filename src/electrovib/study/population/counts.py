"""Numbers of fingers that exceed thresholds, or whose signal is not known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels import Moments


@dataclass
class FingerCounts:
    """Numbers of fingers, at every sample, that exceed thresholds or have no known value.

    Parameters
    ----------
    above : ndarray of int, shape (thresholds, n)
        Fingers whose signal exceeds the threshold at the sample.
    anywhere : ndarray of int, shape (thresholds,)
        Fingers whose signal exceeds the threshold at some sample.
    unknown : ndarray of int, shape (n,)
        Fingers whose signal is NaN at the sample.
    """

    above: NDArray[Any]
    anywhere: NDArray[Any]
    unknown: NDArray[Any]

    @classmethod
    def of(
        cls, values: Real | NDArray[np.float32], thresholds: tuple[float, ...], blocks: Sequence[Moments]
    ) -> FingerCounts:
        """Count fingers.

        `values` (fingers, n).
        """
        found = cls.empty(len(thresholds), values.shape[1])
        for place, threshold in enumerate(thresholds):
            exceeded = values > threshold
            found.above[place] = np.count_nonzero(exceeded, axis=0)
            found.anywhere[place] = np.count_nonzero(exceeded.any(axis=1))
        if any(np.isnan(block.mean).any() for block in blocks):
            found.unknown[:] = np.count_nonzero(np.isnan(values), axis=0)
        return found

    @classmethod
    def empty(cls, thresholds: int, samples: int) -> FingerCounts:
        """Return the counts of no finger."""
        shapes = ((thresholds, samples), (thresholds,), (samples,))
        return cls(*(np.zeros(shape, np.int64) for shape in shapes))

    def merge(self, other: FingerCounts) -> None:
        """Add the counts of other fingers."""
        self.above += other.above
        self.anywhere += other.anywhere
        self.unknown += other.unknown

    def copy(self) -> FingerCounts:
        """Return a copy that later merges do not change."""
        return FingerCounts(self.above.copy(), self.anywhere.copy(), self.unknown.copy())
