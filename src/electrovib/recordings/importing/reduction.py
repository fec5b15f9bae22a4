"""Reduction of imported signals, in one order: alignment, baseline, trend, resampling, cropping, averages over periods."""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity, number_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.recording import SensorCalibration


Span: TypeAlias = "str | tuple[float, float]"
_MOST_SAMPLES: Final = 50_000_000
"""Largest number of samples of a new time grid."""


@dataclass(frozen=True, kw_only=True)
class ReductionSteps:
    """Steps that are applied to the signals of a file, in this order.

    - `scale`, `offset`: sensitivity or `SensorCalibration` of a signal, and the reading that is subtracted.
    - `shift`: time that is added to the time stamps of a signal [s].
    - `trigger`: signal whose first rise through the middle of its range, as `find_edges` finds it, becomes time 0.
    - `baseline`, `detrend`: span of time whose mean, and signals whose fitted straight line, is subtracted.
    - `average`: signal whose rising edges begin the periods over which all signals are averaged.
    - `resample`: step of an even time grid [s].
    """

    scale: Mapping[str, str | float | SensorCalibration] = field(default_factory=dict)
    offset: Mapping[str, str | float] = field(default_factory=dict)
    shift: Mapping[str, str | float] = field(default_factory=dict)
    trigger: str = ""
    baseline: Mapping[str, Span] = field(default_factory=dict)
    detrend: tuple[str, ...] = ()
    crop: Span | None = None
    average: str = ""
    resample: str | float | None = None


def reduced(
    time: Real, signals: dict[str, Real], steps: ReductionSteps
) -> tuple[Real, dict[str, Real], list[str]]:
    """Apply the steps to calibrated signals, in their order, with one sentence for each step."""
    found = _Reduced(time, signals)
    words = [*found.align(steps), *found.level(steps)]
    words += found.average(steps.average) if steps.average else ()
    words += found.resample(seconds("resample", steps.resample)) if steps.resample is not None else ()
    return found.time, found.signals, words


@dataclass
class _Reduced:
    """Signals over time as far as they are reduced; each step states what was done."""

    time: Real
    signals: dict[str, Real]

    def align(self, steps: ReductionSteps) -> Iterator[str]:
        """Shift signals, and count the time from a trigger."""
        for name, value in steps.shift.items():
            shift = seconds(f"shift.{name}", value)
            self.signals[name] = shifted(self.time, self.signals[name], shift)
            yield f"{name}: {format_quantity(shift, 's')} added to its time stamps, interpolated linearly"
        if steps.shift:
            self.keep(np.all([np.isfinite(self.signals[name]) for name in steps.shift], axis=0), "shift")
        if steps.trigger:
            rises = find_edges(self.time, self.signals[steps.trigger]).rising
            where = f"{steps.trigger} first rises through the middle of its range"
            if not rises.size:
                raise InputError(
                    f"trigger = {steps.trigger}: it does not rise through the middle of its range"
                )
            self.time = self.time - rises[0]
            yield f"time: 0 where {where}, {format_quantity(float(rises[0]), 's')}"

    def level(self, steps: ReductionSteps) -> Iterator[str]:
        """Subtract means and trends, and crop."""
        time = self.time
        for name, span in steps.baseline.items():
            first, last = time_span(f"baseline.{name}", span)
            part = self.signals[name][(time >= first) & (time <= last)]
            part = part[np.isfinite(part)]
            if not part.size:
                raise InputError(
                    f"baseline.{name} = {span}: no sample lies in it; the record has {span_words(time)}"
                )
            self.signals[name] = self.signals[name] - part.mean()
            yield f"{name}: mean {part.mean():.10g} of {part.size} samples in {span} subtracted"
        for name in steps.detrend:
            values = self.signals[name]
            finite = np.isfinite(values)
            centred = time - time[finite].mean()
            slope = float(np.sum(centred[finite] * values[finite]) / np.sum(centred[finite] ** 2))
            self.signals[name] = values - values[finite].mean() - slope * centred
            yield f"{name}: fitted straight line with slope {slope:.10g} per s subtracted"
        if steps.crop is not None:
            first, last = time_span("crop", steps.crop)
            self.keep((time >= first) & (time <= last), "crop")
            yield f"time: {steps.crop} kept"

    def average(self, by: str) -> Iterator[str]:
        """Average over the periods of a signal."""
        self.time, self.signals, errors, lengths = average_periods(self.time, self.signals, by)
        period, spread = float(lengths.mean()), float(lengths.std(ddof=1))
        rms = (
            f"{name}: rms of the standard error {np.sqrt(np.mean(each**2)):.4g}"
            for name, each in errors.items()
        )
        yield (
            f"averaged over {lengths.size} periods of {by}, {format_quantity(period, 's')} on average with a standard"
            f" deviation of {format_quantity(spread, 's', digits=3)}; time 0 at its rising edge; {', '.join(rms)}"
        )

    def keep(self, inside: NDArray[np.bool_], option: str) -> None:
        """Omit samples."""
        if np.count_nonzero(inside) < 2:
            raise InputError(f"{option}: fewer than two samples remain of {span_words(self.time)}")
        self.time = self.time[inside]
        self.signals = {name: values[inside] for name, values in self.signals.items()}

    def resample(self, step: float) -> Iterator[str]:
        """Bring all signals onto an even grid."""
        time = self.time
        if not 0 < step <= time[-1] - time[0]:
            raise InputError(
                f"resample = {step:g}: expected a step above 0 and below the length of the record, {span_words(time)}"
            )
        count = int((time[-1] - time[0]) / step * (1 + 1e-12)) + 1
        if count > _MOST_SAMPLES:
            raise InputError(
                f"resample = {step:g}: gives {count} samples; at most {_MOST_SAMPLES} are allowed"
            )
        grid = time[0] + step * np.arange(count)
        grid = grid[grid <= time[-1]] if grid[-1] > time[-1] + 1e-9 * step else grid
        self.signals = {name: resampled(time, values, grid) for name, values in self.signals.items()}
        self.time = grid
        how = "means over one step" if _is_coarser(step, time) else "linear interpolation"
        yield f"resampled to a step of {format_quantity(step, 's')} by {how}"


