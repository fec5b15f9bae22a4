"""Exact quantiles over the fingers at every sample."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

_AT_ONCE: Final = 1 << 22


def exact_quantiles(values: NDArray[np.float32], shares: tuple[float, ...]) -> Real:
    """Return quantiles by linear interpolation between the order statistics.

    Parameters
    ----------
    values : ndarray of float32, shape (fingers, n)
        Signals of all fingers.
    shares : tuple of float
        Cumulative probabilities, 0 to 1.

    Returns
    -------
    quantiles : ndarray, shape (shares, n)
        As `numpy.quantile` with its default method, in float64.
    """
    fingers, samples = values.shape
    ranks = np.asarray(shares) * (fingers - 1)
    low, high = np.floor(ranks).astype(int), np.ceil(ranks).astype(int)
    found = np.empty((len(ranks), samples))
    wide = max(1, _AT_ONCE // fingers)
    for begin in range(0, samples, wide):
        rows = np.ascontiguousarray(values[:, begin : begin + wide].T)
        rows.partition(np.unique([low, high]), axis=1)
        below, above = (rows[:, places].astype(float) for places in (low, high))
        found[:, begin : begin + wide] = (below + (above - below) * (ranks - low)).T
    return found
