"""Reduction steps of sampled signals: alignment, baseline, trend, resampling and cropping."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_SPAN: Final = re.compile(r"\s*(.*?)\s*(?:\.\.|:| to )\s*(.*?)\s*")


def seconds(option: str, value: str | float) -> float:
    """Return a time [s] given as a number or as text with a unit."""
    try:
        return parse_quantity(value, "s") if isinstance(value, str) else float(value)
    except ValueError as error:
        raise InputError(f"{option} = {value}: {error}") from None


def time_span(option: str, value: str | tuple[float, float]) -> tuple[float, float]:
    """Return the ends of a time span such as ``"0 s..2 s"``; an end that is omitted is infinite."""
    if isinstance(value, str):
        match = _SPAN.fullmatch(value)
        if match is None:
            raise InputError(f"{option} = {value}: expected a span of time, such as '0 s..2 s'")
        first = seconds(option, match[1]) if match[1] else -np.inf
        last = seconds(option, match[2]) if match[2] else np.inf
    else:
        first, last = map(float, value)
    if not first < last:
        raise InputError(f"{option} = {value}: the end is not after the beginning")
    return first, last


def trigger_time(time: Real, values: Real, level: float | None = None) -> float | None:
    """Return the time at which a signal first rises through a level, by default the middle of its range; None if never."""
    finite = np.isfinite(values)
    if level is None:
        low, high = np.quantile(values[finite], [0.05, 0.95]) if finite.any() else (0.0, 0.0)
        if high == low:
            low, high = (values[finite].min(), values[finite].max()) if finite.any() else (0.0, 0.0)
        level = float(low + high) / 2
    rises = (values[:-1] < level) & (values[1:] >= level)
    if not rises.any():
        return None
    at = int(np.argmax(rises))
    share = (level - values[at]) / (values[at + 1] - values[at])
    return float(time[at] + share * (time[at + 1] - time[at]))


def shifted(time: Real, values: Real, shift: float) -> Real:
    """Return a signal whose samples were taken `shift` later than their time stamps state; NaN outside of the record."""
    return np.interp(time, time + shift, values, left=np.nan, right=np.nan)


def without_trend(time: Real, values: Real) -> tuple[Real, float]:
    """Subtract the straight line fitted to a signal, and return its slope per second too."""
    finite = np.isfinite(values)
    centred = time - time[finite].mean()
    slope = float(np.sum(centred[finite] * values[finite]) / np.sum(centred[finite] ** 2))
    return values - values[finite].mean() - slope * centred, slope


def resampled(time: Real, values: Real, grid: Real) -> Real:
    """Return a signal on an even time grid within its times, by linear interpolation.

    Where the step of the grid exceeds the median interval of the samples, it is the mean of the interpolation
    over one step around each time, which attenuates components above half the new sampling rate. NaN where a
    sample that takes part is NaN.
    """
    step = float(grid[1] - grid[0])
    lost = np.isnan(values)
    if lost.any():
        kept = ~lost
        if np.count_nonzero(kept) < 2:
            return np.full(grid.size, np.nan)
        found = resampled(time[kept], values[kept], grid)
        number = np.concatenate([[0], np.cumsum(lost)])
        reach = step / 2 if step > float(np.median(np.diff(time))) * (1 + 1e-9) else 0.0
        first = np.clip(np.searchsorted(time, grid - reach, side="right") - 1, 0, time.size - 1)
        last = np.clip(np.searchsorted(time, grid + reach, side="left"), 0, time.size - 1)
        return np.where(number[last + 1] > number[first], np.nan, found)
    if step <= float(np.median(np.diff(time))) * (1 + 1e-9):
        return np.interp(grid, time, values)
    whole = np.concatenate([[0.0], np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2)])
    low = np.clip(grid - step / 2, time[0], time[-1])
    high = np.clip(grid + step / 2, time[0], time[-1])
    return (_integral(time, values, whole, high) - _integral(time, values, whole, low)) / (high - low)


def _integral(time: Real, values: Real, whole: Real, at: Real) -> Real:
    """Return the integral of the linear interpolation from the first time to each time."""
    place = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    ahead = at - time[place]
    slope = (values[place + 1] - values[place]) / (time[place + 1] - time[place])
    return np.asarray(whole[place] + ahead * (values[place] + slope * ahead / 2))
