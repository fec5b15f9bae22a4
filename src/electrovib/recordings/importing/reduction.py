"""Reduction of imported signals: the steps that a user asks for, applied in one order."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.recordings.importing.steps import (
    average_periods,
    resampled,
    seconds,
    shifted,
    time_span,
    trigger_time,
    without_trend,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.recordings.importing.calibration import SensorCalibration

Span: TypeAlias = "str | tuple[float, float]"
_MOST_SAMPLES: Final = 50_000_000
"""Largest number of samples of a new time grid."""


@dataclass(frozen=True, kw_only=True)
class ReductionSteps:
    """Steps that are applied to the signals of a file, in this order.

    - `scale`, `offset`: sensitivity or `SensorCalibration` of a signal, and the reading that is subtracted.
    - `shift`: time that is added to the time stamps of a signal [s].
    - `trigger`: signal whose first rise through the middle of its range becomes time 0.
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
    words: list[str] = []
    time, signals = _aligned(time, signals, steps, words)
    time, signals = _level(time, signals, steps, words)
    if steps.average:
        time, signals = _averaged(time, signals, steps.average, words)
    if steps.resample is not None:
        time, signals, said = _on_grid(time, signals, seconds("resample", steps.resample))
        words.append(said)
    return time, signals, words


def _aligned(
    time: Real, signals: dict[str, Real], steps: ReductionSteps, words: list[str]
) -> tuple[Real, dict[str, Real]]:
    for name, value in steps.shift.items():
        shift = seconds(f"shift.{name}", value)
        signals[name] = shifted(time, signals[name], shift)
        words.append(f"{name}: {format_quantity(shift, 's')} added to its time stamps, interpolated linearly")
    if steps.shift:
        inside = np.all([np.isfinite(signals[name]) for name in steps.shift], axis=0)
        time, signals = _kept(time, signals, inside, "shift")
    if steps.trigger:
        zero = trigger_time(time, signals[steps.trigger])
        if zero is None:
            raise InputError(f"trigger = {steps.trigger}: it does not rise through the middle of its range")
        time = time - zero
        words.append(
            f"time: 0 where {steps.trigger} first rises through the middle of its range, {format_quantity(zero, 's')}"
        )
    return time, signals


def _level(
    time: Real, signals: dict[str, Real], steps: ReductionSteps, words: list[str]
) -> tuple[Real, dict[str, Real]]:
    for name, span in steps.baseline.items():
        first, last = time_span(f"baseline.{name}", span)
        part = signals[name][(time >= first) & (time <= last)]
        part = part[np.isfinite(part)]
        if not part.size:
            raise InputError(
                f"baseline.{name} = {span}: no sample lies in it; the record has {_span_words(time)}"
            )
        signals[name] = signals[name] - part.mean()
        words.append(f"{name}: mean {part.mean():.10g} of {part.size} samples in {span} subtracted")
    for name in steps.detrend:
        signals[name], slope = without_trend(time, signals[name])
        words.append(f"{name}: fitted straight line with slope {slope:.10g} per s subtracted")
    if steps.crop is not None:
        first, last = time_span("crop", steps.crop)
        time, signals = _kept(time, signals, (time >= first) & (time <= last), "crop")
        words.append(f"time: {steps.crop} kept")
    return time, signals


def _averaged(
    time: Real, signals: dict[str, Real], by: str, words: list[str]
) -> tuple[Real, dict[str, Real]]:
    whole = average_periods(time, signals, by)
    errors = (
        f"{name}: rms of the standard error {np.sqrt(np.mean(each**2)):.4g}"
        for name, each in whole.standard_errors.items()
    )
    words.append(
        f"averaged over {whole.periods} periods of {by}, {format_quantity(whole.period, 's')} on average with a"
        f" standard deviation of {format_quantity(whole.spread, 's', digits=3)}; time 0 at its rising edge; {', '.join(errors)}"
    )
    return whole.time, whole.means


def _span_words(time: Real) -> str:
    return f"{format_quantity(float(time[0]), 's')} to {format_quantity(float(time[-1]), 's')}"


def _kept(time: Real, signals: dict[str, Real], inside: Any, option: str) -> tuple[Real, dict[str, Real]]:
    if np.count_nonzero(inside) < 2:
        raise InputError(f"{option}: fewer than two samples remain of {_span_words(time)}")
    return time[inside], {name: values[inside] for name, values in signals.items()}


def _on_grid(time: Real, signals: dict[str, Real], step: float) -> tuple[Real, dict[str, Real], str]:
    if not 0 < step <= time[-1] - time[0]:
        raise InputError(
            f"resample = {step:g}: expected a step above 0 and below the length of the record, {_span_words(time)}"
        )
    count = int((time[-1] - time[0]) / step * (1 + 1e-12)) + 1
    if count > _MOST_SAMPLES:
        raise InputError(f"resample = {step:g}: gives {count} samples; at most {_MOST_SAMPLES} are allowed")
    grid = time[0] + step * np.arange(count)
    grid = grid[grid <= time[-1]] if grid[-1] > time[-1] + 1e-9 * step else grid
    how = "means over one step" if step > np.median(np.diff(time)) * (1 + 1e-9) else "linear interpolation"
    return (
        grid,
        {name: resampled(time, values, grid) for name, values in signals.items()},
        f"resampled to a step of {format_quantity(step, 's')} by {how}",
    )
