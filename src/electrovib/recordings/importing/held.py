"""Records that have a row only where something changes, as logic analysers and logs of events write them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded


_FEWEST: Final = 4
_MOST_LEVELS: Final = 16
_SHARE: Final = 2 / 3
"""Largest number of levels, in units of the number of rows; readings hardly repeat."""
_INSPECTED: Final = 1000
"""Rows in which more levels than a record of changes has are looked for first."""
_ALIKE: Final = 0.1
"""Deviation from the median interval, relative to it, within which an interval is a usual one."""
_EVEN: Final = 0.6
"""Share of usual intervals from which on a record is one of samples, some of which may be missing."""
_EDGE: Final = 1e-6
"""Time between two levels, in units of the shortest interval."""


def is_held(time: Real, recorded: Recorded, clock: str) -> bool:
    """Return whether each row differs from the one before, at uneven times, and no column has more than a few levels.

    Times do not matter where each column has two levels: samples of such a signal would repeat.
    """
    times = {recorded.time, clock, *(each.time for each in recorded.clocks.values())}
    columns = [
        each.values for each in recorded.channels if each.name not in times and each.values.size == time.size
    ]
    if len(columns) < 1 or time.size < _FEWEST:
        return False
    if any(np.unique(each[:_INSPECTED]).size > _MOST_LEVELS for each in columns):
        return False
    rows = np.nan_to_num(np.array(columns), nan=np.inf)
    levels = max(np.unique(each).size for each in rows)
    changes = (np.diff(rows, axis=1) != 0).any(axis=0)
    if (
        levels > min(_MOST_LEVELS, _SHARE * time.size) or not changes[:-1].all()
    ):  # the last row may be the end alone
        return False
    change = np.diff(time)
    usual = np.abs(change - np.median(change)) <= _ALIKE * np.median(change)
    return levels == 2 or float(np.mean(usual)) < _EVEN


def held(time: Real, signals: dict[str, Real]) -> tuple[Real, dict[str, Real]]:
    """Return signals that keep each value until just before the next row, so that lines between their samples are levels."""
    before = np.minimum(time[1:] - _EDGE * np.diff(time).min(), np.nextafter(time[1:], -np.inf))
    found = np.append(np.stack([time[:-1], before], axis=1).ravel(), time[-1])
    return found, {name: np.append(np.repeat(values[:-1], 2), values[-1]) for name, values in signals.items()}
