"""Errors that are bounded at some times, the probes, compared with a quantity at all output times.

Between two probes the larger bound counts. Of a long record the smallest and largest values between the probes suffice.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.solve.stack.keys import Key

PROBES: Final = 400
"""Output times at which the response of D is evaluated; between two of them the larger value counts."""
_GOLDEN: Final = 0.6180339887498949
TAIL: Final = 1e-4
"""Share of the peak down to which an error is relative to the value at that time."""
LARGEST: Final = 0.01
"""Error over the remaining amplitude of a quantity, above which the quantity counts as unknown."""
LOOKING_BACK: Final = 0.9
"""Fraction of a time from which on the remaining amplitude at that time is taken."""
MANY: Final = 20_000
"""Number of output times above which the smallest and largest values between probes are tried first."""


def probe_places(count: int) -> NDArray[np.intp]:
    """Return indices of output times: all of few; of many a nearly even choice that is in step with no periodic drive."""
    if count <= PROBES:
        return np.arange(count)
    share = np.arange(PROBES)
    spread = (share + (share * _GOLDEN) % 1) / PROBES
    slow = np.geomspace(1, count - 1, PROBES // 5)  # the decay at the end, and the times after the beginning
    places = np.concatenate([[0, count - 1], np.floor(spread * count), slow])
    return np.unique(places.astype(np.intp))


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
    jump : float
        Largest error over the peak at the discontinuities of the drive themselves [1].
    """

    error: float
    share: float
    lost: float
    of_peak: float
    jump: float = 0.0


def judge(
    rows: Real,
    times: Real,
    probes: NDArray[np.intp],
    bounds: Real,
    judged: NDArray[np.bool_],
    name: Key = "",
    noted: Extremes | None = None,
) -> list[Judged]:
    """Compare error bounds at the probes with a quantity of every case at all output times.

    `rows` at `times` [s], (cases, n); `bounds` (cases, m) in its unit at the indices `probes` (m,); only times that `judged`
    (n,) marks count. `noted` has the extremes of this quantity of one case, by its name.
    """
    if not np.any(judged):
        return [Judged(0.0, 0.0, np.inf, 0.0) for _ in rows]
    if noted is None and len(judged) > MANY and len(rows) == 1:
        noted = Extremes(times[0], probes)
        noted.take(0, {name: rows[0]})
    if noted is not None:
        found = noted.judge(name, rows[0], bounds, judged)
        if found is not None:
            return [found]
    sizes, places = np.where(judged, np.abs(rows), 0.0), np.arange(len(judged))
    larger = np.where(judged, _between_probes(probes, bounds, places), 0.0)
    left = np.maximum.accumulate(sizes[:, ::-1], axis=1)[:, ::-1]
    if np.all(LOOKING_BACK * times[:, -1] <= times[:, 0]):
        left = left[:, :1]
    else:
        back = [np.searchsorted(own, LOOKING_BACK * own) for own in times]
        left = np.take_along_axis(left, np.array(back), axis=1)
    return _compared(sizes, sizes, left, larger, times)


def _between_probes(probes: NDArray[np.intp], bounds: Real, places: NDArray[np.intp]) -> Real:
    """Return bounds at some places: at a probe its own, between two probes the larger, shape (cases, places)."""
    after = np.minimum(np.searchsorted(probes, places), len(probes) - 1)
    here = bounds[:, after]
    return np.where(probes[after] == places, here, np.maximum(here, bounds[:, after - 1]))


def _compared(low: Real, high: Real, left: Real, larger: Real, times: Real) -> list[Judged]:
    """Compare error bounds with the smallest, largest and remaining amplitudes of stretches of time, all (cases, stretches)."""
    largest = np.max(high, axis=1, keepdims=True)
    large, there = high > TAIL * largest, left > TAIL * largest
    errors = np.max(np.where(large, larger / np.where(large, low, 1.0), 0.0), axis=1)
    shares = np.where(there, larger / np.where(there, left, 1.0), 0.0)
    beyond = shares > LARGEST
    lost = np.where(beyond.any(axis=1), times[np.arange(len(times)), np.argmax(beyond, axis=1)], np.inf)
    of_peak = np.max(larger, axis=1) / np.where(largest > 0, largest, np.inf)[:, 0]
    columns = [each.tolist() for each in (errors, np.max(shares, axis=1), lost, of_peak)]
    return [Judged(*each) for each in zip(*columns, strict=True)]