def span_words(time: Real) -> str:
    """Write the first and the last time."""
    return f"{format_quantity(float(time[0]), 's')} to {format_quantity(float(time[-1]), 's')}"


_SPAN: Final = re.compile(r"\s*(.*?)\s*(?:\.\.|:| to )\s*(.*?)\s*")


seconds = functools.partial(number_in, "s")


def time_span(option: str, value: str | tuple[float, float]) -> tuple[float, float]:
    """Return the ends of a time span such as ``"0 s..2 s"``; an end that is omitted is infinite."""
    match = _SPAN.fullmatch(value) if isinstance(value, str) else None
    ends = match.groups() if match else value
    if not isinstance(ends, (list, tuple)) or len(ends) != 2:
        raise InputError(f"{option} = {value}: expected a span of time, such as '0 s..2 s'")
    open_ends = (-np.inf, np.inf)
    first, last = (
        unbounded if end == "" else seconds(option, end)
        for end, unbounded in zip(ends, open_ends, strict=True)
    )
    if not first < last:
        raise InputError(f"{option} = {value}: the end is not after the beginning")
    return first, last


def shifted(time: Real, values: Real, shift: float) -> Real:
    """Return a signal whose samples were taken `shift` later than their time stamps state; NaN outside of the record."""
    return np.interp(time, time + shift, values, left=np.nan, right=np.nan)


def resampled(time: Real, values: Real, grid: Real) -> Real:
    """Return a signal on an even time grid within its times, by linear interpolation.

    Where the step of the grid exceeds the median interval of the samples, it is the mean of the interpolation
    over one step around each time, which attenuates components above half the new sampling rate. NaN where a
    sample that takes part is NaN.
    """
    step = float(grid[1] - grid[0])
    means = _is_coarser(step, time)
    lost = np.isnan(values)
    if lost.any():
        kept = ~lost
        if np.count_nonzero(kept) < 2:
            return np.full(grid.size, np.nan)
        found = resampled(time[kept], values[kept], grid)
        number = np.concatenate([[0], np.cumsum(lost)])
        reach = step / 2 if means else 0.0
        first = np.clip(np.searchsorted(time, grid - reach, side="right") - 1, 0, time.size - 1)
        last = np.clip(np.searchsorted(time, grid + reach, side="left"), 0, time.size - 1)
        return np.where(number[last + 1] > number[first], np.nan, found)
    if not means:
        return np.interp(grid, time, values)
    from scipy.interpolate import make_interp_spline

    whole = make_interp_spline(time, values, k=1).antiderivative()
    low, high = (np.clip(grid + side * step / 2, time[0], time[-1]) for side in (-1, 1))
    return np.asarray((whole(high) - whole(low)) / (high - low))


def _is_coarser(step: float, time: Real) -> bool:
    """Return whether the step of a grid exceeds the median interval of samples."""
    return bool(step > np.median(np.diff(time)) * (1 + 1e-9))


_LOW, _HIGH = 0.3, 0.7
"""Fractions of the range of a signal that it has to pass below and above between two edges."""
_FEWEST_SAMPLES: Final = 8
"""Fewest samples of a period."""


@dataclass(frozen=True, kw_only=True)
class SignalEdges:
    """Times [s] at which a signal passes the middle of its range, increasing, interpolated linearly; falling with the sign -1."""

    times: Real
    signs: Real

    @property
    def rising(self) -> Real:
        """Times of the rising edges [s]."""
        return self.times[self.signs > 0]

    @property
    def falling(self) -> Real:
        """Times of the falling edges [s]."""
        return self.times[self.signs < 0]


def find_edges(time: Real, values: Real) -> SignalEdges:
    """Find the edges at the mean of the 5 % and 95 % quantiles of a signal, with a hysteresis of 40 % of its range."""
    time, values = time[np.isfinite(values)], values[np.isfinite(values)]
    low, high = np.quantile(values, [0.05, 0.95]) if values.size else (0.0, 0.0)
    if high == low and values.size:
        low, high = values.min(), values.max()
    state = np.where(
        values > low + _HIGH * (high - low), 1, np.where(values < low + _LOW * (high - low), -1, 0)
    )
    known = np.flatnonzero(state)
    turns = np.flatnonzero(np.diff(state[known]))
    signs, level = state[known[turns + 1]], (low + high) / 2
    spans = zip(known[turns], known[turns + 1], signs, strict=True)
    after = np.array(
        [a + np.argmax(sign * (values[a : b + 1] - level) >= 0) for a, b, sign in spans], dtype=int
    )
    share = (level - values[after - 1]) / (values[after] - values[after - 1])
    return SignalEdges(times=time[after - 1] + share * (time[after] - time[after - 1]), signs=signs)


def average_periods(
    time: Real, signals: dict[str, Real], by: str
) -> tuple[Real, dict[str, Real], dict[str, Real], Real]:
    """Average signals over the periods between rising edges of one of them, stretched to the mean period.

    Returns the time from an edge on, the means and their standard errors, and the lengths of the periods [s].
    """
    edges = find_edges(time, signals[by]).rising
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
    count = min(round(period / float(np.median(np.diff(time)))), time.size)
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
    return period * phase, means, errors, lengths
