"""Long records, reduced to the points that a printed line can show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

LONG: Final = 20_000
"""Records with more points are drawn as their envelope."""
BINS: Final = 2_000


def envelope(
    x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Keep the lowest and the highest point of each stretch of a long record; a stretch without a number stays a gap."""
    if len(y) <= LONG:
        return x, y
    size = -(-len(y) // BINS)
    padded = np.concatenate([y, np.full(-len(y) % size, np.nan)]).reshape(-1, size)
    missing = np.isnan(padded)
    lowest = np.argmin(np.where(missing, np.inf, padded), axis=1)
    highest = np.argmax(np.where(missing, -np.inf, padded), axis=1)
    start = np.arange(len(padded)) * size
    kept = np.unique(np.concatenate([[0, len(y) - 1], start + lowest, start + highest]))
    kept = kept[kept < len(y)]
    return x[kept], y[kept]
