"""Fingers in tiles: their responses as a table, or only the moments of a function of them."""

from __future__ import annotations

from typing import Any, Final

from electrovib.solve.population.kernels.compiled.stepping import (
    TIMES,
    advance,
    direct_at,
    factor_at,
    found_at,
)
from electrovib.solve.recursion.vectors.jit import inlined, inner, outer
from electrovib.solve.recursion.vectors.lanes import fma, load, splat, store, store_rows
from electrovib.solve.recursion.vectors.width import WIDTH

FOUR: Final = 4
"""Tiles whose values are added to the moments together."""


@inner
def gather_tile(values: Any, begin: Any, end: Any, work: Any, at: Any) -> Any:
    """Write a table (fingers, modes) as vectors of fingers, one for each mode; 0 beyond the last finger."""
    for mode in range(values.shape[1]):
        for lane in range(WIDTH):
            work[at + mode * WIDTH + lane] = values[begin + lane, mode] if begin + lane < end else 0.0


@inner
def gather_row(values: Any, begin: Any, end: Any, work: Any, at: Any) -> Any:
    """Write numbers of fingers as a vector; 0 beyond the last finger, and where there are no numbers."""
    for lane in range(WIDTH):
        work[at + lane] = values[begin + lane] if begin + lane < min(end, len(values)) else 0.0


@inner
def begin_tile(fingers: Any, factor: Any, first: Any, end: Any, work: Any, at: Any) -> Any:
    """Write the parameters of a tile into its memory."""
    rates, residues, direct, _ = fingers
    modes = rates.shape[1]
    gather_tile(rates, first, end, work, at)
    gather_tile(residues, first, end, work, at + modes * WIDTH)
    gather_row(direct, first, end, work, at + direct_at(modes))
    gather_row(factor, first, end, work, at + factor_at(modes))


@inner
def square_tile(work: Any, modes: Any, times: Any) -> Any:
    """Replace responses by factor times their square."""
    share = load(work, factor_at(modes))
    for place in range(found_at(modes), found_at(modes) + times * WIDTH, WIDTH):
        value = load(work, place)
        store(work, place, share * value * value)


@outer
def step_tiles(
    fingers: Any,
    factor: Any,
    voltage: Any,
    pieces: Any,
    begin: Any,
    end: Any,
    work: Any,
    tags: Any,
    since: Any,
    state: Any,
    out: Any,
) -> Any:
    """Write the responses of some fingers, or factor times their squares, into the table (fingers, times)."""
    modes, last, counted = fingers[0].shape[1], len(voltage), since.copy()
    starts, kinds, durations = pieces
    for first in range(begin, end, WIDTH):
        begin_tile(fingers, factor, first, end, work, 0)
        gather_tile(fingers[3], first, end, state, 0)
        tags[:] = -1
        counted[:] = since
        for time in range(0, last, TIMES):
            stop = min(time + TIMES, last)
            advance(work, 0, modes, state, 0, tags, counted, 0, voltage, starts, kinds, durations, time, stop)
            if len(factor):
                square_tile(work, modes, stop - time)
            _put_out(work, found_at(modes), stop - time, out, first, min(first + WIDTH, end), time)


@inner
def _put_out(work: Any, at: Any, times: Any, out: Any, first: Any, end: Any, time: Any) -> Any:
    """Write responses, (times, fingers), into the table (fingers, times)."""
    whole = times // WIDTH * WIDTH if end - first == WIDTH else 0
    for place in range(0, whole, WIDTH):
        store_rows(out, first, time + place, work, at + place * WIDTH)
    for lane in range(end - first):
        for place in range(whole, times):
            out[first + lane, time + place] = work[at + place * WIDTH + lane]


