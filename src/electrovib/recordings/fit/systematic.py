"""The systematic error of estimates by the calibration of the measured signals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.calibration_error import CalibrationError
    from electrovib.recordings.fit.result import ScenarioFit

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
    size, at = prediction.data.size, 0
    sources: dict[_Source, tuple[Real, Real]] = {}
    for measured, columns in zip(prediction.measured, prediction.columns, strict=True):
        for column in columns:
            count = column.x.size
            end = at + count * column.parts
            if (error := measured.calibration_of(column.signal)) is not None:
                gain, zero = sources.setdefault((column.signal, error), (np.zeros(size), np.zeros(size)))
                gain[at:end] = prediction.data[at:end]
                zero[at : at + count] = 1.0
            at = end
    return sources
