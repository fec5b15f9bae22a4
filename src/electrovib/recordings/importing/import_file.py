"""Import of a file of an instrument as a Trace."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, gathered
from electrovib.core.files import note_input
from electrovib.core.trace import make_trace
from electrovib.core.units import format_quantity
from electrovib.data.columns.faults import check_file
from electrovib.data.readers.registry import format_of, read_recorded
from electrovib.recordings.importing.choice import calibrated_column, check_names, column_of
from electrovib.recordings.importing.clock import SampleTimes, sample_times
from electrovib.recordings.importing.notices import about_samples
from electrovib.recordings.importing.spectrum_trace import spectrum_trace
from electrovib.recordings.importing.steps import (
    resampled,
    seconds,
    shifted,
    time_span,
    trigger_time,
    without_trend,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.core.arrays import Real
    from electrovib.data.readers.recorded import Recorded

Span: TypeAlias = "str | tuple[float, float]"
_LONGEST_SETTINGS: Final = 4000
_MOST_SAMPLES: Final = 50_000_000
"""Largest number of samples of a new time grid."""


@dataclass(frozen=True, kw_only=True)
class ReductionSteps:
    """Steps that are applied to the signals of a file, in this order.

    Parameters
    ----------
    scale, offset : mapping of str to str or float
        Signal to its sensitivity, and to the reading that is subtracted.
    shift : mapping of str to str or float
        Signal to the time that is added to its time stamps [s].
    trigger : str
        Signal whose first rise through the middle of its range becomes time 0.
    baseline : mapping of str to span
        Signal to the span of time whose mean is subtracted.
    detrend : sequence of str
        Signals whose fitted straight line is subtracted.
    crop : span, optional
        Span of time that is kept.
    resample : str or float, optional
        Step of an even time grid [s].
    """

    scale: Mapping[str, str | float] = field(default_factory=dict)
    offset: Mapping[str, str | float] = field(default_factory=dict)
    shift: Mapping[str, str | float] = field(default_factory=dict)
    trigger: str = ""
    baseline: Mapping[str, Span] = field(default_factory=dict)
    detrend: tuple[str, ...] = ()
    crop: Span | None = None
    resample: str | float | None = None


def import_file(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    *,
    time: str = "",
    step: str | float | None = None,
    stamps: str = "refuse",
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    title: str = "",
    **reduction: Any,
) -> xarray.Dataset:
    """Import a file of an instrument: its columns become signals of a Trace, in SI, with their history.

    Parameters
    ----------
    path : str or Path
        Any file that a reader takes.
    columns : mapping of str to str, optional
        Signal of the nomenclature to the heading of its column, with a unit where the file states none:
        ``{"lateral_force_measured": "Ch2 (N)"}``. Of an impedance spectrum: ``frequency``, ``modulus``, ``phase``, ``real``,
        ``imaginary`` to the headings, or nothing.
    time : str
        Column of the time stamps, with a unit where the file states none; found if empty.
    step : str or float, optional
        Time between samples [s], if there are no time stamps.
    stamps : str
        Treatment of time stamps that do not increase: ``"refuse"`` or ``"keep_increasing"``.
    reader : str
        Name of the reader; found from the first bytes if empty.
    delimiter : str, optional
        Of text: one character, or empty for blanks; found if not given.
    decimal_comma : bool, optional
        Of text: whether decimals are written with a comma; found if not given.
    title : str
        Title of the Trace; the name of the file if empty.
    **reduction
        ``scale``, ``offset``, ``shift``, ``trigger``, ``baseline``, ``detrend``, ``crop`` and ``resample``, as described for
        `electrovib.recordings.importing.import_file.ReductionSteps`, applied in this order.

    Returns
    -------
    xarray.Dataset
        Trace with the signals over ``time`` [s], or with ``impedance`` [ohm] over ``frequency`` [Hz]. Attributes ``file``,
        ``file_sha256``, ``reader``, ``options`` and ``history`` state its origin, ``validity`` the diagnostics.

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is unknown, or an option does not fit; all mistakes of a kind at once.
    """
    place = Path(path)
    check_file(place)
    note_input(place)
    options = {"delimiter": delimiter, "decimal_comma": decimal_comma}
    recorded = read_recorded(place, reader=reader, **options)
    stated = {name: value for name, value in options.items() if value is not None}
    origin = {
        "title": title or place.stem,
        "electrovib": version("electrovib"),
        "file": place.name,
        "file_sha256": hashlib.sha256(place.read_bytes()).hexdigest(),
        "reader": reader or format_of(place).name,
        "options": json.dumps(
            stated | {"columns": dict(columns or {}), "time": time, "step": step} | reduction
        ),
        "file_preamble": json.dumps(dict(recorded.attributes))[:_LONGEST_SETTINGS],
    }
    steps = _reduction(reduction)
    wanted = dict(columns or {})
    if is_spectrum(wanted):
        return spectrum_trace(recorded, wanted, origin)
    problems = check_names("columns", wanted)
    problems += [
        problem
        for option in ("scale", "offset", "shift", "baseline")
        for problem in check_names(option, getattr(steps, option), wanted)
    ]
    problems += check_names("detrend", dict.fromkeys(steps.detrend), wanted)
    problems += check_names("trigger", {steps.trigger: ""} if steps.trigger else {}, wanted)
    if problems:
        raise InputError(problems)
    clock = sample_times(recorded, time=time, step=step, stamps=stamps)
    return _over_time(recorded, wanted, clock, steps, origin)


def is_spectrum(columns: Mapping[str, str]) -> bool:
    """Return whether the chosen columns are those of a spectrum, or none are chosen."""
    return not columns or "frequency" in columns or "angular_frequency" in columns


def _reduction(given: Mapping[str, Any]) -> ReductionSteps:
    """Read the steps, and refuse unknown ones."""
    from electrovib.core.errors import nearest

    known = ReductionSteps.__dataclass_fields__
    problems = [
        f"{name}: is not an option of import_file.{nearest(name, known)}"
        for name in given
        if name not in known
    ]
    if problems:
        raise InputError(problems)
    fitting = {name: value for name, value in given.items() if value is not None}
    if "detrend" in fitting:
        fitting["detrend"] = (
            (fitting["detrend"],) if isinstance(fitting["detrend"], str) else tuple(fitting["detrend"])
        )
    return ReductionSteps(**fitting)


def _over_time(
    recorded: Recorded,
    columns: Mapping[str, str],
    clock: SampleTimes,
    steps: ReductionSteps,
    origin: dict[str, str],
) -> xarray.Dataset:
    """Reduce the chosen columns and make a Trace of them."""
    history = [f"{origin['file']} read by reader '{origin['reader']}'", *clock.steps]
    signals: dict[str, Real] = {}
    readings: dict[str, Real] = {}
    problems: list[str] = []
    for signal, stated in columns.items():
        with gathered(problems):
            column = column_of(recorded, stated, option=f"columns.{signal}")
            values, words = calibrated_column(
                column, signal, scale=steps.scale.get(signal), offset=steps.offset.get(signal)
            )
            signals[signal], readings[signal] = values[clock.rows], column.values[clock.rows]
            history += words
    if problems:
        raise InputError(problems)
    diagnostics = [*clock.diagnostics, *about_samples(clock.time, readings)]
    found, signals, words = _reduced(clock.time, signals, steps)
    return make_trace(
        {name: (("time",), values) for name, values in signals.items()},
        {"time": found},
        origin | {"history": "\n".join(history + words), "validity": _validity(diagnostics)},
    )


def _validity(diagnostics: list[Diagnostic]) -> str:
    return json.dumps([each.to_dict() for each in diagnostics])


def _reduced(
    time: Real, signals: dict[str, Real], steps: ReductionSteps
) -> tuple[Real, dict[str, Real], list[str]]:
    """Apply the steps in their order; return times, signals and one sentence for each step."""
    words: list[str] = []
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
    if steps.resample is not None:
        time, signals, said = _on_grid(time, signals, seconds("resample", steps.resample))
        words.append(said)
    return time, signals, words


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
