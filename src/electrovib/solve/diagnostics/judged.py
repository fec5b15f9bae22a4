"""Comparison of an error bound, known at some times, with a quantity at all output times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

TAIL: Final = 1e-4
"""Share of the peak down to which an error is relative to the value at that time."""
LARGEST: Final = 0.01
"""Error over the remaining amplitude of a quantity, above which the quantity counts as unknown."""
LOOKING_BACK: Final = 0.9
"""Fraction of a time from which on the remaining amplitude at that time is taken."""
_MANY: Final = 20_000
"""Number of output times above which the smallest and largest values between probes are tried first."""
_AT_ONCE: Final = 1 << 15


class Judged(NamedTuple):
    """Relative error of a quantity over time.

    Parameters
    ----------
    error : float
        Largest error over the value at the same time [1], where that value exceeds `TAIL` of the peak.
    share : float
        Largest error over the remaining amplitude [1], the largest value from `LOOKING_BACK` of that time on.
    lost : float
        First time at which that share exceeds `LARGEST` [s]; infinite if it never does.
    of_peak : float
        Largest error over the peak [1].
    """

    error: float
    share: float
    lost: float
    of_peak: float


def judge(row: Real, times: Real, probes: NDArray[np.intp], bound: Real, judged: NDArray[np.bool_]) -> Judged:
    """Compare an error bound at the probes with a quantity at all output times.

    `row` (n,), `times` (n,) [s], `probes` (m,), `bound` (m,), `judged` (n,).
    """
    if not np.any(judged):
        return Judged(0.0, 0.0, np.inf, 0.0)
    if len(row) > _MANY:
        found = _judge_by_stretches(row, times, probes, bound, judged)
        if found is not None:
            return found
    sizes, places = np.where(judged, np.abs(row), 0.0), np.arange(len(row))
    after = np.minimum(np.searchsorted(probes, places), len(probes) - 1)
    larger = np.where(probes[after] == places, bound[after], np.maximum(bound[after], bound[after - 1]))
    left = np.maximum.accumulate(sizes[::-1])[::-1][np.searchsorted(times, LOOKING_BACK * times)]
    large, peak = sizes > TAIL * np.max(sizes), TAIL * np.max(sizes)
    shares = np.where(judged & (left > peak), larger / np.maximum(left, peak or 1.0), 0.0)
    lost = times[shares > LARGEST]
    return Judged(
        error=float(np.max(larger[large] / sizes[large], initial=0.0)),
        share=float(np.max(shares, initial=0.0)),
        lost=float(lost[0]) if len(lost) else np.inf,
        of_peak=float(np.max(np.where(judged, larger, 0.0)) / (np.max(sizes) or np.inf)),
    )


def judge_repeating(rows: Real, times: Real, bounds: Real) -> list[Judged]:
    """Return the results of `judge` for many periodic cases, whose remaining amplitude is always the largest value.

    `rows` (cases, n), `times` (cases, n) [s], `bounds` (cases, n).
    """
    sizes = np.abs(rows)
    largest = np.max(sizes, axis=1)[:, None]
    large = sizes > TAIL * largest
    errors = np.max(np.where(large, bounds / np.where(large, sizes, 1.0), 0.0), axis=1)
    shares = np.where(largest > 0, bounds / np.where(largest > 0, largest, 1.0), 0.0)
    beyond = shares > LARGEST
    lost = np.where(np.any(beyond, axis=1), times[np.arange(len(times)), np.argmax(beyond, axis=1)], np.inf)
    share = np.max(shares, axis=1).tolist()
    columns = errors.tolist(), share, lost.tolist(), share
    return [Judged(*each) for each in zip(*columns, strict=True)]


def _judge_by_stretches(
    row: Real, times: Real, probes: NDArray[np.intp], bound: Real, judged: NDArray[np.bool_]
) -> Judged | None:
    """Return the result of `judge` from the smallest and largest values between probes; None where these do not suffice.

    Between two probes the bound is constant, so the smallest value has the largest relative error. The remaining
    amplitude never grows, so the share is largest at the end of an interval.
    """
    if not np.all(judged[probes[0] : probes[-1] + 1]):
        return None
    inside = slice(probes[0], probes[-1] + 1)
    starts = np.unique(np.concatenate([probes, probes[:-1] + 1])) - probes[0]
    count = inside.stop - inside.start
    ends = np.append(starts[1:], count) - 1
    back = np.searchsorted(times, LOOKING_BACK * times[ends + probes[0]]) - probes[0]
    marks = np.union1d(starts, np.maximum(back, 0))
    lows, highs = _between(row[inside], marks)
    groups = np.searchsorted(marks, starts)
    low, high = np.minimum.reduceat(lows, groups), np.maximum.reduceat(highs, groups)
    largest = float(np.max(high))
    peak = TAIL * largest
    if not peak > 0:
        return None
    for place in np.flatnonzero((low <= peak) & (high > peak)):
        some = np.abs(row[inside][starts[place] : ends[place] + 1])
        low[place] = np.min(some[some > peak])
    after = np.searchsorted(probes - probes[0], starts)
    at_probe = probes[after] - probes[0] == starts
    larger = np.where(at_probe, bound[after], np.maximum(bound[after], bound[after - 1]))
    left = np.maximum.accumulate(highs[::-1])[::-1][np.searchsorted(marks, np.maximum(back, 0))]
    shares = larger / left
    if not (np.all(left > peak) and np.all(shares <= LARGEST)):
        return None
    large = high > peak
    error, share = float(np.max(larger[large] / low[large], initial=0.0)), float(np.max(shares))
    return Judged(error, share, np.inf, float(np.max(larger)) / largest)


def _between(row: Real, marks: NDArray[np.intp]) -> tuple[Real, Real]:
    """Return the smallest and largest absolute values from each mark to the next; the first mark is 0."""
    lows, highs = np.empty(len(marks)), np.empty(len(marks))
    ends = np.append(marks[1:], len(row))
    first = 0
    while first < len(marks):
        last = max(first + 1, int(np.searchsorted(ends, marks[first] + _AT_ONCE)))
        sizes, places = np.abs(row[marks[first] : ends[last - 1]]), marks[first:last] - marks[first]
        lows[first:last], highs[first:last] = (
            np.minimum.reduceat(sizes, places),
            np.maximum.reduceat(sizes, places),
        )
        first = last
    return lows, highs
