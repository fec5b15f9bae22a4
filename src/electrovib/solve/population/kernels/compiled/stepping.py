"""Stepping of fingers, one finger for each number of a vector, in tiles of as many fingers."""

from __future__ import annotations

from typing import Any

from electrovib.solve.population.kernels.compiled.jit import inner
from electrovib.solve.population.kernels.compiled.lanes import fma, load, splat, store
from electrovib.solve.population.kernels.compiled.vector_math import slot_size, write_weights
from electrovib.solve.population.kernels.compiled.width import WIDTH
from electrovib.solve.population.kernels.time_steps import COMPENSATED


@inner
def advance(
    rates: Any,
    residues: Any,
    direct: Any,
    state: Any,
    table: Any,
    tags: Any,
    since: Any,
    voltage: Any,
    starts: Any,
    kinds: Any,
    durations: Any,
    begin: Any,
    end: Any,
    found: Any,
) -> Any:
    """Advance a tile of fingers from one time to another, and write the responses at these times, (times, fingers).

    `starts` and `kinds` are the first step and the duration of each piece of equal steps; `table` has the weights for
    some durations, whose indices are in `tags`; `since` counts the steps of each duration.
    """
    modes, last = len(rates) // WIDTH, len(voltage) - 1
    slot, stop = slot_size(modes), min(end, last)
    piece, place = 0, begin
    while piece + 1 < len(kinds) and starts[piece + 1] <= begin:
        piece += 1
    while place < stop:
        kind, finish = kinds[piece], min(stop, starts[piece + 1])
        row = kind % len(tags)
        at = row * slot
        if tags[row] != kind:
            write_weights(rates, residues, direct, durations[kind], table, at)
            tags[row] = kind
        _scale(state, table, at, modes, splat(voltage[place]))
        while place < finish:
            until = min(finish, place + COMPENSATED - since[kind])
            since[kind] += until - place
            _follow(state, table, at, modes, voltage, place, until, found, begin)
            place = until
            if since[kind] == COMPENSATED:
                since[kind] = 0
                for mode in range(modes):
                    factor = load(table, at + (4 * modes + mode) * WIDTH)
                    store(state, mode * WIDTH, load(state, mode * WIDTH) * factor)
        _unscale(state, table, at, modes, splat(voltage[place]))
        piece += 1
    if end > last:
        total = load(direct, 0) * splat(voltage[last])
        for mode in range(modes):
            total = total + load(state, mode * WIDTH)
        store(found, (last - begin) * WIDTH, total)


@inner
def _scale(state: Any, table: Any, at: Any, modes: Any, level: Any) -> Any:
    """Replace the contribution s of each mode by w = (s - later v)/scale."""
    for mode in range(modes):
        place = mode * WIDTH
        later = load(table, at + (3 * modes) * WIDTH + place)
        over = load(table, at + (2 * modes) * WIDTH + place)
        store(state, place, fma(-later, level, load(state, place)) * over)


@inner
def _unscale(state: Any, table: Any, at: Any, modes: Any, level: Any) -> Any:
    """Replace w by the contribution of each mode."""
    for mode in range(modes):
        place = mode * WIDTH
        later, scale = load(table, at + (3 * modes) * WIDTH + place), load(table, at + modes * WIDTH + place)
        store(state, place, fma(later, level, load(state, place) * scale))


@inner
def _follow(
    state: Any, table: Any, at: Any, modes: Any, voltage: Any, place: Any, until: Any, found: Any, begin: Any
) -> Any:
    """Advance by equal steps: w' = decay w + v, response = direct v + sum of scale w; eight at a time."""
    level = load(table, at + 5 * modes * WIDTH)
    scales = at + modes * WIDTH
    while place + 8 <= until:
        v0, v1 = splat(voltage[place]), splat(voltage[place + 1])
        v2, v3 = splat(voltage[place + 2]), splat(voltage[place + 3])
        v4, v5 = splat(voltage[place + 4]), splat(voltage[place + 5])
        v6, v7 = splat(voltage[place + 6]), splat(voltage[place + 7])
        y0, y1, y2, y3 = level * v0, level * v1, level * v2, level * v3
        y4, y5, y6, y7 = level * v4, level * v5, level * v6, level * v7
        for mode in range(modes):
            w, decay = load(state, mode * WIDTH), load(table, at + mode * WIDTH)
            scale = load(table, scales + mode * WIDTH)
            y0, w = fma(scale, w, y0), fma(decay, w, v0)
            y1, w = fma(scale, w, y1), fma(decay, w, v1)
            y2, w = fma(scale, w, y2), fma(decay, w, v2)
            y3, w = fma(scale, w, y3), fma(decay, w, v3)
            y4, w = fma(scale, w, y4), fma(decay, w, v4)
            y5, w = fma(scale, w, y5), fma(decay, w, v5)
            y6, w = fma(scale, w, y6), fma(decay, w, v6)
            y7, w = fma(scale, w, y7), fma(decay, w, v7)
            store(state, mode * WIDTH, w)
        to = (place - begin) * WIDTH
        store(found, to, y0)
        store(found, to + WIDTH, y1)
        store(found, to + 2 * WIDTH, y2)
        store(found, to + 3 * WIDTH, y3)
        store(found, to + 4 * WIDTH, y4)
        store(found, to + 5 * WIDTH, y5)
        store(found, to + 6 * WIDTH, y6)
        store(found, to + 7 * WIDTH, y7)
        place += 8
    while place < until:
        v = splat(voltage[place])
        y = level * v
        for mode in range(modes):
            w = load(state, mode * WIDTH)
            y = fma(load(table, scales + mode * WIDTH), w, y)
            store(state, mode * WIDTH, fma(load(table, at + mode * WIDTH), w, v))
        store(found, (place - begin) * WIDTH, y)
        place += 1
