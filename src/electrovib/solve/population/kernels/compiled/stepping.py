"""Stepping of fingers, one finger for each number of a vector, in tiles of as many fingers."""

from __future__ import annotations

from typing import Any, Final

from electrovib.solve.population.kernels.compiled.vector_math import write_weights
from electrovib.solve.population.kernels.time_steps import COMPENSATED
from electrovib.solve.recursion.vectors.jit import inlined, inner
from electrovib.solve.recursion.vectors.lanes import fma, load, splat, store
from electrovib.solve.recursion.vectors.width import WIDTH

TIMES: Final = 512
"""Times whose responses are in the cache together."""


# The memory of a tile: rates, residues, (modes, fingers); direct share, factor, (fingers,); responses, (TIMES, fingers);
# and the weights for some durations. One array with places in it: a view for each would cost more than some steps.


@inlined
def direct_at(modes: Any) -> Any:
    """Return the place of the direct share."""
    return 2 * modes * WIDTH


@inlined
def factor_at(modes: Any) -> Any:
    """Return the place of the factor."""
    return (2 * modes + 1) * WIDTH


@inlined
def found_at(modes: Any) -> Any:
    """Return the place of the responses."""
    return (2 * modes + 2) * WIDTH


@inner
def advance(
    work: Any,
    at: Any,
    modes: Any,
    states: Any,
    held: Any,
    tags: Any,
    since: Any,
    tile: Any,
    voltage: Any,
    starts: Any,
    kinds: Any,
    durations: Any,
    begin: Any,
    end: Any,
) -> Any:
    """Advance a tile of fingers from one time to another, and write the responses at these times, (times, fingers).

    The memory of the tile begins at `at` in `work`, its states at `held` in `states`. `starts` and `kinds` are the first
    step and the duration of each piece of equal steps; row `tile` of `tags` has the durations whose weights are in
    memory, and that of `since` counts the steps of each duration.
    """
    last = len(voltage) - 1
    slot, stop, piece, place = (5 * modes + 1) * WIDTH, min(end, last), 0, begin
    found, table = at + found_at(modes), at + found_at(modes) + TIMES * WIDTH
    while piece + 1 < len(kinds) and starts[piece + 1] <= begin:
        piece += 1
    while place < stop:
        kind, finish = kinds[piece], min(stop, starts[piece + 1])
        row = kind % tags.shape[1]
        weights = table + row * slot
        if tags[tile, row] != kind:
            write_weights(work, at, modes, durations[kind], weights)
            tags[tile, row] = kind
        _scale(states, held, work, weights, modes, splat(voltage[place]))
        while place < finish:
            until = min(finish, place + COMPENSATED - since[tile, kind])
            since[tile, kind] += until - place
            _follow(
                states, held, work, weights, modes, voltage, place, until, found + (place - begin) * WIDTH
            )
            place = until
            if since[tile, kind] == COMPENSATED:
                since[tile, kind] = 0
                for mode in range(0, modes * WIDTH, WIDTH):
                    factor = load(work, weights + 4 * modes * WIDTH + mode)
                    store(states, held + mode, load(states, held + mode) * factor)
        _unscale(states, held, work, weights, modes, splat(voltage[place]))
        piece += 1
    if end > last:
        total = load(work, at + direct_at(modes)) * splat(voltage[last])
        for mode in range(0, modes * WIDTH, WIDTH):
            total = total + load(states, held + mode)
        store(work, found + (last - begin) * WIDTH, total)


@inner
def _scale(states: Any, held: Any, work: Any, weights: Any, modes: Any, level: Any) -> Any:
    """Replace the contribution s of each mode by w = (s - later v)/scale."""
    size = modes * WIDTH
    for mode in range(0, size, WIDTH):
        later, over = load(work, weights + 3 * size + mode), load(work, weights + 2 * size + mode)
        store(states, held + mode, fma(-later, level, load(states, held + mode)) * over)


@inner
def _unscale(states: Any, held: Any, work: Any, weights: Any, modes: Any, level: Any) -> Any:
    """Replace w by the contribution of each mode."""
    size = modes * WIDTH
    for mode in range(0, size, WIDTH):
        later, scale = load(work, weights + 3 * size + mode), load(work, weights + size + mode)
        store(states, held + mode, fma(later, level, load(states, held + mode) * scale))


@inner
def _follow(
    states: Any,
    held: Any,
    work: Any,
    weights: Any,
    modes: Any,
    voltage: Any,
    place: Any,
    until: Any,
    to: Any,
) -> Any:
    """Advance by equal steps: w' = decay w + v, response = direct v + sum of scale w; eight at a time."""
    size = modes * WIDTH
    level, scales = load(work, weights + 5 * size), weights + size
    while place + 8 <= until:
        v0, v1 = splat(voltage[place]), splat(voltage[place + 1])
        v2, v3 = splat(voltage[place + 2]), splat(voltage[place + 3])
        v4, v5 = splat(voltage[place + 4]), splat(voltage[place + 5])
        v6, v7 = splat(voltage[place + 6]), splat(voltage[place + 7])
        y0, y1, y2, y3 = level * v0, level * v1, level * v2, level * v3
        y4, y5, y6, y7 = level * v4, level * v5, level * v6, level * v7
        for mode in range(0, size, WIDTH):
            w, decay = load(states, held + mode), load(work, weights + mode)
            scale = load(work, scales + mode)
            y0, w = fma(scale, w, y0), fma(decay, w, v0)
            y1, w = fma(scale, w, y1), fma(decay, w, v1)
            y2, w = fma(scale, w, y2), fma(decay, w, v2)
            y3, w = fma(scale, w, y3), fma(decay, w, v3)
            y4, w = fma(scale, w, y4), fma(decay, w, v4)
            y5, w = fma(scale, w, y5), fma(decay, w, v5)
            y6, w = fma(scale, w, y6), fma(decay, w, v6)
            y7, w = fma(scale, w, y7), fma(decay, w, v7)
            store(states, held + mode, w)
        store(work, to, y0)
        store(work, to + WIDTH, y1)
        store(work, to + 2 * WIDTH, y2)
        store(work, to + 3 * WIDTH, y3)
        store(work, to + 4 * WIDTH, y4)
        store(work, to + 5 * WIDTH, y5)
        store(work, to + 6 * WIDTH, y6)
        store(work, to + 7 * WIDTH, y7)
        place, to = place + 8, to + 8 * WIDTH
    while place < until:
        v = splat(voltage[place])
        y = level * v
        for mode in range(0, size, WIDTH):
            w = load(states, held + mode)
            y = fma(load(work, scales + mode), w, y)
            store(states, held + mode, fma(load(work, weights + mode), w, v))
        store(work, to, y)
        place, to = place + 1, to + WIDTH
