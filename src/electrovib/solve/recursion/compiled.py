"""The recursion at uneven time stamps as one compiled loop, called by `uneven` for long records."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from electrovib.solve.recursion.blocks import SLOW
from electrovib.solve.recursion.compiling import outer

_FINE: Final = 16.0
_FORGOTTEN: Final = 45.0
"""Rate times time after which a mode has decayed below rounding."""
_FALLEN: Final = np.expm1(-np.arange(_FORGOTTEN * _FINE + 1) / _FINE)
"""Decays less one at multiples of 1/16."""
_FALLEN[-1] = -1.0
_SMALLEST: Final = 1e-300
_2, _3, _4, _5, _6, _7, _8 = (1.0 / math.factorial(order) for order in range(2, 9))


@outer
def follow(rates: Any, slow: Any, usual: Any, drive: Any, begin: Any, table: Any) -> Any:
    """Write states of slow modes and lags of the others after each piece from one on into the next row of a table.

    The change of a state is ``risen (start - x) + last rise`` with ``risen = 1 - exp(-fall)``; up to 1/32 both weights are
    short series in the fall, so that no digit of a small one is lost. The change of a lag is ``-risen lag - risen/fall rise``,
    less the discontinuity after the piece; its exponentials are those at the nearest multiple of 1/16 times a short series.
    """
    starts, ends, steps = drive
    # unsigned: indices that could be negative prevent vectorised loops
    zero, first, count = np.uint64(0), np.uint64(slow), np.uint64(len(rates))
    for row in range(len(table) - 1):
        piece = begin + row
        step, start, rise = steps[piece], starts[piece], ends[piece] - starts[piece]
        drop = starts[piece + 1] - ends[piece] if piece + 1 < len(steps) else 0.0
        if step <= usual:
            for mode in range(zero, first):
                fall, state = rates[mode] * step, table[row, mode]
                last = _2 - fall * (_3 - fall * (_4 - fall * (_5 - fall * (_6 - fall * (_7 - fall * _8)))))
                last *= fall
                table[row + 1, mode] = state + (fall * (1 - last) * (start - state) + last * rise)
        else:
            for mode in range(zero, first):
                fall, state = rates[mode] * step, table[row, mode]
                risen = -math.expm1(-fall)
                last = 1 - risen / fall
                if fall < SLOW:
                    last = _2 - fall * (
                        _3 - fall * (_4 - fall * (_5 - fall * (_6 - fall * (_7 - fall * _8))))
                    )
                    last *= fall
                table[row + 1, mode] = state + (risen * (start - state) + last * rise)
        for mode in range(first, count):
            fall, lag = max(rates[mode] * step, _SMALLEST), table[row, mode]
            known = min(fall, _FORGOTTEN)
            place = np.int32(known * _FINE + 0.5)
            off = place / _FINE - known
            more = _2 + off * (_3 + off * (_4 + off * (_5 + off * (_6 + off * _7))))
            more = off * (1 + off * more)
            fallen = _FALLEN[place] + (1 + _FALLEN[place]) * more
            table[row + 1, mode] = (1 + fallen) * lag + fallen / fall * rise - drop
