"""One compiled pass over pieces of unequal duration, called by `one_pass` for each interval."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable


SHORT: Final = 0.3
"""Share of the longest piece below which the decays of fast modes are not read from the table."""


def _inner(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that compiled functions call."""
    from numba import njit

    # without wrappers for Python; contract: a product and a sum are rounded once, the order of operations is kept
    options: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "fastmath": {"contract"}}
    return njit(function, error_model="numpy", **options)  # type: ignore[no-any-return]


def _outer(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls, and cache it on disk where numba finds a folder to write to."""
    from numba import njit

    options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, "fastmath": {"contract"}}
    try:
        return njit(function, nogil=True, cache=True, **options)  # type: ignore[no-any-return]
    except RuntimeError:
        return njit(function, nogil=True, **options)  # type: ignore[no-any-return]


# Whole arrays are passed with the index of the first mode and of the one after the last: a view costs more than a piece.


@_inner
def _follow_slowest(
    first: Any, last: Any, rates: Any, t: Any, s: Any, step: Any, start: Any, rise: Any, state: Any
) -> Any:
    """Advance modes by one piece with polynomials of degree 4 in s."""
    for mode in range(first, last):
        fall, at = rates[mode] * step, mode - first
        later = t[0, at] + s * (t[1, at] + s * (t[2, at] + s * (t[3, at] + s * t[4, at])))
        state[mode] += fall * ((1 - fall * later) * (start - state[mode]) + later * rise)


@_inner
def _follow_slow(
    first: Any, last: Any, rates: Any, t: Any, s: Any, step: Any, start: Any, rise: Any, state: Any
) -> Any:
    """Advance modes by one piece with polynomials of degree 10 in s."""
    for mode in range(first, last):
        fall, at = rates[mode] * step, mode - first
        later = t[6, at] + s * (t[7, at] + s * (t[8, at] + s * (t[9, at] + s * t[10, at])))
        later = t[2, at] + s * (t[3, at] + s * (t[4, at] + s * (t[5, at] + s * later)))
        later = t[0, at] + s * (t[1, at] + s * later)
        state[mode] += fall * ((1 - fall * later) * (start - state[mode]) + later * rise)


@_inner
def _follow_far(last: Any, rates: Any, step: Any, start: Any, rise: Any, state: Any) -> Any:
    """Advance modes by one piece that is longer than the range of the polynomials."""
    for mode in range(last):
        fall = rates[mode] * step
        if fall < 1:
            later = 0.0
            for order in range(19, 1, -1):
                later = (1 - fall * later) / order
        else:
            later = (1 + math.expm1(-fall) / fall) / fall
        state[mode] += fall * ((1 - fall * later) * (start - state[mode]) + later * rise)


@_inner
def _follow_lags_near(
    first: Any,
    last: Any,
    rates: Any,
    decays: Any,
    place: Any,
    off: Any,
    step: Any,
    rise: Any,
    drop: Any,
    lags: Any,
) -> Any:
    """Advance lags as `_follow_lags` does, from tabulated decays at a duration near that of the piece."""
    for mode in range(first, last):
        fall, by = rates[mode] * step, rates[mode] * off
        change = by / 4 * (1 - by / 5)  # the truncation error is below rounding of the lag
        decay = decays[place, mode - first] * (1 - by * (1 - by / 2 * (1 - by / 3 * (1 - change))))
        lags[mode] = decay * lags[mode] - (1 - decay) / fall * rise - drop


@_inner
def _follow_lags(first: Any, last: Any, rates: Any, step: Any, rise: Any, drop: Any, lags: Any) -> Any:
    """Advance the lags of fast modes behind the drive by one piece and the discontinuity after it."""
    for mode in range(first, last):
        fall = rates[mode] * step
        if fall > 0.5:
            decay = math.exp(-fall)
            lags[mode] = decay * lags[mode] - (1 - decay) / fall * rise - drop
        else:
            risen = -math.expm1(-fall)
            mean = risen / fall if fall > 0 else 1.0
            lags[mode] = (1 - risen) * lags[mode] - mean * rise - drop


@_outer
def follow(
    rates: Any,
    counts: Any,
    few: Any,
    more: Any,
    decays: Any,
    longest: Any,
    starts: Any,
    ends: Any,
    steps: Any,
    following: Any,
    state: Any,
    table: Any,
) -> Any:
    """Advance modes through some pieces.

    Of `rates` the first `counts[0]` use the polynomials `few` of degree 4 and the next `counts[1]` the polynomials
    `more` of degree 10, which give (1 - mean)/fall, where mean = (1 - exp(-fall))/fall; the states of these modes are
    advanced. Of the other modes the lag behind the drive is advanced: for the next `counts[2]` of them by `decays` at
    evenly spaced durations up to the longest, for the last by their exponentials. `state` is overwritten by that after
    the last piece; where `table` has rows, they are overwritten by the states before each piece.
    """
    # unsigned: indices that could be negative prevent vectorised loops
    slowest, slow, count = np.uint64(counts[0]), np.uint64(counts[0] + counts[1]), np.uint64(len(rates))
    near, width, zero = slow + np.uint64(counts[2]), longest / len(decays), np.uint64(0)
    for piece in range(len(steps)):
        if len(table) > 0:
            for mode in range(zero, count):
                table[piece, mode] = state[mode]
        step, start = steps[piece], starts[piece]
        rise, s = ends[piece] - start, 2 * step / longest - 1
        if s <= 1:
            _follow_slowest(zero, slowest, rates, few, s, step, start, rise, state)
            _follow_slow(slowest, slow, rates, more, s, step, start, rise, state)
        else:
            _follow_far(slow, rates, step, start, rise, state)
        drop, done = (starts[piece + 1] if piece + 1 < len(steps) else following) - ends[piece], slow
        if SHORT * longest < step < longest:
            place = np.uint64(step / width)
            off, done = step - (np.float64(place) + 0.5) * width, near
            _follow_lags_near(slow, near, rates, decays, place, off, step, rise, drop, state)
        _follow_lags(done, count, rates, step, rise, drop, state)
