"""Loops over fingers that numba compiles: responses to a drive step by step, counts and moments.

They run without the lock of the interpreter, and are kept on disk where there is a folder for it. In `responses`, fingers are
taken in tiles of `LANES`; the numbers of a tile lie side by side, so that the compiler uses vectors.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from electrovib.solve.recursion.compiling import inner, outer

LANES: Final = 64
"""Fingers of a tile."""
TIMES: Final = 512
"""Times whose responses are in memory together."""
_SMALLEST: Final = (
    2.0**-664
)  # replaces the scale 0 of a mode that the drive does not excite; a power of 2 is exact
_TERMS: Final = 19  # order of the last term of the series of exp(u) for u up to 1
TURNED: Final = 16
"""Numbers of a column of a table that are turned into part of a row together."""
_MINUS_ZERO: Final = -(2**31)  # bit pattern of a float32


@inner
def step_weights(rate: Any, duration: Any, far: Any) -> Any:
    """Return the weights that advance ``s' = -rate s + v`` exactly by one step of a straight drive.

    They are the decay of s, the weights [s] of the drive at the beginning and at the end of the step, and the mean of the
    decay over the step. With u = rate h
    and q = 1/2! + u/3! + u^2/4! + ...::      decay = exp(-u),  mean = (1 - exp(-u))/u, earlier = h (mean - exp(-u))/u =
    h exp(-u) q  and later = h mean - earlier. For u < 1 they follow from the series q, whose terms are all positive, since
    exp(u) = 1 + u + u^2 q and mean = (1 + u q) exp(-u); no difference cancels. `far` is exp(-u) where u >= 1. A rate of 0
    integrates the drive by the trapezoidal rule.
    """
    u = rate * duration
    small, large, series = min(u, 1.0), max(u, 1.0), 1.0
    for order in range(_TERMS, 2, -1):
        series = 1.0 + small * series * (1.0 / order)
    series /= 2.0
    risen = 1.0 + small * series
    near = 1.0 / (1.0 + small * risen)
    decay = near if u < 1.0 else far
    mean = risen * near if u < 1.0 else (1.0 - far) / large
    earlier = near * series if u < 1.0 else (mean - far) / large
    return decay, duration * earlier, duration * (mean - earlier), mean


# Arrays of a tile are flat, row after row of `LANES` numbers: rates, residues, and one row for the direct share; the weights
# of a step: loss, scale and later of all modes, and one row for the direct share with that of the states; states; and
# responses. Indices are unsigned where a loop is to use vectors.


@inner
def _write_weights(tile: Any, modes: Any, duration: Any, lags: Any, weights: Any, at: Any) -> Any:
    """Write the weights of a tile for steps of one duration.

    With the weights a of the state, and A and C of the drive at both ends, w = (s - C v)/scale with scale = a C + A needs
    few operations for each step of equal duration: w' = a w + v. It is advanced by v - (1 - a) w, because a slow mode loses
    digits where a decay near 1 is rounded.
    """
    size = np.uint64(modes * LANES)
    losses, scales = np.uint64(at), np.uint64(at) + size
    laters, levels = scales + size, scales + size + size
    for place in range(np.uint64(0), size):  # by itself: the exponential is no vector
        u = tile[place] * duration
        weights[losses + place] = math.exp(-u) if u >= 1.0 else 1.0
    for place in range(np.uint64(0), size):
        rate, residue = tile[place], tile[size + place]
        decay, earlier, later, mean = step_weights(rate, duration, weights[losses + place])
        later = 0.0 if lags else later
        scale = -residue * mean if lags else residue * (decay * later + earlier)
        weights[losses + place] = rate * duration * mean
        weights[scales + place] = scale if abs(scale) >= _SMALLEST else _SMALLEST
        weights[laters + place] = residue * later
    for lane in range(np.uint64(0), np.uint64(LANES)):
        weights[levels + lane] = tile[size + size + lane]
    for mode in range(modes):
        for lane in range(np.uint64(0), np.uint64(LANES)):
            weights[levels + lane] += weights[laters + np.uint64(mode * LANES) + lane]


@inner
def _gather(fingers: Any, first: Any, end: Any, tile: Any, states: Any) -> Any:
    """Write the parameters of a tile of fingers, and their states at time 0; beyond the last finger it is repeated."""
    rates, residues, direct, begin = fingers
    size = rates.shape[1] * LANES
    for lane in range(LANES):
        finger = min(first + lane, end - 1)
        for mode in range(rates.shape[1]):
            tile[mode * LANES + lane] = rates[finger, mode]
            tile[size + mode * LANES + lane] = residues[finger, mode]
            states[mode * LANES + lane] = begin[finger, mode]
        tile[2 * size + lane] = direct[finger]


@inner
def _advance(memory: Any, modes: Any, states: Any, grid: Any, start: Any, stop: Any) -> Any:
    """Advance a tile by some steps, equal ones together, and write the responses at the beginning of each."""
    tile, weights, held, _ = memory
    voltage, _, lags, kinds, durations = grid
    size, begin = modes * LANES, start
    while begin < stop:
        kind, end = kinds[begin], begin + 1
        while end < stop and kinds[end] == kind:
            end += 1
        at = kind % len(held) * (3 * size + LANES)
        if held[kind % len(held)] != kind:
            _write_weights(tile, modes, durations[kind], lags, weights, at)
            held[kind % len(held)] = kind
        for place in range(np.uint64(0), np.uint64(size)):
            later = weights[np.uint64(at + 2 * size) + place] * voltage[begin]
            states[place] = (states[place] - later) / weights[np.uint64(at + size) + place]
        _follow(memory, modes, states, grid, at, begin, end, (begin - start) * LANES)
        level = voltage[min(end, len(voltage) - 1)]
        for place in range(np.uint64(0), np.uint64(size)):
            later = weights[np.uint64(at + 2 * size) + place] * level
            states[place] = states[place] * weights[np.uint64(at + size) + place] + later
        begin = end


@inner
def _follow(memory: Any, modes: Any, states: Any, grid: Any, at: Any, begin: Any, end: Any, to: Any) -> Any:
    """Advance by equal steps: response = direct v + sum of scale w, w' = w + (given - loss w)."""
    weights, found, voltage, given = memory[1], memory[3], grid[0], grid[1]
    size = modes * LANES
    level, one = np.uint64(at + 3 * size), np.uint64(LANES)
    for step in range(end - begin):
        v, y = voltage[begin + step], np.uint64(to + step * LANES)
        for lane in range(np.uint64(0), one):
            found[y + lane] = weights[level + lane] * v
    for mode in range(modes):
        state, losses = np.uint64(mode * LANES), np.uint64(at + mode * LANES)
        scales, y = np.uint64(at + size + mode * LANES), np.uint64(to)
        for step in range(begin, end):
            v = given[step]
            for lane in range(np.uint64(0), one):
                w = states[state + lane]
                found[y + lane] += weights[scales + lane] * w
                states[state + lane] = w + (v - weights[losses + lane] * w)
            y += one


