"""Order statistics and histograms of the columns of a table, some lines of the cache at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.solve.recursion.vectors.jit import inner, outer
from electrovib.solve.recursion.vectors.lanes import prefetch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

COLUMNS: Final = 32
"""Columns that are taken together: two lines of the cache."""
WIDE: Final = 64
"""The same for few rows: every row lies in a page of its own, whose address is resolved once for each group."""
FEW_ROWS: Final = 131072
"""Number of rows up to which they are few: the columns that are taken have 32 MB at most."""
BUCKETS: Final = 2048
"""Buckets of one pass of the selection."""
_LINE: Final = 16  # numbers in a line of the cache
_AHEAD: Final = 24  # rows
_FEW: Final = 24  # numbers that are sorted by insertion
_AT_ONCE: Final = 64  # numbers that are compared with the limits of a bucket together
_LARGEST: Final = 0x7F800000  # pattern of infinity: those above it, and below that of its negative, are nan


@inner
def ordered(bits: Any) -> Any:
    """Return the pattern of a float32 as an integer in the order of the numbers."""
    return bits ^ ((bits >> np.int32(31)) & np.int32(0x7FFFFFFF))


@inner
def _take(patterns: Any, first: Any, last: Any, keys: Any) -> Any:
    """Write some columns of a table, each into a row of `keys`."""
    for finger in range(patterns.shape[0]):
        # a row is far from the one before: the processor does not request it by itself
        for column in range(first, last, _LINE):
            prefetch(patterns, min(finger + _AHEAD, patterns.shape[0] - 1), column)
        for column in range(first, last):
            keys[column - first, finger] = ordered(patterns[finger, column])


def numbers(found: NDArray[np.int32]) -> Real:
    """Return the numbers of patterns in their order; -0 becomes 0."""
    bits = found ^ ((found >> 31) & np.int32(0x7FFFFFFF))
    return np.asarray(bits.view(np.float32).astype(np.float64) + 0.0)


@outer
def order_statistics(
    patterns: Any,
    places: Any,
    first: Any,
    last: Any,
    keys: Any,
    some: Any,
    fewer: Any,
    counts: Any,
    found: Any,
) -> Any:
    """Write order statistics of some columns as patterns of float32 in their order; the largest integer where one is nan.

    A pass counts the numbers in buckets of equal width between the smallest and the largest, as integers; only those in
    the bucket of a place are kept for the next pass.
    """
    count = patterns.shape[0]
    together = keys.shape[0]
    for start in range(first, last, together):
        stop = min(start + together, last)
        _take(patterns, start, stop, keys)
        for column in range(start, stop):
            of_row(keys[column - start], count, places, some, fewer, counts, found[:, column])


@inner
def of_row(column: Any, count: Any, places: Any, some: Any, fewer: Any, counts: Any, found: Any) -> Any:
    """Write order statistics of the first numbers of one row of ordered patterns into `found`."""
    low, high = column[0], column[0]
    for finger in range(count):
        low, high = min(low, column[finger]), max(high, column[finger])
    if high > _LARGEST or low < -_LARGEST - 1:
        found[:] = 0x7FFFFFFF
        return
    shift = _count(column, count, np.int64(low), np.int64(high), counts)
    bucket, before, place = 0, 0, 0
    while place < len(places):
        while before + counts[bucket] <= places[place]:
            before += counts[bucket]
            bucket += 1
        begin = np.int64(low) + (np.int64(bucket) << shift)
        if shift == 0:
            found[place] = begin
            place += 1
            continue
        kept = _keep(column, count, begin, begin + (np.int64(1) << shift) - 1, some)
        while place < len(places) and places[place] < before + kept:
            for at in range(kept):
                fewer[at] = some[at]
            found[place] = _select(fewer, kept, places[place] - before)
            place += 1


@inner
def _count(column: Any, count: Any, low: Any, high: Any, counts: Any) -> Any:
    """Count the numbers in each bucket, and return the logarithm of its width."""
    shift = 0
    while (high - low) >> shift >= BUCKETS:
        shift += 1
    counts[:] = 0
    for finger in range(count):
        counts[(np.int64(column[finger]) - low) >> shift] += 1
    return shift


@inner
def _keep(column: Any, count: Any, low: Any, high: Any, some: Any) -> Any:
    """Keep the numbers between two limits, and return how many there are."""
    least, most, kept = np.int32(low), np.int32(min(high, 0x7FFFFFFF)), 0
    whole = count // _AT_ONCE * _AT_ONCE
    for start in range(0, whole, _AT_ONCE):
        inside = np.int32(0)  # a sum of 32 bits over unsigned places is vectorised; most sums are 0
        for at in range(np.uint64(start), np.uint64(start + _AT_ONCE)):
            inside = np.int32(inside + np.int32((column[at] >= least) & (column[at] <= most)))
        if inside:
            for at in range(start, start + _AT_ONCE):
                some[kept] = column[at]
                kept += (column[at] >= least) & (column[at] <= most)
    for at in range(whole, count):
        some[kept] = column[at]
        kept += (column[at] >= least) & (column[at] <= most)
    return kept


@inner
def _select(numbers: Any, count: Any, place: Any) -> Any:
    """Return the number at a place in the order of some numbers, which are exchanged."""
    low, high = 0, count - 1
    while high - low > _FEW:
        one, two, three = numbers[low], numbers[(low + high) // 2], numbers[high]
        pivot = max(min(one, two), min(max(one, two), three))
        left, right = low, high
        while left <= right:
            while numbers[left] < pivot:
                left += 1
            while numbers[right] > pivot:
                right -= 1
            if left <= right:
                numbers[left], numbers[right] = numbers[right], numbers[left]
                left, right = left + 1, right - 1
        if place <= right:
            high = right
        elif place >= left:
            low = left
        else:
            return numbers[place]
    for at in range(low + 1, high + 1):
        value, to = numbers[at], at
        while to > low and numbers[to - 1] > value:
            numbers[to] = numbers[to - 1]
            to -= 1
        numbers[to] = value
    return numbers[place]


@inner
def _key(bits: Any) -> Any:
    """Return the pattern of a float32 as an unsigned integer in the order of the numbers; -0 counts as 0."""
    unsigned = np.int64(bits) & 0xFFFFFFFF
    if unsigned == 0x80000000:
        unsigned = np.int64(0)
    return unsigned ^ (0xFFFFFFFF if unsigned >> 31 else 0x80000000)


@outer
def octaves_of(patterns: Any, first: Any, last: Any, found: Any, valid: Any) -> Any:
    """Write which octaves have numbers in some columns, and whether none of these is nan."""
    for finger in range(patterns.shape[0]):
        for column in range(first, last, _LINE):
            prefetch(patterns, min(finger + _AHEAD, patterns.shape[0] - 1), column)
        for column in range(first, last):
            key = _key(patterns[finger, column])
            found[column, key >> 23] = True
            if (patterns[finger, column] & 0x7FFFFFFF) > _LARGEST:
                valid[0] = False


@outer
def count_bins(patterns: Any, pages: Any, first: Any, last: Any, counts: Any) -> Any:
    """Add the numbers of some columns to the counts of their bins."""
    for finger in range(patterns.shape[0]):
        for column in range(first, last, _LINE):
            prefetch(patterns, min(finger + _AHEAD, patterns.shape[0] - 1), column)
        for column in range(first, last):
            key = _key(patterns[finger, column])
            counts[pages[column, key >> 23], (key >> 15) & 255] += 1
