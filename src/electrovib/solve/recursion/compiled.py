"""One compiled pass over unequal pieces: what `one_pass` calls for each stretch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable


_OPTIONS: Final[dict[str, Any]] = {
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "fastmath": {"contract"},  # a product and a sum are rounded once; nothing is put in another order
}


def _inner(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that compiled ones call."""
    from numba import njit

    return njit(function, no_cpython_wrapper=True, **_OPTIONS)  # type: ignore[no-any-return]


def _outer(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls, and keep it on disk where numba finds a folder to write to."""
    from numba import njit

    try:
        return njit(function, cache=True, **_OPTIONS)  # type: ignore[no-any-return]
    except RuntimeError:
        return njit(function, **_OPTIONS)  # type: ignore[no-any-return]


@_inner
def _follow_slowest(rates: Any, terms: Any, s: Any, step: Any, start: Any, rise: Any, state: Any) -> Any:
    """Take modes through one piece with polynomials of degree 4 in s."""
    t0, t1, t2, t3, t4 = terms[0], terms[1], terms[2], terms[3], terms[4]
    for mode in range(len(state)):
        fall = rates[mode] * step
        later = t0[mode] + s * (t1[mode] + s * (t2[mode] + s * (t3[mode] + s * t4[mode])))
        state[mode] += fall * ((1 - fall * later) * (start - state[mode]) + later * rise)


@_inner
def _follow_slow(rates: Any, terms: Any, s: Any, step: Any, start: Any, rise: Any, state: Any) -> Any:
    """Take modes through one piece with polynomials of degree 10 in s."""
    t0, t1, t2, t3, t4, t5 = terms[0], terms[1], terms[2], terms[3], terms[4], terms[5]
    t6, t7, t8, t9, t10 = terms[6], terms[7], terms[8], terms[9], terms[10]
    for mode in range(len(state)):
        fall = rates[mode] * step
        later = t6[mode] + s * (t7[mode] + s * (t8[mode] + s * (t9[mode] + s * t10[mode])))
        later = t2[mode] + s * (t3[mode] + s * (t4[mode] + s * (t5[mode] + s * later)))
        later = t0[mode] + s * (t1[mode] + s * later)
        state[mode] += fall * ((1 - fall * later) * (start - state[mode]) + later * rise)


@_inner
def _follow_far(rates: Any, step: Any, start: Any, rise: Any, state: Any) -> Any:
    """Take modes through one piece that lasts longer than the polynomials hold."""
    for mode in range(len(state)):
        fall = rates[mode] * step
        if fall < 1:
            later = 0.0
            for order in range(19, 1, -1):
                later = (1 - fall * later) / order
        else:
            later = (1 + math.expm1(-fall) / fall) / fall
        state[mode] += fall * ((1 - fall * later) * (start - state[mode]) + later * rise)


@_inner
def _follow_lags(rates: Any, step: Any, rise: Any, drop: Any, lags: Any) -> Any:
    """Take what quick modes lag behind the drive through one piece and the jump after it."""
    for mode in range(len(lags)):
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
    longest: Any,
    starts: Any,
    ends: Any,
    steps: Any,
    following: Any,
    state: Any,
    table: Any,
) -> Any:
    """Follow modes through some pieces.

    Of `rates` the first `counts[0]` have the polynomials `few` of degree 4 and the next `counts[1]` those `more` of
    degree 10, which give (1 - mean)/fall, where mean = (1 - exp(-fall))/fall; they are followed by themselves. The
    others are followed as what they lag behind the drive, by their exponentials. `state` becomes that after the last
    piece; where `table` has rows, they become the states before each piece.
    """
    slowest, slow = counts[0], counts[0] + counts[1]
    for piece in range(len(steps)):
        if len(table) > 0:
            table[piece, :] = state
        step, start = steps[piece], starts[piece]
        rise, s = ends[piece] - start, 2 * step / longest - 1
        if s <= 1:
            _follow_slowest(rates[:slowest], few, s, step, start, rise, state[:slowest])
            _follow_slow(rates[slowest:slow], more, s, step, start, rise, state[slowest:slow])
        else:
            _follow_far(rates[:slow], step, start, rise, state[:slow])
        drop = (starts[piece + 1] if piece + 1 < len(steps) else following) - ends[piece]
        _follow_lags(rates[slow:], step, rise, drop, state[slow:])
