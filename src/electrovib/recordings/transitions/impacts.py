"""Impacts and releases in a long record: sections in which a signal swings about its level and comes to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

_ABOVE: Final = 4.0
"""Deviation from the level, in standard deviations of the noise, that counts as oscillation."""
LONGER: Final = 1.25
"""Length of the fitted section over that in which the oscillation is above the noise."""
_FADED: Final = 1.5
"""Rms of the signal about its last level during a period, over the noise, below which the oscillation has ended."""
_STRUCK: Final = 3.0
"""Ratio of the rms of successive periods from which on there was another impact."""
_CLEAR: Final = 8.0
"""Smallest impact, in standard deviations of the noise."""
_LEAST: Final = 0.05
"""Smallest impact, relative to the largest."""
_BLOCKS: Final = 8000
_LEVEL: Final = 0.1
"""Length over which the level is a moving median, relative to the record."""
_STRETCHES: Final = 40
"""Parts of a record, of which a quarter are free of oscillation."""
_REST: Final = 3.0
"""Length of the section of an impact, in lengths of its oscillation; the signal is at rest in its last quarter."""
_ONE_LEVEL: Final = 0.3
"""Largest mean of the deviation over a period, relative to its rms, of a signal that swings about its level."""
_SAME: Final = 0.3
"""Largest change of the level, relative to the largest deviation, of a signal that returns to its level."""
_MOST: Final = 200


@dataclass(frozen=True, kw_only=True)
class Impact:
    """One impact or release with its samples.

    `size` is the largest deviation from the level, at the time `at`. `begin`, `end` and `rest` are the
    samples of the first deviation, of the end of the oscillation and of the end of the rest after it.
    `returns` says whether the signal swings about one level, the same before and after.
    """

    at: float
    begin: int
    end: int
    rest: int
    size: float
    returns: bool


@dataclass(frozen=True)
class RingSpan:
    """The end of an oscillation, in the noise or at the next impact, its rough period, and whether it is about one level."""

    end: float
    period: float
    swings: bool


def find_impacts(time: Real, values: Real) -> list[Impact]:
    """Find the impacts of a record; none if the signal does not leave its noise.

    The level is a moving median, so that a drift is none. The largest deviation from it is an impact, and its
    oscillation lasts until it has fallen into the noise or the next impact strikes; what is left is searched
    again, down to a twentieth of that impact.
    """
    level = _level(values)
    deviation = values - level
    parts = np.array_split(deviation, _STRETCHES)
    noise = float(np.quantile([np.std(each) for each in parts], 0.25))
    size = np.abs(deviation)
    least = max(_CLEAR * noise, _LEAST * float(size.max()))
    free = np.ones(size.size, dtype=bool)
    found: list[Impact] = []
    for _ in range(_MOST):
        at = int(np.argmax(np.where(free, size, 0.0)))
        if not free[at] or not size[at] > least:
            break
        each = _impact(time, deviation, level, noise, at, free)
        free[each.begin : each.end] = False
        found.append(each)
    found.sort(key=lambda each: each.begin)
    following = [each.begin for each in found[1:]] + [time.size] * bool(found)
    return [
        replace(each, rest=max(min(each.rest, later), each.end))
        for each, later in zip(found, following, strict=True)
    ]


def _level(values: Real) -> Real:
    from scipy.ndimage import median_filter

    count = max(1, values.size // _BLOCKS)
    whole = values.size // count
    blocks = np.median(values[: whole * count].reshape(whole, count), axis=1)
    level = median_filter(blocks, 2 * int(_LEVEL * whole / 2) + 1, mode="nearest")
    return np.append(np.repeat(level, count), np.full(values.size - whole * count, level[-1]))


def _impact(
    time: Real, deviation: Real, level: Real, noise: float, at: int, free: NDArray[np.bool_]
) -> Impact:
    """Find the first deviation and the end of the oscillation about the largest one."""
    taken = np.flatnonzero(~free[at:])
    stop = at + int(taken[0]) if taken.size else free.size
    since, size = time[at:stop] - time[at], float(abs(deviation[at]))
    try:
        span = end_of_ring(since, deviation[at:stop], noise, 0.0)
    except InputError:  # a single sample, or the end of the record
        end = min(at + 2, stop)
        return Impact(at=float(time[at]), begin=at, end=end, rest=end, size=size, returns=False)
    begin, earlier, before = at, int(np.searchsorted(time, time[at] - span.period)), size
    while earlier < begin:
        part = np.abs(deviation[earlier:begin])
        if (
            not _ABOVE * noise < part.max() <= before
        ):  # at rest, or in an oscillation that decays towards this impact
            break
        begin, before = earlier + int(np.argmax(part > _ABOVE * noise)), float(part.max())
        earlier = int(np.searchsorted(time, time[begin] - span.period))
    end = at + int(np.searchsorted(since, span.end))
    same = abs(level[min(end, level.size - 1)] - level[earlier]) < _SAME * size
    return Impact(
        at=float(time[at]),
        begin=begin,
        end=end,
        rest=int(np.searchsorted(time, time[at] + _REST * span.end)),
        size=size,
        returns=bool(span.swings and same),
    )


def end_of_ring(since: Real, deviation: Real, noise: float, begin: float) -> RingSpan:
    """Find when an oscillation has fallen into the noise: the first period whose rms is below 1.5 times it."""
    after = int(np.searchsorted(since, begin))
    clear = after + np.flatnonzero(np.abs(deviation[after:]) > _ABOVE * noise)
    turns = np.flatnonzero(np.diff(np.sign(deviation[clear])))
    if clear.size < 3:
        raise InputError(
            "the signal does not leave the noise around its last level, so that there is no oscillation"
        )
    if not turns.size:  # it returns to its level without passing it clearly
        length = float(since[clear[-1]] - begin)
        return RingSpan(begin + 2 * LONGER * length, 4 * length, swings=False)
    # from the beginning, at a turning point or earlier, to the first change of side are a quarter to half of a period
    period = 4 * float(since[clear[turns[0] + 1]] - begin)
    if turns.size > 1:
        period = 2 * float(since[clear[turns[1] + 1]] - since[clear[turns[0] + 1]])
    last, strength, powers, means = begin, math.inf, 0.0, 0.0
    faded = False
    while last + period < since[-1] and not faded:
        block = deviation[np.searchsorted(since, last) : np.searchsorted(since, last + period)]
        rms = math.sqrt(float(np.mean(block**2))) if block.size else 0.0
        if rms > _STRUCK * strength:
            return RingSpan(last, period, swings=means < _ONE_LEVEL**2 * powers)
        faded = block.size < 3 or rms < _FADED * noise
        if not faded:
            last, strength, powers, means = (
                last + period,
                rms,
                powers + rms**2,
                means + float(np.mean(block)) ** 2,
            )
    swings = faded and means < _ONE_LEVEL**2 * powers
    return RingSpan(begin + LONGER * max(last - begin, period), period, swings)
