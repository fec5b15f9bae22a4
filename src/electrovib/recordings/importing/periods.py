"""Edges and periods of sampled signals, and averages over periods."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

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