@outer
def square_moments_of_block(
    fingers: Any,
    factor: Any,
    voltage: Any,
    pieces: Any,
    block: Any,
    work: Any,
    tags: Any,
    since: Any,
    states: Any,
    sums: Any,
    mean: Any,
    squares: Any,
) -> Any:
    """Write mean and sum of squared deviations of factor times the squared response of one block of fingers.

    Four tiles are advanced one after the other, each in its part of `work` and its row of `tags` and `since`. `states`
    keeps the states of all tiles between intervals of time; `sums`, (2, times * fingers), has as many times as an
    interval, with the moments of the fingers at the same place of their tiles.
    """
    begin, end = block
    starts, kinds, durations = pieces
    modes, last, length = fingers[0].shape[1], len(voltage), sums.shape[1] // WIDTH
    size, each, mean_of, squares_of = modes * WIDTH, len(work) // FOUR, sums[0], sums[1]
    counted = since.copy()
    for from_time in range(0, last, length):
        to_time = min(from_time + length, last)
        sums[:] = 0.0
        for first in range(begin, end, FOUR * WIDTH):
            held = (first - begin) // WIDTH
            tiles = min(FOUR, (end - first + WIDTH - 1) // WIDTH)
            tags[:] = -1
            counted[:] = since
            for tile in range(tiles):
                finger = first + tile * WIDTH
                begin_tile(fingers, factor, finger, end, work, tile * each)
                if from_time == 0:
                    gather_tile(fingers[3], finger, end, states, (held + tile) * size)
            for time in range(from_time, to_time, TIMES):
                stop, at = min(time + TIMES, to_time), (time - from_time) * WIDTH
                for tile in range(tiles):
                    one, state = tile * each, (held + tile) * size
                    advance(
                        work,
                        one,
                        modes,
                        states,
                        state,
                        tags,
                        counted,
                        tile,
                        voltage,
                        starts,
                        kinds,
                        durations,
                        time,
                        stop,
                    )
                _add_tiles(work, each, modes, stop - time, mean_of, squares_of, at, held + 1, end - first)
        since[:] = counted[0]
        _merge(sums, end - begin, mean[from_time:to_time], squares[from_time:to_time])


@inlined
def _updated(value: Any, share: Any, mean: Any, squares: Any) -> Any:
    """Return mean and squared deviations with one more value, of which the share is one over the count."""
    apart = value - mean
    new = fma(apart, share, mean)
    return new, fma(apart, value - new, squares)


@inner
def _add_tiles(
    work: Any, each: Any, modes: Any, times: Any, mean: Any, squares: Any, at: Any, count: Any, fingers: Any
) -> Any:
    """Add the values of up to four tiles to the moments, for which `count` is that of the first tile."""
    if fingers >= FOUR * WIDTH:
        _add_four(work, each, modes, times, mean, squares, at, count)
        return
    for tile in range((fingers + WIDTH - 1) // WIDTH):
        among = min(WIDTH, fingers - tile * WIDTH)
        _add(work, tile * each, modes, times, mean, squares, at, count + tile, among)


@inner
def _add_four(
    work: Any, each: Any, modes: Any, times: Any, mean: Any, squares: Any, at: Any, count: Any
) -> Any:
    """Add factor times the squared responses of four whole tiles to the moments."""
    place, end = factor_at(modes), at + times * WIDTH
    f1, f2 = load(work, place), load(work, place + each)
    f3, f4 = load(work, place + 2 * each), load(work, place + 3 * each)
    s1, s2 = splat(1.0 / count), splat(1.0 / (count + 1))
    s3, s4 = splat(1.0 / (count + 2)), splat(1.0 / (count + 3))
    place = found_at(modes)
    while at < end:
        m, q = load(mean, at), load(squares, at)
        y1, y2 = load(work, place), load(work, place + each)
        y3, y4 = load(work, place + 2 * each), load(work, place + 3 * each)
        m, q = _updated(f1 * y1 * y1, s1, m, q)
        m, q = _updated(f2 * y2 * y2, s2, m, q)
        m, q = _updated(f3 * y3 * y3, s3, m, q)
        m, q = _updated(f4 * y4 * y4, s4, m, q)
        store(mean, at, m)
        store(squares, at, q)
        at, place = at + WIDTH, place + WIDTH


@inner
def _add(
    work: Any, tile: Any, modes: Any, times: Any, mean: Any, squares: Any, at: Any, count: Any, fingers: Any
) -> Any:
    """Add factor times the squared responses of some fingers of one tile to the moments."""
    for time in range(times):
        for lane in range(fingers):
            place = at + time * WIDTH + lane
            response = work[tile + found_at(modes) + time * WIDTH + lane]
            value = work[tile + factor_at(modes) + lane] * response * response
            apart = value - mean[place]
            mean[place] += apart / count
            squares[place] += apart * (value - mean[place])


@inner
def _merge(sums: Any, fingers: Any, mean: Any, squares: Any) -> Any:
    """Write the moments of a block from those of the fingers at the same place of their tiles."""
    tiles, more = fingers // WIDTH, fingers % WIDTH
    for time in range(len(mean)):
        total, spread, place = 0.0, 0.0, time * WIDTH
        for lane in range(WIDTH):
            total += (tiles + (lane < more)) * sums[0, place + lane]
        middle = total / fingers
        for lane in range(WIDTH):
            apart = sums[0, place + lane] - middle
            spread += sums[1, place + lane] + (tiles + (lane < more)) * apart * apart
        mean[time], squares[time] = middle, spread


@outer
def moments_of_block(values: Any, begin: Any, end: Any, mean: Any, squares: Any) -> Any:
    """Write mean and sum of squared deviations of some rows of a table."""
    for start in range(0, values.shape[1], TIMES):
        stop = min(start + TIMES, values.shape[1])
        mean[start:stop] = 0.0
        squares[start:stop] = 0.0
        for finger in range(begin, end):
            share = 1.0 / (finger - begin + 1)
            for time in range(start, stop):
                apart = values[finger, time] - mean[time]
                mean[time] += apart * share
                squares[time] += apart * (values[finger, time] - mean[time])
