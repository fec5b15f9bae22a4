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


def filtered(filter_: Filter, samples: ArrayLike, *, step: float, settled: bool) -> Real:
    """Return the exact output of a filter for an input that is linear from sample to sample.

    `samples` (n,); returns `output` (n,).
    """
    values = finite(samples)
    start = filter_.state(values[0], held=math.inf if settled else 0.0)
    if values.size == 1:  # there is no time step
        return march_through(filter_, values, values, steps=0.0, state=start)[:1]
    return march_through(filter_, values[:-1], values[1:], steps=step, state=start)


def march_through(filter_: Filter, starts: Real, ends: Real, *, steps: float | Real, state: Complex) -> Real:
    """Return the exact output of a filter for straight pieces with discontinuities between them.

    `starts`, `ends` (pieces,), `steps` (pieces,) [s], `state` (poles,); returns `output` (pieces // keep +
    1,).
    """
    gains = filter_.gains[np.newaxis]
    outputs, _ = march_pairs(filter_.poles, gains, [filter_.direct], starts, ends, steps, state)
    output: Real = outputs[0]
    return output


def filtered_linear(filter_: Filter, part: Linear, times: ArrayLike) -> Real:
    """Return the exact output of a filter for an input of straight pieces, from rest, at any times.

    `times` (n,) [s]; returns `output` (n,).
    """
    wanted = np.asarray(times, dtype=float)
    if not np.all((wanted >= 0) & np.isfinite(wanted)):
        raise InputError("times: expected finite times >= 0, where the input begins.")
    return through_pieces(filter_, part, wanted, filter_.state(0.0))


def through_pieces(filter_: Filter, part: Linear, wanted: Real, state: Complex) -> Real:
    """Return the exact output of a filter for straight pieces at any times, from any state.

    `wanted` (n,) [s], `state` (poles,); returns `output` (n,).
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

    `samples` (n,); returns `values` (n,).
    """
    values = np.asarray(samples, dtype=float)
    bad = np.flatnonzero(~np.isfinite(values))
    if values.ndim != 1 or not values.size or bad.size:
        where = f"sample {bad[0]} is {values.ravel()[bad[0]]}" if bad.size else f"shape {values.shape}"
        raise InputError(f"samples: {where}; expected one row of finite numbers, at least one.")
    return values