def responses(fingers: Any, grid: Any, places: Any, out: Any) -> None:
    """Write the responses of fingers at some times, `places`, into the table (fingers, outputs)."""
    modes, durations = fingers[0].shape[1], grid[-1]
    slots = min(len(durations), TIMES)  # for the weights of as many kinds of steps
    memory = (  # for the parameters of a tile, the weights of its steps and their kinds, and its responses
        np.empty((2 * modes + 1) * LANES),
        np.empty(slots * (3 * modes + 1) * LANES),
        np.empty(slots, np.intp),
        np.empty(TIMES * LANES),
    )
    _responses(fingers, grid, memory, places, out)


@outer
def _responses(fingers: Any, grid: Any, memory: Any, places: Any, out: Any) -> Any:
    """Write the responses of fingers, tile after tile."""
    tile, _, held, found = memory
    modes, end, times = fingers[0].shape[1], len(out), len(grid[0])
    states = np.empty(LANES * modes)
    for first in range(0, end, LANES):
        _gather(fingers, first, end, tile, states)
        held[:] = -1
        rows, output = out[first : min(first + LANES, end)], 0
        for start in range(0, times, TIMES):
            stop = min(start + TIMES, times)
            _advance(memory, modes, states, grid, start, stop)
            begin = output
            while output < len(places) and places[output] < stop:
                output += 1
            for lane in range(len(rows)):
                row = rows[lane]
                for place in range(begin, output):
                    row[place] = found[(places[place] - start) * LANES + lane]


@inner
def _ordered(bits: Any) -> Any:
    """Return the bit pattern of a float32 as an integer in the order of the numbers."""
    return bits ^ ((bits >> np.int32(31)) & np.int32(0x7FFFFFFF))


@outer
def turn(table: Any, first: Any, rows: Any) -> Any:
    """Write the columns of a table from one on into rows, some numbers of a column at once."""
    for begin in range(0, len(table), TURNED):
        end = min(begin + TURNED, len(table))
        for column in range(len(rows)):
            row, at = rows[column], np.uint64(first + column)
            for place in range(np.uint64(begin), np.uint64(end)):
                row[place] = table[place, at]


@outer
def count_columns(
    patterns: Any, first: Any, last: Any, pages: Any, counts: Any, missing: Any, again: Any
) -> Any:
    """Count the numbers of some columns in a histogram, and return how many lie in octaves that have no memory.

    The octaves without memory are written into `missing`, (times, octaves). Where `again` holds, only the numbers of
    these octaves are counted. No number may be nan.
    """
    missed = 0
    for row in patterns:
        for time in range(np.uint64(first), np.uint64(last)):
            bits = row[time] if row[time] != _MINUS_ZERO else np.int32(0)
            key = np.uint32(_ordered(bits)) ^ np.uint32(0x80000000)
            octave = key >> np.uint32(23)
            page = pages[time, octave]
            if page < 0:
                missing[time, octave] = True
                missed += 1
            elif not again or missing[time, octave]:
                counts[np.uint32(page), (key >> np.uint32(15)) & np.uint32(255)] += 1
    return missed


@outer
def add_moments(values: Any, shift: Any, total: Any, square: Any) -> Any:
    """Add the differences of fingers from one number for each sample, and their squares."""
    whole = len(values) // 4 * 4
    for finger in range(0, whole, 4):  # four at once: the sums are read and written once for all
        a, b, c, d = values[finger], values[finger + 1], values[finger + 2], values[finger + 3]
        for sample in range(np.uint64(0), np.uint64(len(shift))):
            less = shift[sample]
            p, q, r, s = a[sample] - less, b[sample] - less, c[sample] - less, d[sample] - less
            total[sample] += (p + q) + (r + s)
            square[sample] += (p * p + q * q) + (r * r + s * s)
    for row in values[whole:]:
        for sample in range(len(shift)):
            apart = row[sample] - shift[sample]
            total[sample] += apart
            square[sample] += apart * apart
