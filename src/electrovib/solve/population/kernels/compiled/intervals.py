"""Squared responses of many fingers at some times after the other, one row for each time, and statistics of these rows.

A row is written and read in one piece: values of other times are not in memory, and none is moved.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from electrovib.solve.population.kernels.compiled.selection import of_row, ordered
from electrovib.solve.population.kernels.compiled.stepping import advance, found_at
from electrovib.solve.population.kernels.compiled.tiles import begin_tile, gather_tile, square_tile
from electrovib.solve.recursion.vectors.jit import outer
from electrovib.solve.recursion.vectors.width import WIDTH

TOGETHER: Final = 64
"""Fingers whose values are written into the table together."""


_MINUS_ZERO: Final = -(2**31)


@outer
def squares_between(
    fingers: Any,
    factor: Any,
    voltage: Any,
    pieces: Any,
    begin: Any,
    end: Any,
    time: Any,
    stop: Any,
    work: Any,
    tags: Any,
    since: Any,
    states: Any,
    some: Any,
    out: Any,
) -> Any:
    """Write factor times the squared responses of some fingers from one time to another, at most `TIMES` later.

    `states` keeps the states of the tiles of these fingers between calls, and `since` their steps of each duration.
    `some`, (times, `TOGETHER`), holds the values of a few tiles, so that whole lines of the cache are written into the
    table `out`, (times, fingers), which has columns for whole tiles.
    """
    modes, counted = fingers[0].shape[1], since.copy()
    starts, kinds, durations = pieces
    for group in range(begin, end, TOGETHER):
        last = min(group + TOGETHER, end)
        for first in range(group, last, WIDTH):
            state = (first - begin) * modes
            begin_tile(fingers, factor, first, end, work, 0)
            if time == 0:
                gather_tile(fingers[3], first, end, states, state)
            tags[:] = -1
            counted[:] = since
            advance(
                work, 0, modes, states, state, tags, counted, 0, voltage, starts, kinds, durations, time, stop
            )
            square_tile(work, modes, stop - time)
            place = found_at(modes)
            for row in range(stop - time):
                for lane in range(WIDTH):
                    some[row, first - group + lane] = work[place + lane]
                place += WIDTH
        for row in range(stop - time):
            for column in range(last - group):
                out[row, group + column] = some[row, column]
    since[:] = counted


@outer
def order_statistics_of_rows(
    patterns: Any, count: Any, places: Any, rows: Any, some: Any, fewer: Any, counts: Any, found: Any
) -> Any:
    """Write order statistics of so many numbers of some rows, as `order_statistics` does of columns, and overwrite them.

    The statistics of row ``rows[k]`` are written into column k of `found`.
    """
    for column in range(len(rows)):
        row = patterns[rows[column]]
        for finger in range(count):
            row[finger] = ordered(row[finger])
        of_row(row, count, places, some, fewer, counts, found[:, column])


@outer
def count_rows(
    patterns: Any,
    count: Any,
    rows: Any,
    first: Any,
    pages: Any,
    counts: Any,
    bins: Any,
    found: Any,
    again: Any,
) -> Any:
    """Count so many numbers of some rows in a histogram, and return how many lie in octaves that have no memory.

    Row ``rows[k]`` is that of time first + k. The octaves without memory are written into `found`, (times, octaves). Where
    `again` holds, only the numbers of these octaves are counted. No number may be nan.
    """
    missed = 0
    for place in range(len(rows)):
        row, time = patterns[rows[place]], first + place
        for finger in range(count):
            bits = row[finger] if row[finger] != _MINUS_ZERO else np.int32(0)
            bins[finger] = (ordered(bits) >> np.int32(15)) + np.int32(65536)
        for finger in range(count):
            octave = bins[finger] >> 8
            page = pages[time, octave]
            if again:
                if found[time, octave]:
                    counts[page, bins[finger] & 255] += 1
            elif page >= 0:
                counts[page, bins[finger] & 255] += 1
            else:
                found[time, octave] = True
                missed += 1
    return missed


@outer
def add_pages(pages: Any, counts: Any, others: Any, more: Any) -> Any:
    """Add the counts of another histogram to one that has memory for all its octaves."""
    for time in range(pages.shape[0]):
        for octave in range(pages.shape[1]):
            if others[time, octave] >= 0:
                counts[pages[time, octave]] += more[others[time, octave]]
