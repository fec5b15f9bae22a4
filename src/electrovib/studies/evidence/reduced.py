"""Value and spread of what a publication prints in another form than a value: a range, runs, several devices, a line."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError


def of_range(given: Sequence[float]) -> Real:
    """Return the geometric mean of a printed range (1,)."""
    if len(given) != 2 or not 0 < given[0] < given[1]:
        raise InputError("expected the least and the largest value, above 0", path="printed_range")
    return np.array([np.sqrt(given[0] * given[1])])


def of_runs(given: Sequence[Sequence[float]], least: float) -> tuple[Real, Real]:
    """Return mean and relative deviation, at least `least`, at each point (n,) of runs (runs, n)."""
    if len(given) < 2 or len({len(each) for each in given}) != 1:
        raise InputError("expected two or more rows of one length", path="runs")
    means = np.mean(given, axis=0)
    return means, np.maximum(np.std(given, axis=0, ddof=1) / means, least)


def of_devices(given: Sequence[float]) -> tuple[Real, Real]:
    """Return geometric mean and relative deviation of a log-normal distribution of devices, each (1,)."""
    if len(given) < 2 or min(given) <= 0:
        raise InputError("expected two or more values, above 0", path="devices")
    logs = np.log(given)
    return np.exp(logs.mean(keepdims=True)), np.sqrt(np.expm1(np.var(logs, ddof=1, keepdims=True)))


def of_line(given: Sequence[float], at: Sequence[float]) -> tuple[Real, Real]:
    """Return values and relative standard errors (n,) of a line with start, its error, slope and its error."""
    if len(given) != 4:
        raise InputError("expected start, its error, slope and its error, in SI", path="line")
    start, start_error, slope, slope_error = given
    values = start + slope * np.asarray(at)
    return values, np.hypot(start_error, slope_error * np.asarray(at)) / values
