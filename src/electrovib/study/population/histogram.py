"""Quantiles from integer histograms on the bit pattern of float32."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from electrovib.core.arrays import Real

_SHIFT: Final = 15  # 23 - 8: eight bits of the mantissa remain
_ZERO: Final = 1 << 31


class BandHistogram:
    """Counts of the values at every sample, in bins of the float32 bit pattern with 8 bits of the mantissa.

    Parameters
    ----------
    samples : int
        Number of samples.

    Notes
    -----
    A bin ends at most 1/256 above its beginning, and its centre is returned, so a quantile is within 0.2 % of an order
    statistic of the values. Counts are integers: histograms merge in any order to the same bits. The range of the bins
    grows with the values.
    """

    def __init__(self, samples: int) -> None:
        self.first = 0
        self.counts: NDArray[np.int64] = np.zeros((samples, 0), np.int64)

    def add(self, values: NDArray[np.float32]) -> None:
        """Count the values of fingers, shape (fingers, n); NaN is not counted."""
        codes = _codes(values)
        known = ~np.isnan(values)
        if not known.any():
            return
        self._widen(int(codes[known].min()), int(codes[known].max()) + 1)
        samples, width = self.counts.shape
        places = codes - self.first + width * np.arange(samples)
        for begin in range(0, samples, max(1, (1 << 22) // width)):
            part = slice(begin, begin + max(1, (1 << 22) // width))
            found = places[:, part][known[:, part]] - begin * width
            size = self.counts[part].size
            self.counts[part] += np.bincount(found, minlength=size).reshape(-1, width)

    def merge(self, other: BandHistogram) -> None:
        """Add the counts of other fingers."""
        if not other.counts.shape[1]:
            return
        self._widen(other.first, other.first + other.counts.shape[1])
        begin = other.first - self.first
        self.counts[:, begin : begin + other.counts.shape[1]] += other.counts

    def quantiles(self, shares: tuple[float, ...]) -> Real:
        """Return quantiles by linear interpolation between order statistics.

        Parameters
        ----------
        shares : tuple of float
            Cumulative probabilities, 0 to 1.

        Returns
        -------
        quantiles : ndarray, shape (shares, n)
            Values in the unit of the signal; NaN at a sample without any value.
        """
        samples, width = self.counts.shape
        found = np.full((len(shares), samples), np.nan)
        if not width:
            return found
        centres = _centres(np.arange(self.first, self.first + width, dtype=np.uint32))
        for sample in range(samples):
            upto = np.cumsum(self.counts[sample])
            if upto[-1]:
                ranks = np.asarray(shares) * (upto[-1] - 1)
                low = centres[np.searchsorted(upto, np.floor(ranks), side="right")]
                high = centres[np.searchsorted(upto, np.ceil(ranks), side="right")]
                found[:, sample] = low + (high - low) * (ranks % 1.0)
        return found

    def _widen(self, first: int, end: int) -> None:
        samples, width = self.counts.shape
        if not width:
            self.first, self.counts = first, np.zeros((samples, end - first), np.int64)
        elif first < self.first or end > self.first + width:
            begin, stop = min(first, self.first), max(end, self.first + width)
            wider = np.zeros((samples, stop - begin), np.int64)
            wider[:, self.first - begin : self.first - begin + width] = self.counts
            self.first, self.counts = begin, wider


def _codes(values: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the bin of each value; bins of larger values have larger numbers."""
    bits = np.ascontiguousarray(values, np.float32).view(np.uint32)
    ordered = np.where(bits >= _ZERO, ~bits, bits | np.uint32(_ZERO))
    return (ordered >> np.uint32(_SHIFT)).astype(np.int64)


def _centres(codes: NDArray[np.uint32]) -> Real:
    """Return the value at the centre of each bin; that around 0 is 0."""
    low = codes << np.uint32(_SHIFT)
    high = low + np.uint32((1 << _SHIFT) - 1)
    ends = [
        np.where(each >= _ZERO, each ^ np.uint32(_ZERO), ~each).astype(np.uint32).view(np.float32)
        for each in (low, high)
    ]
    return np.where(np.abs(ends[0]) < 1e-37, 0.0, (ends[0].astype(float) + ends[1].astype(float)) / 2)
