"""Fingers in tiles: their responses as a table, or only the moments of a function of them."""

from __future__ import annotations

from typing import Any, Final

from electrovib.solve.population.kernels.compiled.jit import inner, outer
from electrovib.solve.population.kernels.compiled.lanes import fma, load, splat, store, store_rows
from electrovib.solve.population.kernels.compiled.stepping import advance
from electrovib.solve.population.kernels.compiled.width import WIDTH

TIMES: Final = 256
"""Times whose responses are in the cache together."""


@inner
def gather_tile(values: Any, begin: Any, end: Any, tile: Any) -> Any:
    """Write a table (fingers, modes) as vectors of fingers, one for each mode; 0 beyond the last finger."""
    for mode in range(values.shape[1]):
        for lane in range(WIDTH):
            tile[mode * WIDTH + lane] = values[begin + lane, mode] if begin + lane < end else 0.0


@inner
def gather_row(values: Any, begin: Any, end: Any, tile: Any) -> Any:
    """Write numbers of fingers as a vector; 0 beyond the last finger."""
    for lane in range(WIDTH):
        tile[lane] = values[begin + lane] if begin + lane < end else 0.0


@inner
def square(found: Any, times: Any, factor: Any) -> Any:
    """Replace responses by factor times their square."""
    share = load(factor, 0)
    for time in range(times):
        value = load(found, time * WIDTH)
        store(found, time * WIDTH, share * value * value)


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
    out: Any,
) -> Any:
    """Write the responses of some fingers, or factor times their squares, into the table (fingers, times)."""
    rates, residues, direct, state = fingers
    starts, kinds, durations = pieces
    size, last = rates.shape[1] * WIDTH, len(voltage)
    rate, residue, held = work[:size], work[size : 2 * size], work[2 * size : 3 * size]
    at_once, share = work[3 * size : 3 * size + WIDTH], work[3 * size + WIDTH : 3 * size + 2 * WIDTH]
    found = work[3 * size + 2 * WIDTH : 3 * size + (2 + TIMES) * WIDTH]
    table = work[3 * size + (2 + TIMES) * WIDTH :]
    for first in range(begin, end, WIDTH):
        gather_tile(rates, first, end, rate)
        gather_tile(residues, first, end, residue)
        gather_tile(state, first, end, held)
        gather_row(direct, first, end, at_once)
        if len(factor):
            gather_row(factor, first, end, share)
        tags[:] = -1
        since[:] = 0
        for time in range(0, last, TIMES):
            stop = min(time + TIMES, last)
            advance(
                rate,
                residue,
                at_once,
                held,
                table,
                tags,
                since,
                voltage,
                starts,
                kinds,
                durations,
                time,
                stop,
                found,
            )
            if len(factor):
                square(found, stop - time, share)
            _put_out(found, stop - time, out, first, min(first + WIDTH, end), time)


@inner
def _put_out(found: Any, times: Any, out: Any, first: Any, end: Any, time: Any) -> Any:
    """Write responses, (times, fingers), into the table (fingers, times)."""
    whole = times // WIDTH * WIDTH if end - first == WIDTH else 0
    for place in range(0, whole, WIDTH):
        store_rows(out, first, time + place, found, place * WIDTH)
    for lane in range(end - first):
        for place in range(whole, times):
            out[first + lane, time + place] = found[place * WIDTH + lane]


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

    `states` keeps the states of all tiles between intervals of time; `sums`, (2, times, fingers), has as many times as
    an interval, with the moments of the fingers at the same place of their tiles.
    """
    rates, residues, direct, state = fingers
    starts, kinds, durations = pieces
    begin, end = block
    size, last, length = rates.shape[1] * WIDTH, len(voltage), sums.shape[1] // WIDTH
    rate, residue = work[:size], work[size : 2 * size]
    at_once, share = work[3 * size : 3 * size + WIDTH], work[3 * size + WIDTH : 3 * size + 2 * WIDTH]
    found = work[3 * size + 2 * WIDTH : 3 * size + (2 + TIMES) * WIDTH]
    table = work[3 * size + (2 + TIMES) * WIDTH :]
    counted = since.copy()
    for from_time in range(0, last, length):
        to_time = min(from_time + length, last)
        sums[:] = 0.0
        for first in range(begin, end, WIDTH):
            held = states[(first - begin) // WIDTH]
            gather_tile(rates, first, end, rate)
            gather_tile(residues, first, end, residue)
            if from_time == 0:
                gather_tile(state, first, end, held)
            gather_row(direct, first, end, at_once)
            gather_row(factor, first, end, share)
            tags[:] = -1
            counted[:] = since
            for time in range(from_time, to_time, TIMES):
                stop = min(time + TIMES, to_time)
                advance(
                    rate,
                    residue,
                    at_once,
                    held,
                    table,
                    tags,
                    counted,
                    voltage,
                    starts,
                    kinds,
                    durations,
                    time,
                    stop,
                    found,
                )
                square(found, stop - time, share)
                count, at = (first - begin) // WIDTH + 1, (time - from_time) * WIDTH
                _add(found, stop - time, sums, at, count, min(WIDTH, end - first))
        since[:] = counted
        _merge(sums, end - begin, mean[from_time:to_time], squares[from_time:to_time])


@inner
def _add(found: Any, times: Any, sums: Any, at: Any, count: Any, fingers: Any) -> Any:
    """Add values to mean and squared deviations, each finger to those at the same place of the tiles before."""
    share, mean, squares = splat(1.0 / count), sums[0], sums[1]
    if fingers == WIDTH:
        for place in range(0, times * WIDTH, WIDTH):
            value, old = load(found, place), load(mean, at + place)
            apart = value - old
            new = fma(apart, share, old)
            store(mean, at + place, new)
            store(squares, at + place, fma(apart, value - new, load(squares, at + place)))
        return
    for time in range(times):
        for lane in range(fingers):
            place = time * WIDTH + lane
            apart = found[place] - mean[at + place]
            mean[at + place] += apart / count
            squares[at + place] += apart * (found[place] - mean[at + place])


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
