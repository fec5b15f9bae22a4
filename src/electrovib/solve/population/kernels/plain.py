"""The loops over fingers as operations on arrays: what `loops` computes, readable, and used where numba is not installed."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

_TOGETHER: Final = 64
"""Fingers whose differences are in memory together."""
_MINUS_ZERO: Final = -(2**31)
"""Bit pattern of a float32."""


def turn(table: Any, first: int, rows: Any) -> None:
    """Write the columns of a table from one on into rows."""
    rows[:] = table[:, first : first + len(rows)].T


def count_columns(
    patterns: Any, first: int, last: int, pages: Any, counts: Any, missing: Any, again: bool
) -> int:
    """Count the numbers of some columns in a histogram, and return how many lie in octaves that have no memory."""
    bits = patterns[:, first:last]
    bits = np.where(bits == _MINUS_ZERO, np.int32(0), bits)
    keys = (bits ^ ((bits >> np.int32(31)) & np.int32(0x7FFFFFFF))).view(np.uint32) ^ np.uint32(0x80000000)
    times, octaves = np.broadcast_to(np.arange(first, last), keys.shape), keys >> np.uint32(23)
    page = pages[times, octaves]
    absent = page < 0
    wanted = ~absent & missing[times, octaves] if again else ~absent
    np.add.at(counts, (page[wanted], (keys[wanted] >> np.uint32(15)) & np.uint32(255)), 1)
    missing[times[absent], octaves[absent]] = True
    return int(np.count_nonzero(absent))


def add_moments(values: Any, shift: Any, total: Any, square: Any) -> None:
    """Add the differences of fingers from one number for each sample, and their squares."""
    for begin in range(0, len(values), _TOGETHER):
        apart = values[begin : begin + _TOGETHER] - shift
        total += apart.sum(axis=0)
        square += np.einsum("ij,ij->j", apart, apart)
