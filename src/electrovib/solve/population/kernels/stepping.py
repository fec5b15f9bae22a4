"""Responses of many fingers to one piecewise linear drive, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.solve.population.kernels.kernel import kernel

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Real

_ROUNDING: Final = 4 * float(np.finfo(float).eps)


class TimeSteps(NamedTuple):
    """Steps of a time grid, equal ones counted once.

    Parameters
    ----------
    kind : ndarray of int, shape (n - 1,)
        Index of the duration of each step.
    duration : ndarray, shape (kinds,)
        Distinct durations, increasing [s].
    """

    kind: Indices
    duration: Real


def time_steps(time: ArrayLike) -> TimeSteps:
    """Return the distinct steps of a time grid; differences that are equal up to the rounding of the times count as one.

    `time` (n,) [s].

    The duration of a group of steps is their mean, so that rounding does not accumulate over the grid.
    """
    times = np.ascontiguousarray(time, np.float64)
    steps = np.diff(times)
    if not steps.size:
        return TimeSteps(np.zeros(0, np.intp), np.zeros(0))
    distinct, kind, counts = np.unique(steps, return_inverse=True, return_counts=True)
    slack = _ROUNDING * float(np.max(np.abs(times)))
    group, first = np.zeros(distinct.size, np.intp), distinct[0]
    for place in np.flatnonzero(np.diff(distinct, prepend=distinct[0]) > 0).tolist():
        new = distinct[place] - first > slack or (first == 0.0)
        group[place] = group[place - 1] + new
        first = distinct[place] if new else first
    total = np.bincount(group, distinct * counts) / np.bincount(group, counts)
    return TimeSteps(group[kind.reshape(-1)].astype(np.intp), total)


def first_order_hold_many(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    state: ArrayLike,
    voltage: ArrayLike,
    time: ArrayLike | TimeSteps,
    *,
    rises: ArrayLike | None = None,
    places: Indices | None = None,
) -> Real:
    """Compute the responses of many fingers to one piecewise linear drive, exact at every time.

    `rates`, `residues`, `state` (fingers, modes), `direct` (fingers,), `voltage` (n,) [V], `time` (n,) [s]; returns
    `response` (fingers, n).

    The response is direct v + sum residue s with s' = v - rate s from residue s = `state`. With `rises` (n,) [V], those of
    the drive from each time to the next, the second term is sum residue l with l = rate s - v, which loses no digits where
    modes follow a slow drive. Of all times those at the increasing indices `places` (outputs,) are returned.
    """
    rate, residue, level, begin, drive = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, state, voltage)
    )
    given = drive if rises is None else np.ascontiguousarray(rises, np.float64)
    steps = time if isinstance(time, TimeSteps) else time_steps(time)
    outputs = np.arange(len(drive)) if places is None else places
    kinds, durations = np.append(steps.kind, steps.duration.size), np.append(steps.duration, 0.0)
    grid = drive, given, rises is not None, kinds, durations
    result = np.empty((len(rate), len(outputs)))
    kernel().responses((rate, residue, level, begin), grid, outputs, result)
    return result
