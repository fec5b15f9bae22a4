"""Exact quantiles over fingers at each time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.threads import in_threads, ranges

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real

    Rows = NDArray[np.float32]

_LARGEST: Final = 0x7F800000  # bit pattern of infinity as a float32: those beyond it are nan
_COLUMNS: Final = 64  # columns of a table that are turned into rows together


def quantiles(values: ArrayLike, probabilities: ArrayLike, *, threads: int | None = None) -> Real:
    """Return exact quantiles over fingers at each time.

    `values` (fingers, n), `probabilities` (p,); returns `quantiles` (p, n).

    The quantile of probability p is interpolated between the order statistics on both sides of index p (fingers - 1),
    definition 7 of Hyndman and Fan, in float64.
    """
    from electrovib.solve.population.kernels import row_loops

    given = np.asarray(values, np.float32)
    if given.ndim != 2 or not len(given):
        raise InputError(f"values has shape {given.shape}: expected (fingers, n) with one finger or more.")
    wanted = _Places(probabilities, len(given))
    found = np.empty((wanted.places.size, given.shape[1]))

    def work(part: tuple[int, int]) -> None:
        rows = np.empty((part[1] - part[0], len(given)), np.float32)
        row_loops.turn(given, part[0], rows)
        wanted.write(rows, found[:, slice(*part)])

    in_threads(work, ranges(given.shape[1], _COLUMNS), threads)
    return wanted.interpolated(found)


class _Places:
    """Places of quantiles in the order of some fingers.

    Parameters
    ----------
    probabilities : array_like, shape (p,)
        From 0 to 1.
    fingers : int
        Number of fingers.
    """

    def __init__(self, probabilities: ArrayLike, fingers: int) -> None:
        wanted = np.atleast_1d(np.asarray(probabilities, np.float64))
        if not ((wanted >= 0.0) & (wanted <= 1.0)).all():
            raise InputError(f"probabilities = {wanted.tolist()}: expected numbers from 0 to 1.")
        place = wanted * (fingers - 1)
        self.below: Indices = np.floor(place).astype(np.intp)
        self.share: Real = place - self.below
        self.above: Indices = self.below + (self.share > 0)
        self.places: Indices = np.unique([self.below, self.above])

    def write(self, rows: Rows, found: Real) -> None:
        """Write the numbers at the places in the order of each row into the columns of `found`, (places, rows)."""
        from electrovib.solve.population.kernels import row_loops

        kept = np.empty(rows.shape[1] + 1, np.int32)
        counts, ranks = np.empty(row_loops.BUCKETS, np.int64), np.empty(self.places.size, np.int64)
        for column, row in enumerate(rows.view(np.int32)):
            size, low, high = row_loops.keep_near(row, self.places, counts, kept, ranks)
            if high > _LARGEST or low < -_LARGEST - 1:
                found[:, column] = np.nan
                continue
            order = np.partition(kept[:size], ranks)[ranks]
            bits = order ^ ((order >> 31) & np.int32(0x7FFFFFFF))
            found[:, column] = bits.view(np.float32).astype(np.float64) + 0.0  # -0 becomes 0

    def interpolated(self, ordered: Real) -> Real:
        """Return the quantiles, (p, n), from the order statistics at the places, (places, n)."""
        places, upper = self.places, self.share[:, np.newaxis]
        low = ordered[np.searchsorted(places, self.below)]
        high = ordered[np.searchsorted(places, self.above)]
        with np.errstate(invalid="ignore"):  # infinities of both signs
            return np.asarray(np.where(low == high, low, low * (1 - upper) + high * upper))
