"""Histograms over fingers at each time, on the bit patterns of float32 numbers, which can be added."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled
from electrovib.solve.population.kernels.stepping import factors, first_order_hold_many, gather

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.population.kernels.time_steps import TimeSteps

    Counts = NDArray[np.int64]

MANTISSA: Final = 8
"""Bits of the mantissa that a bin keeps: its width is 1/256 of the power of two below it."""
_BINS: Final = 1 << MANTISSA
_OCTAVES: Final = 512  # sign and exponent of a float32
_DROPPED: Final = 23 - MANTISSA
_INFINITY: Final = 0x7F800000  # bit pattern of a float32
_NEW: Final = 4096  # pages that are allocated together at least


class Histogram:
    """Counts of values at each time, in bins of equal relative width.

    Parameters
    ----------
    times : int
        Number of times.

    Notes
    -----
    A bin is the set of float32 numbers with equal sign, exponent and first 8 bits of the mantissa. Its middle lies
    within 0.2 % of each of its values. Memory is allocated for an octave (256 bins, 2 kB) at the first value in it.
    Counts are integers: the sum of histograms does not depend on how fingers were divided among them.
    """

    def __init__(self, times: int) -> None:
        self.pages: NDArray[np.int32] = np.full((times, _OCTAVES), -1, np.int32)
        self.counts: Counts = np.zeros((0, _BINS), np.int64)
        self.used = 0
        self.count = 0

    @property
    def nbytes(self) -> int:
        """Memory of the counts and their index [B]."""
        return int(self.pages.nbytes + self.counts.nbytes)

    def add(self, values: ArrayLike, *, threads: int | None = None) -> None:
        """Count the values of some fingers.

        `values` (fingers, times).
        """
        given = np.ascontiguousarray(values, np.float32)
        if given.ndim != 2 or given.shape[1] != len(self.pages):
            raise InputError(f"values has shape {given.shape}: expected (fingers, {len(self.pages)}).")
        kernel = compiled()
        found, valid = (_octaves if kernel is None else kernel.octaves)(given, threads)
        if not valid:
            raise InputError(
                "values has a value that is not a number: a histogram counts finite values and infinities."
            )
        self.allocate(found)
        (_count if kernel is None else kernel.count)(given, self.pages, self.counts, threads)
        self.count += len(given)

    def add_squares(
        self,
        rates: ArrayLike,
        residues: ArrayLike,
        direct: ArrayLike,
        state: ArrayLike,
        voltage: ArrayLike,
        time: ArrayLike | TimeSteps,
        *,
        factor: ArrayLike,
        outputs: ArrayLike,
        known: Mapping[int, NDArray[np.float32]] | None = None,
        threads: int | None = None,
    ) -> None:
        """Count factor times the squared responses of some fingers, as float32, without storing responses of all times.

        `factor` (fingers,), `outputs` (times,).
        """
        fingers = gather(rates, residues, direct, state, voltage, time)
        squared, at = factors(factor, fingers), np.asarray(outputs, np.intp)
        if len(at) != len(self.pages):
            raise InputError(f"outputs has {len(at)} times: expected {len(self.pages)}.")
        if (kernel := compiled()) is not None:
            kernel.count_squares(fingers, squared, at, known or {}, self, threads)
            self.count += len(squared)
            return
        values = np.ascontiguousarray(
            first_order_hold_many(*fingers, factor=squared, dtype=np.float32)[:, at]
        )
        for first, rows in (known or {}).items():
            values[first : first + len(rows)] = rows
        self.add(values)

    def merge(self, other: Histogram) -> None:
        """Add the counts of another histogram."""
        if len(self.pages) != len(other.pages):
            raise InputError(f"histograms of {len(self.pages)} and {len(other.pages)} times cannot be added.")
        filled = other.pages >= 0
        self.allocate(filled)
        if (kernel := compiled()) is not None:
            kernel.add_counts(self, other)
        else:
            self.counts[self.pages[filled]] += other.counts[other.pages[filled]]
        self.count += other.count

    def __add__(self, other: Histogram) -> Histogram:
        """Return the counts of both."""
        total = Histogram(len(self.pages))
        for each in (self, other):
            total.merge(each)
        return total

    def quantiles(self, probabilities: ArrayLike) -> Real:
        """Return quantiles at each time.

        `probabilities` (p,); returns `quantiles` (p, times) [unit of the values].
        """
        wanted = np.atleast_1d(np.asarray(probabilities, np.float64))
        if not self.count or not ((wanted >= 0.0) & (wanted <= 1.0)).all():
            raise InputError(
                f"probabilities = {wanted.tolist()} of {self.count} values: expected numbers from 0 to 1 of one value or more."
            )
        ranks = np.rint(wanted * (self.count - 1)).astype(np.int64)
        result = np.empty((wanted.size, len(self.pages)))
        for time, pages in enumerate(self.pages):
            octaves = np.flatnonzero(pages >= 0)
            running = np.cumsum(self.counts[pages[octaves]].reshape(-1))
            place = np.searchsorted(running, ranks, side="right")
            octave, within = octaves[place // _BINS], place % _BINS
            result[:, time] = _middles((octave << MANTISSA) + within)
        return result

    def exceedance(self, level: float) -> Real:
        """Return the share of values above a level at each time, to the nearest limit of a bin.

        Returns `share` (times,) [-].
        """
        key = int(sorted_keys(np.full((1, 1), level, np.float32))[0, 0] >> np.uint32(_DROPPED))
        octave, within = divmod(key, _BINS)
        share = np.zeros(len(self.pages))
        for time, pages in enumerate(self.pages):
            above = pages[octave + 1 :]
            total = float(self.counts[above[above >= 0]].sum())
            if pages[octave] >= 0:
                own = self.counts[pages[octave]]
                total += float(own[within + 1 :].sum()) + float(own[within]) / 2
            share[time] = total / self.count
        return share

    def allocate(self, wanted: NDArray[np.bool_]) -> None:
        """Give memory to octaves that have none.

        `wanted` (times, 512).
        """
        new = wanted & (self.pages < 0)
        more = int(np.count_nonzero(new))
        if self.used + more > len(self.counts):
            size = max(self.used + more, min(2 * self.used, self.used + _NEW))
            larger = np.zeros((size, _BINS), np.int64)
            larger[: self.used] = self.counts[: self.used]
            self.counts = larger
        self.pages[new] = np.arange(self.used, self.used + more, dtype=np.int32)
        self.used += more


def sorted_keys(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return integers in the order of float32 numbers; -0 counts as 0."""
    bits = (values + np.float32(0.0)).view(np.int32)
    return np.asarray((bits ^ ((bits >> 31) | np.int32(-(2**31)))).view(np.uint32))


