"""The loops over fingers as operations on arrays: what `loops` computes, readable, and used where numba is not installed."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from electrovib.solve.recursion.hold import hold_weights

_TOGETHER: Final = 64
"""Fingers whose differences are in memory together."""
_MINUS_ZERO: Final = -(2**31)
"""Bit pattern of a float32."""


def responses(fingers: Any, grid: Any, places: Any, out: Any) -> None:
    """Write the responses of fingers at some times, `places`, into the table (fingers, outputs).

    A state times its residue, s, advances by a step to ``s - loss s + residue h (first v + last v')``; with lags, where
    `given` has the rises of the drive, to ``s - loss s - residue mean rise``.
    """
    rates, residues, direct, state = fingers
    voltage, given, lags, kinds, durations = grid
    weights: dict[int, tuple[Any, Any, Any]] = {}
    states, output = state.copy(), 0
    for step, kind in enumerate(kinds):
        if output < len(places) and places[output] == step:
            out[:, output] = direct * voltage[step] + states.sum(axis=1)
            output += 1
        if step == len(voltage) - 1:
            return
        if kind not in weights:
            weights[kind] = _weights(rates, residues, durations[kind], lags=lags)
        loss, first, last = weights[kind]
        pushed = first * given[step] if lags else first * voltage[step] + last * voltage[step + 1]
        states += pushed - loss * states  # a decay near 1 would be rounded


def _weights(rates: Any, residues: Any, duration: float, *, lags: bool) -> tuple[Any, Any, Any]:
    """Return the losses of a step and the weights of the drive at its beginning and its end, or of its rise."""
    z = -rates * duration
    loss = -np.expm1(z)
    if lags:
        mean = np.divide(-loss, z, out=np.ones_like(z), where=z != 0)
        return loss, -residues * mean, None
    _, first, last = hold_weights(z)
    scale = np.divide(residues, rates, out=residues * duration / 2, where=z != 0)
    return loss, scale * np.where(z != 0, first, 1.0), scale * np.where(z != 0, last, 1.0)


def turn(table: Any, first: int, rows: Any) -> None:
    """Write the columns of a table from one on into rows."""
    rows[:] = table[:, first : first + len(rows)].T


def count_columns(
    patterns: Any, first: int, last: int, pages: Any, counts: Any, missing: Any, again: bool
) -> int:
    """Count the numbers of some columns in a histogram, and return how many lie in octaves that have no memory."""
    bits = patterns[:, first:last]
    bits = np.where(bits == _MINUS_ZERO, np.int32(0), bits)
    keys = (bits ^ ((bits >> np.int32(31)) & np.int32(0x7FFFFFFF))).view(np.uint32) ^ np.uint32(0x80000000)
    times, octaves = np.broadcast_to(np.arange(first, last), keys.shape), keys >> np.uint32(23)
    page = pages[times, octaves]
    absent = page < 0
    wanted = ~absent & missing[times, octaves] if again else ~absent
    np.add.at(counts, (page[wanted], (keys[wanted] >> np.uint32(15)) & np.uint32(255)), 1)
    missing[times[absent], octaves[absent]] = True
    return int(np.count_nonzero(absent))


def add_moments(values: Any, shift: Any, total: Any, square: Any) -> None:
    """Add the differences of fingers from one number for each sample, and their squares."""
    for begin in range(0, len(values), _TOGETHER):
        apart = values[begin : begin + _TOGETHER] - shift
        total += apart.sum(axis=0)
        square += np.einsum("ij,ij->j", apart, apart)
