"""Sections of a record in which a condition holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


Span = tuple[int, int]
"""Index of the first sample of a section, and of the sample after its last."""


def _scatter_about_two_levels(values: Real) -> float:
    """Return the sum of squares about the means of the two groups for which it is least."""
    level = _split(values)
    high = values > level
    return float(
        sum(np.sum((part - part.mean()) ** 2) for part in (values[high], values[~high]) if len(part))
    )


def _split(values: Real) -> float:
    """Find the level that splits values into two groups of least scatter (Otsu's threshold)."""
    ordered = np.sort(values)
    count = np.arange(1, len(ordered))
    left = np.cumsum(ordered)[:-1]
    right = ordered.sum() - left
    between = count * (len(ordered) - count) * (left / count - right / (len(ordered) - count)) ** 2
    return float(ordered[int(np.argmax(between))])


def _closed(mask: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """Fill gaps between two true sections that are shorter than a number of samples."""
    filled = mask.copy()
    gaps = [gap for gap in _runs(~mask) if gap[0] > 0 and gap[1] < len(mask)]
    for first, last in gaps:
        if last - first < count:
            filled[first:last] = True
    return filled


def _runs(mask: NDArray[np.bool_]) -> list[Span]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _run_length(mask: NDArray[np.bool_]) -> int:
    false = np.flatnonzero(~mask)
    return int(false[0]) if len(false) else len(mask)
