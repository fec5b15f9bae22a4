"""Percentiles over fingers at each time: exact order statistics, and histograms of float32 numbers that can be added."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices, Real

    Rows = NDArray[np.float32]

T = TypeVar("T")
_LARGEST: Final = 0x7F800000  # bit pattern of infinity as a float32
_COLUMNS: Final = 16  # columns of a table that are turned into rows together: a line of the cache
_MANTISSA: Final = 8  # bits of the mantissa that a bin keeps: its width is 1/256 of the power of two below it
_BINS: Final = 1 << _MANTISSA
_OCTAVES: Final = 512  # sign and exponent of a float32
_DROPPED: Final = 23 - _MANTISSA
_NEW: Final = 4096  # pages that are allocated together at least
_COUNTED: Final = 16  # times of one call
_TURNED: Final = 1024  # numbers of a column that are turned together


def quantiles(values: ArrayLike, probabilities: ArrayLike, *, threads: int | None = None) -> Real:
    """Return exact quantiles over fingers at each time.

    `values` (fingers, n), `probabilities` (p,); returns `quantiles` (p, n).

    The quantile of probability p is interpolated between the order statistics on both sides of index p (fingers - 1),
    definition 7 of Hyndman and Fan, in float64.
    """
    given = np.asarray(values, np.float32)
    wanted = np.atleast_1d(np.asarray(probabilities, np.float64))
    place = wanted * (len(given) - 1)
    below: Indices = np.floor(place).astype(np.intp)
    share = place - below
    above, found = below + (share > 0), np.empty((wanted.size, given.shape[1]))

    def work(part: tuple[int, int]) -> None:
        rows = _turned(given, part)
        rows.sort(axis=1)  # in vectors of the processor: numbers that are not known come last
        low, high = (rows[:, each].astype(float) for each in (below, above))
        with np.errstate(invalid="ignore"):  # infinities of both signs
            between = np.where(low == high, low, low * (1 - share) + high * share)
        found[:, slice(*part)] = np.where(np.isnan(rows[:, -1:]), np.nan, between + 0.0).T  # -0 becomes 0

    in_threads(work, ranges(given.shape[1], _COLUMNS), threads)
    return found


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
        self.counts: NDArray[np.int64] = np.zeros((0, _BINS), np.int64)
        self.used = 0
        self.count = 0

    def add(self, values: ArrayLike, *, threads: int | None = None) -> None:
        """Count the values of some fingers.

        `values` (fingers, times).
        """
        given = np.asarray(values, np.float32)
        if np.isnan(given.max(initial=0.0)):
            raise InputError(
                "values has a value that is not a number: a histogram counts finite values and infinities."
            )

        def work(part: tuple[int, int]) -> list[tuple[int, Indices, NDArray[np.int64]]]:
            rows = _keys(_turned(given, part))
            return [(time, *_counted(row)) for time, row in enumerate(rows, start=part[0])]

        for some in in_threads(work, ranges(len(self.pages), _COUNTED), threads):
            times = np.concatenate([np.full(len(octaves), time) for time, octaves, _ in some])
            self._put(times, *(np.concatenate([each[place] for each in some]) for place in (1, 2)))
        self.count += len(given)

    def merge(self, other: Histogram) -> None:
        """Add the counts of another histogram."""
        times, octaves = np.nonzero(other.pages >= 0)
        self._put(times, octaves, other.counts[other.pages[times, octaves]])
        self.count += other.count

    def _put(self, times: Indices, octaves: Indices, counts: NDArray[np.int64]) -> None:
        """Add counts (n, 256) of octaves of times, each once, with memory for those that have none."""
        new = self.pages[times, octaves] < 0
        more = int(np.count_nonzero(new))
        if self.used + more > len(self.counts):
            size = max(self.used + more, min(2 * self.used, self.used + _NEW))
            larger = np.zeros((size, _BINS), np.int64)
            larger[: self.used] = self.counts[: self.used]
            self.counts = larger
        self.pages[times[new], octaves[new]] = np.arange(self.used, self.used + more, dtype=np.int32)
        self.used += more
        self.counts[self.pages[times, octaves]] += counts

    def quantiles(self, probabilities: ArrayLike) -> Real:
        """Return quantiles at each time.

        `probabilities` (p,); returns `quantiles` (p, times) [unit of the values].
        """
        wanted = np.atleast_1d(np.asarray(probabilities, np.float64))
        ranks = np.rint(wanted * (self.count - 1)).astype(np.int64)
        result = np.empty((wanted.size, len(self.pages)))
        for time, pages in enumerate(self.pages):
            octaves = np.flatnonzero(pages >= 0)
            running = np.cumsum(self.counts[pages[octaves]].reshape(-1))
            place = np.searchsorted(running, ranks, side="right")
            octave, within = octaves[place // _BINS], place % _BINS
            result[:, time] = _middles((octave << _MANTISSA) + within)
        return result


def _turned(table: Rows, part: tuple[int, int]) -> Rows:
    """Return some columns of a table as rows, some numbers of a column at once, so that what is read stays in the cache."""
    rows = np.empty((part[1] - part[0], len(table)), np.float32)
    for begin, end in ranges(len(table), _TURNED):
        rows[:, begin:end] = table[begin:end, slice(*part)].T
    return rows


def _keys(rows: Rows) -> NDArray[np.int32]:
    """Return the bins of numbers, in the order of the numbers; -0 counts as 0."""
    bits = (rows + np.float32(0.0)).view(np.int32)
    sign = bits >> np.int32(31)
    return ((bits ^ (sign & np.int32(0x7FFFFFFF))) >> np.int32(_DROPPED)) + np.int32(_OCTAVES * _BINS // 2)


def _counted(keys: NDArray[np.int32]) -> tuple[Indices, NDArray[np.int64]]:
    """Return the octaves that have numbers, and the counts (octaves, 256) of their bins."""
    if not keys.size:
        return np.zeros(0, np.intp), np.zeros((0, _BINS), np.int64)
    first, last = (int(end) >> _MANTISSA for end in (keys.min(), keys.max()))
    found = np.bincount(keys - np.int32(first << _MANTISSA), minlength=(last + 1 - first) << _MANTISSA)
    table = found.reshape(-1, _BINS)
    filled = np.flatnonzero(table.any(axis=1))
    return first + filled, table[filled]


def _middles(keys: NDArray[np.int64]) -> Real:
    """Return the middle of each bin; that of the bin of 0 is 0."""
    whole = (keys.astype(np.uint32) << np.uint32(_DROPPED)) + np.uint32(1 << (_DROPPED - 1))
    bits = np.where(whole >> np.uint32(31), whole ^ np.uint32(1 << 31), ~whole).astype(np.uint32)
    infinite = (bits & np.uint32(_LARGEST)) == _LARGEST
    bits[infinite] &= np.uint32(0xFF800000)
    found = bits.view(np.float32).astype(np.float64)
    tiny = np.abs(found) < np.finfo(np.float32).tiny
    return np.asarray(np.where(tiny, 0.0, found))


def thread_count(threads: int | None) -> int:
    """Return the number of threads of a kernel."""
    if threads is not None:
        return max(1, int(threads))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(work: Callable[[Any], T], parts: Sequence[Any], threads: int | None) -> list[T]:
    """Return what some work gives for each part, done on several threads."""
    count = min(thread_count(threads), len(parts))
    if count <= 1:
        return [work(part) for part in parts]
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(work, parts))


def ranges(count: int, size: int) -> list[tuple[int, int]]:
    """Return consecutive ranges of at most a size."""
    return [(begin, min(begin + size, count)) for begin in range(0, count, size)]
