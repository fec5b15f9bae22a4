"""Inputs through a filter: even samples, straight pieces at any times."""

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
    """Output of a filter for an input that runs straight from sample to sample, exactly.

    Parameters
    ----------
    filter_ : Filter
        What the input goes through.
    samples : array_like, shape (n,)
        Input at even times, finite.
    step : float
        Time between samples [s].
    settled : bool
        The first sample has been held for ever before; otherwise there was nothing before it.
    keep : int
        Every so many samples one is put out; what lies between is not computed.

    Returns
    -------
    ndarray, shape (ceil(n / keep),)
        Output at the samples kept, in the unit of the input times that of the gains.
    """
    values = finite(samples)
    start = filter_.state(values[0], held=math.inf if settled else 0.0)
    if values.size == 1:  # no time passes
        return march_through(filter_, values, values, steps=0.0, state=start)[:1]
    return march_through(filter_, values[:-1], values[1:], steps=step, state=start, keep=keep)


def march_through(
    filter_: Filter, starts: Real, ends: Real, *, steps: float | Real, state: Complex, keep: int = 1
) -> Real:
    """Output of a filter for straight pieces that may jump, exactly.

    Parameters
    ----------
    filter_ : Filter
        What the input goes through.
    starts, ends : ndarray, shape (pieces,)
        Input just after the beginning and just before the end of each piece.
    steps : float or ndarray, shape (pieces,)
        Their durations [s].
    state : ndarray of complex, shape (poles,)
        Of the filter at the first point.
    keep : int
        Every so many points one is put out.

    Returns
    -------
    ndarray, shape (pieces // keep + 1,)
        As from `recursion.march_pairs`.
    """
    gains = filter_.gains[np.newaxis]
    outputs, _ = march_pairs(filter_.poles, gains, [filter_.direct], starts, ends, steps, state, keep=keep)
    output: Real = outputs[0]
    return output


def filtered_linear(filter_: Filter, part: Linear, times: ArrayLike) -> Real:
    """Output of a filter for an input of straight pieces, from rest, exactly at any times.

    Parameters
    ----------
    filter_ : Filter
        What the input goes through.
    part : Linear
        The input: off before time 0, straight between its breaks, with or without jumps.
    times : array_like, shape (n,)
        When the output is wanted [s], 0 or later, in any order.

    Returns
    -------
    ndarray, shape (n,)
        At a jump the value after it.

    Raises
    ------
    InputError
        If a time is negative or not finite.
    """
    wanted = np.asarray(times, dtype=float)
    if not np.all((wanted >= 0) & np.isfinite(wanted)):
        raise InputError("times: expected finite times from 0 on, where the input begins.")
    return through_pieces(filter_, part, wanted, filter_.state(0.0))


def through_pieces(filter_: Filter, part: Linear, wanted: Real, state: Complex) -> Real:
    """Output of a filter for straight pieces at any times, from any state.

    Parameters
    ----------
    filter_ : Filter
        What the input goes through.
    part : Linear
        The input.
    wanted : ndarray, shape (n,)
        Times from 0 on [s].
    state : ndarray of complex, shape (poles,)
        Of the filter at time 0.

    Returns
    -------
    ndarray, shape (n,)
        At a jump the value after it.
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
    """Return samples as numbers, refusing none and what is not finite.

    Parameters
    ----------
    samples : array_like, shape (n,)
        In any unit.

    Returns
    -------
    ndarray, shape (n,)
        The same.

    Raises
    ------
    InputError
        With the first index: one bad sample would spoil all after it.
    """
    values = np.asarray(samples, dtype=float)
    bad = np.flatnonzero(~np.isfinite(values))
    if values.ndim != 1 or not values.size or bad.size:
        where = f"sample {bad[0]} is {values.ravel()[bad[0]]}" if bad.size else f"shape {values.shape}"
        raise InputError(f"samples: {where}; expected one row of finite numbers, at least one.")
    return values
