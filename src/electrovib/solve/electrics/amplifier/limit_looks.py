"""The times at which an amplifier is checked against its limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive

PER_CYCLE = 64
"""Checks in each cycle of the drive's fastest oscillation: a maximum is at most 0.12 % above the nearest check."""
_SHARES = np.unique(
    np.concatenate([[0.0, 1 - 1e-9], np.geomspace(1e-9, 1.0, 40)[:-1], np.linspace(0.0, 1.0, 33)[:-1]])
)
"""Checks between one corner and the next, as shares of the time between them."""
_FIRST, _MOST = 128, 1 << 16
"""Number of checks in the first and in the longest window after a change."""


class LimitLooks:
    """Times from a given time on at which an amplifier is checked against its limits, in growing windows.

    Parameters
    ----------
    drive : Drive
        Off before time 0.
    end : float
        Last time [s].
    """

    def __init__(self, drive: Drive, end: float) -> None:
        corners = drive.corners(end)[0]
        self.end, self.frequency = end, drive.highest_frequency
        self.corners = np.unique(np.concatenate([[0.0], corners[corners <= end], [end]]))

    def after(self, start: float) -> Iterator[Real]:
        """Yield windows of times at which the amplifier is checked."""
        if start >= self.end:
            return
        count, last = _FIRST, start
        following = self.corners[np.searchsorted(self.corners, start, side="right")]
        soon = start + _SHARES * (following - start)
        while last < self.end:
            stop = self._reach(last, count)
            window = np.concatenate([self._between(last, stop), soon, [stop]])
            yield np.unique(window[(window > last) & (window <= stop)])
            count, last = min(2 * count, _MOST), stop

    def _reach(self, start: float, count: int) -> float:
        """Return the end of a window of so many checks [s]."""
        place = int(np.searchsorted(self.corners, start, side="right"))
        corner = self.corners[min(place + count // len(_SHARES), len(self.corners) - 1)]
        even = start + count / PER_CYCLE / self.frequency if self.frequency else self.end
        return float(min(corner, max(even, np.nextafter(start, np.inf)), self.end))

    def _between(self, start: float, stop: float) -> Real:
        first = max(int(np.searchsorted(self.corners, start, side="right")) - 1, 0)
        beyond = int(np.searchsorted(self.corners, stop, side="left"))
        begins = self.corners[first:beyond, None]
        spans = np.diff(self.corners[first : beyond + 1])[:, None]
        even = np.linspace(start, stop, 1 + int(np.ceil((stop - start) * self.frequency * PER_CYCLE)))
        return np.concatenate([(begins + _SHARES * spans).ravel(), even])