def _middles(keys: NDArray[np.int64]) -> Real:
    """Return the middle of each bin; that of the bin of 0 is 0."""
    whole = (keys.astype(np.uint32) << np.uint32(_DROPPED)) + np.uint32(1 << (_DROPPED - 1))
    bits = np.where(whole >> np.uint32(31), whole ^ np.uint32(1 << 31), ~whole).astype(np.uint32)
    infinite = (bits & np.uint32(_INFINITY)) == _INFINITY
    bits[infinite] &= np.uint32(0xFF800000)
    found = bits.view(np.float32).astype(np.float64)
    tiny = np.abs(found) < np.finfo(np.float32).tiny
    return np.asarray(np.where(tiny, 0.0, found))


def _octaves(values: NDArray[np.float32], _threads: int | None) -> tuple[NDArray[np.bool_], bool]:
    """Return which octaves have values at each time, (times, octaves), and whether no value is nan."""
    keys = sorted_keys(values)
    found = np.zeros((keys.shape[1], _OCTAVES), bool)
    found[np.broadcast_to(np.arange(keys.shape[1]), keys.shape), keys >> np.uint32(23)] = True
    return found, not bool(np.isnan(values).any())


def _count(
    values: NDArray[np.float32], pages: NDArray[np.int32], counts: Counts, _threads: int | None
) -> None:
    """Add the values of some fingers to the counts."""
    flat = counts.reshape(-1)
    for begin in range(0, len(values), 1024):
        some = sorted_keys(values[begin : begin + 1024])
        page = np.take_along_axis(pages, (some >> np.uint32(23)).astype(np.intp).T, axis=1).T.astype(np.int64)
        place = page * _BINS + ((some >> np.uint32(_DROPPED)) & np.uint32(_BINS - 1))
        where, many = np.unique(place, return_counts=True)
        flat[where] += many
