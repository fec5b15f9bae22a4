"""Output of a filter for even samples, and for straight pieces at any times."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.recursion import march_pairs

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.pieces import Linear
    from electrovib.solve.mechanics.filters.filter import Filter


def filtered(filter_: Filter, samples: ArrayLike, *, step: float, settled: bool, keep: int = 1) -> Real:
    """Return the exact output of a filter for an input that is linear from sample to sample.

    Parameters
    ----------
    filter_ : Filter
        Filter.
    samples : array_like, shape (n,)
        Input at even times, finite.
    step : float
        Time between samples [s].
    settled : bool
        Whether the input has always had the value of the first sample before it; otherwise it was 0.
    keep : int
        Number of samples for each output; outputs between are not computed.

    Returns
    -------
    output : ndarray, shape (ceil(n / keep),)
        Output at every `keep`-th sample, in the unit of the input times that of the gains.
    """
    values = finite(samples)
    start = filter_.state(values[0], held=math.inf if settled else 0.0)
    if values.size == 1:  # there is no time step
        return march_through(filter_, values, values, steps=0.0, state=start)[:1]
    return march_through(filter_, values[:-1], values[1:], steps=step, state=start, keep=keep)


def march_through(
    filter_: Filter, starts: Real, ends: Real, *, steps: float | Real, state: Complex, keep: int = 1
) -> Real:
    """Return the exact output of a filter for straight pieces with discontinuities between them.

    Parameters
    ----------
    filter_ : Filter
        Filter.
    starts, ends : ndarray, shape (pieces,)
        Input just after the beginning and just before the end of each piece.
    steps : float or ndarray, shape (pieces,)
        Their durations [s].
    state : ndarray of complex, shape (poles,)
        State of the filter at the first point.
    keep : int
        Number of points for each output.

    Returns
    -------
    output : ndarray, shape (pieces // keep + 1,)
        Output at every `keep`-th point, as from `recursion.march_pairs`.
    """
    gains = filter_.gains[np.newaxis]
    outputs, _ = march_pairs(filter_.poles, gains, [filter_.direct], starts, ends, steps, state, keep=keep)
    output: Real = outputs[0]
    return output


def filtered_linear(filter_: Filter, part: Linear, times: ArrayLike) -> Real:
    """Return the exact output of a filter for an input of straight pieces, from rest, at any times.

    Parameters
    ----------
    filter_ : Filter
        Filter.
    part : Linear
        Input: 0 before time 0, straight between its breaks, with or without discontinuities.
    times : array_like, shape (n,)
        Output times, >= 0, in any order [s].

    Returns
    -------
    output : ndarray, shape (n,)
        Output, at a discontinuity the value after it.

    Raises
    ------
    InputError
        If a time is negative or not finite.
    """
    wanted = np.asarray(times, dtype=float)
    if not np.all((wanted >= 0) & np.isfinite(wanted)):
        raise InputError("times: expected finite times >= 0, where the input begins.")
    return through_pieces(filter_, part, wanted, filter_.state(0.0))


def through_pieces(filter_: Filter, part: Linear, wanted: Real, state: Complex) -> Real:
    """Return the exact output of a filter for straight pieces at any times, from any state.

    Parameters
    ----------
    filter_ : Filter
        Filter.
    part : Linear
        Input.
    wanted : ndarray, shape (n,)
        Output times, >= 0 [s].
    state : ndarray of complex, shape (poles,)
        State of the filter at time 0.

    Returns
    -------
    output : ndarray, shape (n,)
        Output, at a discontinuity the value after it.
    """
    pieces = part.until(float(np.max(wanted, initial=0.0)))
    inside = pieces.times <= np.max(wanted, initial=0.0)
    knots = np.unique(np.concatenate([[0.0], wanted, pieces.times[inside]]))
    after = pieces.value(knots)
    before = after.copy()
    before[np.searchsorted(knots, pieces.times[inside])] = pieces.before[inside]
    knots, after, before = (
        np.append(knots, knots[-1]),
        np.append(after, after[-1]),
        np.append(before, after[-1]),
    )
    output = march_through(filter_, after[:-1], before[1:], steps=np.diff(knots), state=state)
    return output[np.searchsorted(knots[:-1], wanted)]


def finite(samples: ArrayLike) -> Real:
    """Return samples as an array, refusing an empty one and values that are not finite.

    Parameters
    ----------
    samples : array_like, shape (n,)
        Samples in any unit.

    Returns
    -------
    values : ndarray, shape (n,)
        The samples.

    Raises
    ------
    InputError
        With the first such index: one such sample would make all later outputs invalid.
    """
    values = np.asarray(samples, dtype=float)
    bad = np.flatnonzero(~np.isfinite(values))
    if values.ndim != 1 or not values.size or bad.size:
        where = f"sample {bad[0]} is {values.ravel()[bad[0]]}" if bad.size else f"shape {values.shape}"
        raise InputError(f"samples: {where}; expected one row of finite numbers, at least one.")
    return values
