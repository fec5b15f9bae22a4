"""The table of a fit, with the systematic error of each estimate, and its estimates as a space of parameters."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.paths import quantity_at
from electrovib.core.signals import SIGNALS
from electrovib.recordings.interval import MISFIT, NORMAL, EstimatedParameter

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from electrovib.core.arrays import Real
    from electrovib.recordings.calibration_error import CalibrationError
    from electrovib.recordings.fit.prediction import Unknown
    from electrovib.recordings.fit.result import ScenarioFit


def parameter_table(found: ScenarioFit, *, profiles: bool = True) -> tuple[EstimatedParameter, ...]:
    """Summarise a fit, one row for each unknown, then one for the mean of each parameter that varies between sessions."""
    systematic = systematic_deviations(found)
    rows = [
        dataclasses.replace(
            _row(found, each, profiles=profiles), systematic=systematic.get(each.name, math.nan)
        )
        for each in found.unknowns
    ]
    for path, spread in found.sessions.items():
        mean = spread.estimated(path, quantity_at(found.scenario, path), found.misfit.verdict)
        name = f"{path} (mean of {len(spread.values)} sessions)"
        rows.append(dataclasses.replace(mean, name=name, systematic=systematic.get(path, math.nan)))
    return tuple(rows)


def _row(found: ScenarioFit, unknown: Unknown, *, profiles: bool) -> EstimatedParameter:
    name, state, note = unknown.name, found.determined[unknown.name], found.why_no_interval(unknown.name)
    ends, method, deviation = found.interval(name), "" if note else "symmetric", found.deviation(name)
    if state != "well" and profiles:
        profiled = found.profile(name)
        ends, method = profiled.ends, "profile"
        if profiled.open_below and profiled.open_above:
            ends, method = (math.nan, math.nan), ""
        elif name in found.traded or any(
            name in each.exponents and len(each.exponents) > 1 for each in found.undetermined
        ):
            note = f"{note}; the interval is what the declared ranges of the other parameters allow"
        elif profiled.open_below or profiled.open_above:
            side = "below" if profiled.open_below else "above"
            note = "; ".join(filter(None, [note, f"the data set no limit {side}"]))
    if found.rounding is not None and method:
        note = "; ".join(filter(None, [note, found.rounding.note(name)]))
    return EstimatedParameter(
        name=name,
        unit=SIGNALS[unknown.path].unit
        if unknown.is_offset
        else quantity_at(found.scenario, unknown.path).unit,
        value=found.estimate.values[name],
        standard_error=deviation if math.isfinite(deviation) and state != "bound" else math.nan,
        lower=ends[0],
        upper=ends[1],
        method=method,
        state=found.states[name],
        note="; ".join(filter(None, [found.misfit.verdict, note])),
        low=found.problem.prediction.free[name].lower,
    )


_VANISHES: Final = 1e-6
"""Relative singular value below which a combination of parameters is not determined by the data at all."""


def systematic_deviations(found: ScenarioFit) -> dict[str, float]:
    """Compute the standard deviation of each estimate by the calibration errors of the signals; empty where none is stated.

    By the derivative of the estimate after gain and zero of each signal, dp = (J'J)^-1 J' W dy with dy = gain
    y + zero, J the weighted derivatives and W the weights. Recordings of a signal with the same stated error
    were made with the same sensor: their error is common to all. The zero of a signal whose offset is fitted
    has no effect. The error does not average out over samples, recordings or sessions. NaN of an unknown that
    is not determined or lies on a bound.
    """
    sources = _sources(found)
    if not sources:
        return {}
    values, problem = found.estimate.values, found.problem
    inside = [name for name in values if name not in found.estimate.on_bound]
    rows = [list(values).index(name) for name in inside]
    scale = np.array([abs(values[name]) or 1.0 for name in inside])
    sloped = problem.derivatives(values)[:, rows] * scale
    inverse = np.linalg.pinv(sloped, rcond=_VANISHES) * problem.weights
    deviations: dict[str, float] = {}
    shifts = [
        (error, *((inverse @ change) * scale for change in changes)) for error, changes in sources.items()
    ]
    for at, name in enumerate(inside):
        parts = [(error, float(gain[at]), float(zero[at])) for error, gain, zero in shifts]
        deviations[name] = _combined(parts) if found.determined[name] != "not" else math.nan
    for path in found.sessions:
        own = [
            inside.index(each.name) for each in found.unknowns if each.path == path and each.name in inside
        ]
        means = [(error, float(gain[own].mean()), float(zero[own].mean())) for error, gain, zero in shifts]
        deviations[path] = _combined(means)
    return dict.fromkeys(values, math.nan) | deviations


def _combined(parts: list[tuple[_Source, float, float]]) -> float:
    """Root of the variance of independent sources, each with the changes by a gain error and by a zero error of 1."""
    variance = sum(
        error.gain**2 * gain**2 + error.zero**2 * zero**2 + 2 * error.covariance * gain * zero
        for (_, error), gain, zero in parts
    )
    return math.sqrt(max(variance, 0.0))


_Source = tuple[str, "CalibrationError"]


def _sources(found: ScenarioFit) -> dict[_Source, tuple[Real, Real]]:
    """Changes of all data by a gain error and by a zero error of 1, for each sensor."""
    prediction = found.problem.prediction
    size = prediction.data.size
    sources: dict[_Source, tuple[Real, Real]] = {}
    for record, _, column, rows in prediction.pieces():
        error = prediction.measured[record].calibration_of(column.signal)
        if error is not None:
            gain, zero = sources.setdefault((column.signal, error), (np.zeros(size), np.zeros(size)))
            gain[rows] = prediction.data[rows]
            zero[rows.start : rows.start + column.x.size] = 1.0
    return sources


def space_tables(
    rows: Iterable[EstimatedParameter],
    paths: Mapping[str, str],
    *,
    between: Mapping[str, float] | None = None,
) -> dict[str, dict[str, object]]:
    """Write estimates as tables of distributions, as `electrovib.scenario.space.read_space` reads them.

    `paths` maps the name of a row to the path of its parameter, other rows are omitted; `between` is the
    standard deviation of a parameter between sessions, added to that of its mean. A symmetric interval gives
    a normal distribution; one from a profile with two ends above 0 a log-normal one, with the median at the
    estimate and the same 95 % interval. Parameters that the data do not determine, or of a model that does
    not describe them, are omitted.
    """
    found: dict[str, dict[str, object]] = {}
    for row in rows:
        if row.name not in paths or not row.method or row.state in {"not", MISFIT}:
            continue
        if row.method == "profile":
            if 0 < row.lower < row.value < row.upper < math.inf:
                factor = math.exp((math.log(row.upper) - math.log(row.lower)) / (2 * NORMAL))
                found[paths[row.name]] = {"model": "LogNormal", "median": row.value, "factor": factor}
            continue
        deviation = math.hypot(row.standard_error, (between or {}).get(paths[row.name], 0.0))
        table: dict[str, object] = {"model": "Normal", "mean": row.value, "deviation": deviation}
        if row.value > 0:
            table["low"] = 0.0
        found[paths[row.name]] = table
    return found


def omitted_from_space(
    rows: Iterable[EstimatedParameter], paths: Mapping[str, str], tables: Collection[str]
) -> dict[str, str]:
    """State why parameters of a fit have no distribution in its space."""
    return {
        paths[row.name]: row.note or f"its interval ({row.method or 'none'}) has no two ends above 0"
        for row in rows
        if row.name in paths and paths[row.name] not in tables
    }


def space_correlations(found: ScenarioFit, tables: Collection[str]) -> dict[tuple[str, str], float]:
    """Return the correlation coefficients of the estimates in a space, pair by pair in the order of the unknowns.

    To first order they hold for the logarithms too. A parameter that varies between sessions, is not
    determined or lies on a bound has none.
    """
    names = list(found.estimate.values)
    matrix = found.correlation
    shared = [
        (names.index(each.name), each.path)
        for each in found.unknowns
        if not each.is_offset and not each.session and each.path in tables
    ]
    pairs = {
        (first, second): min(max(matrix[at][other], -1.0), 1.0)
        for number, (at, first) in enumerate(shared)
        for other, second in shared[number + 1 :]
    }
    return {pair: value for pair, value in pairs.items() if math.isfinite(value)}