class Extremes:
    """Smallest and largest absolute values of quantities between the probes, from a record of one case in stretches.

    `times` (n,) [s], `probes` (m,) indices, `unjudged` the names of quantities without an error. Between two probes the bound
    is constant, so the smallest value has the largest relative error. The remaining amplitude never grows, so the share is
    largest at the end of an interval.
    """

    def __init__(self, times: Real, probes: NDArray[np.intp], unjudged: Collection[Key] = ()) -> None:
        self.unjudged, self.times, self.probes, self.end = unjudged, times, probes, int(probes[-1]) + 1
        self.starts = np.unique(np.concatenate([probes, probes[:-1] + 1]))
        ends = np.append(self.starts[1:], self.end) - 1
        self.back = np.maximum(np.searchsorted(times, LOOKING_BACK * times[ends]), probes[0])
        self.marks = np.union1d(self.starts, self.back)
        self.found: dict[Key, tuple[Real, Real]] = {}

    def take(self, first: int, rows: Mapping[Key, Real]) -> None:
        """Note the values of a stretch that begins with this index."""
        inside = slice(max(int(self.starts[0]) - first, 0), max(self.end - first, 0))
        each = {id(row): row for name, row in rows.items() if row.ndim == 1 and name not in self.unjudged}
        if not each or not (count := len(next(iter(each.values()))[inside])):
            return
        begin, sizes = first + inside.start, np.empty((len(each), count))
        for row, size in zip(each.values(), sizes, strict=True):
            np.abs(row[inside], out=size)
        for which, (edges, compare) in enumerate(((self.starts, np.minimum), (self.marks, np.maximum))):
            begins = max(int(np.searchsorted(edges, begin, side="right")) - 1, 0)
            some = slice(begins, int(np.searchsorted(edges, begin + count)))
            seen = compare.reduceat(sizes, np.maximum(edges[some] - begin, 0), axis=1)
            for name in [name for name, row in rows.items() if id(row) in each]:
                if name not in self.found:
                    self.found[name] = np.full(len(self.starts), np.inf), np.zeros(len(self.marks))
                known = self.found[name][which][some]
                compare(known, seen[list(each).index(id(rows[name]))], out=known)

    def judge(
        self, name: Key, row: Real, bounds: Real, judged: NDArray[np.bool_] | None = None
    ) -> Judged | None:
        """Return the result of `judge` for a quantity (n,) with bounds (1, m); None where these values do not suffice.

        Times that are not `judged` (n,) are whole intervals, for instance a probe at a corner.
        """
        if name not in self.found:
            return None
        low, highs = (each.copy() for each in self.found[name])
        starts, begin = self.starts, self.starts[0]
        larger = _between_probes(self.probes, bounds, starts)
        if judged is not None and not np.all(judged):
            whole = np.logical_and.reduceat(judged[begin : self.end], starts - begin)
            if np.any(np.logical_or.reduceat(judged[begin : self.end], starts - begin) != whole):
                return None
            larger = np.where(whole, larger, 0.0)
            highs[~whole[np.searchsorted(starts, self.marks, side="right") - 1]] = 0.0
        high = np.maximum.reduceat(highs, np.searchsorted(self.marks, starts))
        peak = TAIL * float(np.max(high))
        for place in np.flatnonzero((low <= peak) & (high > peak)):
            some = np.abs(row[starts[place] : self.end if place + 1 == len(starts) else starts[place + 1]])
            low[place] = some[some > peak].min()
        left = np.maximum.accumulate(highs[::-1])[::-1][np.searchsorted(self.marks, self.back)]
        (found,) = _compared(low[None], high[None], left[None], larger, self.times[None])
        return found if peak > 0 and np.all(left > peak) and found.share <= LARGEST else None
