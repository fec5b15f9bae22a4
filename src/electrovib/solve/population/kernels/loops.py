"""Loops over fingers that numba compiles: columns of a table as rows, counts and moments.

They run without the lock of the interpreter, and are kept on disk where there is a folder for it.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from electrovib.solve.recursion.compiling import inner, outer

TURNED: Final = 16
"""Numbers of a column of a table that are turned into part of a row together."""
_MINUS_ZERO: Final = -(2**31)  # bit pattern of a float32


@inner
def _ordered(bits: Any) -> Any:
    """Return the bit pattern of a float32 as an integer in the order of the numbers."""
    return bits ^ ((bits >> np.int32(31)) & np.int32(0x7FFFFFFF))


@outer
def turn(table: Any, first: Any, rows: Any) -> Any:
    """Write the columns of a table from one on into rows, some numbers of a column at once."""
    for begin in range(0, len(table), TURNED):
        end = min(begin + TURNED, len(table))
        for column in range(len(rows)):
            row, at = rows[column], np.uint64(first + column)
            for place in range(np.uint64(begin), np.uint64(end)):
                row[place] = table[place, at]


@outer
def count_columns(
    patterns: Any, first: Any, last: Any, pages: Any, counts: Any, missing: Any, again: Any
) -> Any:
    """Count the numbers of some columns in a histogram, and return how many lie in octaves that have no memory.

    The octaves without memory are written into `missing`, (times, octaves). Where `again` holds, only the numbers of
    these octaves are counted. No number may be nan.
    """
    missed = 0
    for row in patterns:
        for time in range(np.uint64(first), np.uint64(last)):
            bits = row[time] if row[time] != _MINUS_ZERO else np.int32(0)
            key = np.uint32(_ordered(bits)) ^ np.uint32(0x80000000)
            octave = key >> np.uint32(23)
            page = pages[time, octave]
            if page < 0:
                missing[time, octave] = True
                missed += 1
            elif not again or missing[time, octave]:
                counts[np.uint32(page), (key >> np.uint32(15)) & np.uint32(255)] += 1
    return missed


@outer
def add_moments(values: Any, shift: Any, total: Any, square: Any) -> Any:
    """Add the differences of fingers from one number for each sample, and their squares."""
    whole = len(values) // 4 * 4
    for finger in range(0, whole, 4):  # four at once: the sums are read and written once for all
        a, b, c, d = values[finger], values[finger + 1], values[finger + 2], values[finger + 3]
        for sample in range(np.uint64(0), np.uint64(len(shift))):
            less = shift[sample]
            p, q, r, s = a[sample] - less, b[sample] - less, c[sample] - less, d[sample] - less
            total[sample] += (p + q) + (r + s)
            square[sample] += (p * p + q * q) + (r * r + s * s)
    for row in values[whole:]:
        for sample in range(len(shift)):
            apart = row[sample] - shift[sample]
            total[sample] += apart
            square[sample] += apart * apart
