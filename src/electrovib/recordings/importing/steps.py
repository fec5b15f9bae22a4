"""Reduction of sampled signals: alignment, baseline, trend, resampling, cropping, and averages over periods."""

from __future__ import annotations

import re
from dataclasses import dataclass
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


_LOW, _HIGH = 0.3, 0.7
"""Fractions of the range of a signal that it has to pass below and above between two edges."""
_FEWEST_SAMPLES: Final = 8
"""Fewest samples of a period."""


@dataclass(frozen=True, kw_only=True)
class SignalEdges:
    """Times [s] at which a signal passes the middle of its range, increasing, interpolated linearly."""

    rising: Real
    falling: Real


@dataclass(frozen=True, kw_only=True)
class PeriodAverage:
    """Signals averaged over periods, from their first edge on; `spread` is the standard deviation of the periods [s]."""

    time: Real
    means: dict[str, Real]
    standard_errors: dict[str, Real]
    periods: int
    period: float
    spread: float


def find_edges(time: Real, values: Real) -> SignalEdges:
    """Find the edges at the mean of the 5 % and 95 % quantiles of a signal, with a hysteresis of 40 % of its range."""
    low, high = np.quantile(values, [0.05, 0.95])
    if high == low:
        low, high = values.min(), values.max()
    state = np.where(
        values > low + _HIGH * (high - low), 1, np.where(values < low + _LOW * (high - low), -1, 0)
    )
    known = np.flatnonzero(state)
    turns = np.flatnonzero(np.diff(state[known]))
    level = (low + high) / 2
    found: dict[int, list[float]] = {1: [], -1: []}
    for first, last in zip(known[turns], known[turns + 1], strict=True):
        sign = int(state[last])
        part = slice(first, last + 1)
        after = first + int(np.argmax(sign * (values[part] - level) >= 0))
        before = after - 1
        share = (level - values[before]) / (values[after] - values[before])
        found[sign].append(float(time[before] + share * (time[after] - time[before])))
    return SignalEdges(rising=np.array(found[1]), falling=np.array(found[-1]))


def average_periods(time: Real, signals: dict[str, Real], by: str) -> PeriodAverage:
    """Average signals over the periods between rising edges of one of them, stretched to the mean period."""
    finite = np.isfinite(signals[by])
    edges = find_edges(time[finite], signals[by][finite]).rising if finite.any() else np.array([])
    lengths = np.diff(edges)
    if lengths.size < 2:
        raise InputError(
            f"average = {by}: it has {lengths.size} whole periods between rising edges; two are needed"
        )
    period = float(lengths.mean())
    if np.abs(lengths - period).max() > period / 4:
        raise InputError(
            f"average = {by}: its periods differ, from {lengths.min():.4g} to {lengths.max():.4g} s; crop the record to where it"
            " is periodic"
        )
    count = round(period / float(np.median(np.diff(time))))
    if count < _FEWEST_SAMPLES:
        raise InputError(
            f"average = {by}: a period has {count} samples; at least {_FEWEST_SAMPLES} are needed"
        )
    phase = np.arange(count) / count
    at = edges[:-1, None] + phase * lengths[:, None]
    means, errors = {}, {}
    for name, values in signals.items():
        rows = np.interp(at, time, values)
        means[name] = rows.mean(axis=0)
        errors[name] = rows.std(axis=0, ddof=1) / np.sqrt(lengths.size)
    return PeriodAverage(
        time=period * phase, means=means, standard_errors=errors, periods=lengths.size, period=period,
        spread=float(lengths.std(ddof=1)),
    )  # fmt: skip
