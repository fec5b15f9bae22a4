"""Edges of a recorded signal with the samples around them, and impacts, after which a signal swings about its level."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from electrovib.core.errors import InputError, nearest
from electrovib.core.signals import SIGNALS
from electrovib.recordings.importing.reduction import find_edges
from electrovib.recordings.interval import averages
from electrovib.recordings.recording import closed
from electrovib.recordings.running_median import running_median
from electrovib.recordings.transitions.crossings import (
    EdgeLevels,
    Passages,
    creeps,
    levels_from_the_first,
    levels_of,
    passages,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.readback import Readback


Direction = Literal["rising", "falling"]
_LONG: Final = 30.0
"""Length of the section after an edge, in times between its levels as first found."""
_AHEAD: Final = 0.75
"""Part of the section before an edge that ends before it at the latest."""
_MARGIN: Final = 0.05
"""Fraction of the distance to a neighbouring edge that is left out."""
_BRIEF: Final = 4
"""Fewest samples for which a drive is off between two edges; fewer are a polarity reversal."""
_CLEAR: Final = 10.0
"""Range of a signal with edges, in standard deviations of the noise of successive samples."""
_OF_DIFFERENCES: Final = 0.6745 * 2**0.5
"""Median of the magnitude of differences of successive samples, in standard deviations of independent noise."""
_BEFORE: Final = 0.1
"""Time before an oscillation that belongs to the impact, relative to its length."""
_WITHIN: Final = 0.3
"""Slope before the first edge, over its own between its levels, from which on a record begins within the edge; a choice."""
_FEWEST_AVERAGES: Final = 8
_PER_TIME: Final = 100.0
"""Averages of neighbouring samples, in a time between levels, to which forms are fitted."""


@dataclass(frozen=True, kw_only=True)
class EdgeRecord:
    """One edge with its samples, times counted from `reference`: the edge of the drive, or the middle of the signal.

    `reference_error` is the standard uncertainty of that time by the distance of its samples, `fractions` are
    those of the change, from its beginning on, between which times are measured. Forms are
    fitted to `fit_values`, averages of neighbouring samples, of which `fit_noise` is the standard deviation
    before the edge. The signal `creeps` that has not settled at the end.
    """

    direction: Direction
    reference: float
    reference_error: float
    time: Real
    values: Real
    levels: EdgeLevels
    fractions: tuple[float, float]
    passages: Passages
    fit_time: Real
    fit_values: Real
    fit_noise: float
    creeps: bool


def switched_on(drive: Real) -> NDArray[np.bool_]:
    """Return the samples above half of the usual size of a drive, a median, because what was read back may have spikes."""
    size = np.abs(drive)
    return np.asarray(size > np.median(size[size >= size.max() / 2]) / 2)


def reference_times(time: Real, values: Real, drive: Real | None) -> list[float]:
    """Find the times at which edges are expected; a reversal of the polarity of the drive is no edge."""
    if drive is None:
        return _of_signal(time, values)
    switched = np.flatnonzero(np.diff(closed(switched_on(drive), _BRIEF).astype(np.int8)))
    if not switched.size:
        raise InputError(
            f"the drive, from {drive.min():g} to {drive.max():g}, is never switched on or off: its magnitude has no edge. Of one"
            " of two electrodes in antiphase declare so; else choose another signal, or none"
        )
    return [float(time[at] + time[at + 1]) / 2 for at in switched]


def _of_signal(time: Real, values: Real) -> list[float]:
    """Find the edges of the signal itself, between its oscillations about one level."""
    swings = [each for each in find_impacts(time, values) if each.returns]
    outside = np.ones(time.size, dtype=bool)
    for each in swings:
        outside[max(each.begin - int(_BEFORE * (each.end - each.begin)), 0) : each.end] = False
    low, high = np.quantile(values[outside], [0.05, 0.95])
    noise = float(np.median(np.abs(np.diff(values)))) / _OF_DIFFERENCES
    struck = (
        f" It oscillates after {len(swings)} impact{'s' * (len(swings) > 1)}, which --ring (measure_rings) measures"
        if swings
        else " Name the signal of the drive with --by (by), which marks them"
    )
    if noise and high - low < _CLEAR * noise:
        raise InputError(
            f"the signal has no clear edge: 90 % of its samples lie within {(high - low) / noise:.2g} times its noise;"
            f" {_CLEAR:g} times are needed.{struck}"
        )
    found = find_edges(time, values)
    times = [float(each) for each in sorted([*found.rising, *found.falling])]
    kept = [each for each in times if outside[min(int(np.searchsorted(time, each)), time.size - 1)]]
    if not kept:
        raise InputError(
            "the signal has no edge: it does not pass from below 30 % to above 70 % of its range"
            + (f".{struck}" if swings else "")
        )
    return kept


def edge_record(
    time: Real,
    values: Real,
    references: list[float],
    number: int,
    *,
    levels: tuple[float, float],
    driven: bool,
    window: float | None,
    before: float | None,
) -> EdgeRecord:
    """Select the samples of one edge, and find its levels and its passages through them."""
    at = references[number]
    earlier = references[number - 1] if number else float(time[0])
    later = references[number + 1] if number + 1 < len(references) else float(time[-1])
    ahead = (later - at) * (1 - _MARGIN)
    behind = (at - earlier) * ((0.5 if number else 1) - _MARGIN)  # no edge decays before the first
    ahead = min(ahead, window) if window is not None else ahead
    behind = min(behind, before) if before is not None else behind
    find = functools.partial(_found, time, values, at, levels=levels, driven=driven)
    found = find(ahead, behind)
    if not driven and number + 1 < len(references):
        # without a drive the next edge is known by its middle, before which it has begun
        short = later - at - found[2].time
        if 2 * found[2].time < short < ahead:
            ahead = short
            found = find(ahead, behind)
    if window is None and _LONG * found[2].time < ahead:
        ahead = _LONG * found[2].time
        behind = min(behind, ahead / 2) if before is None else behind
        found = find(ahead, behind)
    if not (number or driven or before is not None) and _begins_within(*found[1:]):
        found = _found_from_the_first(time, values, at, ahead, levels=levels)
    here, level, passed = found
    own_time, own_values = time[here] - at, values[here]
    step = float(np.median(np.diff(own_time)))
    count = max(1, int(passed.time / step / _PER_TIME))
    fit_time, fit_values = (averages(part, count) for part in (own_time, own_values))
    ahead_of_it = fit_values[fit_time < (0.0 if driven else passed.first - passed.time)]
    return EdgeRecord(
        direction="rising" if level.change > 0 else "falling",
        reference=at,
        reference_error=step / 12**0.5 if driven else 0.0,
        time=own_time,
        values=own_values,
        levels=level,
        fractions=_of_change(levels, rising=level.change > 0),
        passages=passed,
        fit_time=fit_time,
        fit_values=fit_values,
        fit_noise=float(np.std(ahead_of_it)) if ahead_of_it.size >= _FEWEST_AVERAGES else level.noise,
        creeps=creeps(fit_time - passed.first, (fit_values - level.before) / level.change),
    )


def _found(
    time: Real,
    values: Real,
    at: float,
    ahead: float,
    behind: float,
    *,
    levels: tuple[float, float],
    driven: bool,
) -> tuple[slice, EdgeLevels, Passages]:
    here = slice(
        int(np.searchsorted(time, at - behind)), int(np.searchsorted(time, at + ahead, side="right"))
    )
    part, own = time[here] - at, values[here]
    # without a drive, time 0 is in the middle of the edge: the level before it ends a little earlier
    start = 0.0
    level = levels_of(part, own, edge=start if driven else -behind / 2, settled=0.75 * ahead)
    for _ in range(2):
        fractions = _of_change(levels, rising=level.change > 0)
        passed = passages(part, own, level, fractions=fractions, edge=start if driven else -behind / 2)
        if driven:
            break
        start = passed.first - passed.time
        enough = min(float(part[:9][-1]), -behind / 2)  # a level needs 8 samples, also in a coarse record
        level = levels_of(part, own, edge=max(start, -_AHEAD * behind, enough), settled=0.75 * ahead)
    return here, level, passed


def _begins_within(level: EdgeLevels, passed: Passages) -> bool:
    """Tell whether a record has no level before its first edge, because it begins within it."""
    return level.drift * passed.time / level.change > _WITHIN


def _found_from_the_first(
    time: Real, values: Real, at: float, ahead: float, *, levels: tuple[float, float]
) -> tuple[slice, EdgeLevels, Passages]:
    """Return an edge within which the record begins, from the first sample on."""
    here = slice(0, int(np.searchsorted(time, at + ahead, side="right")))
    part, own = time[here] - at, values[here]
    edge = float(part[0]) / 2
    level = levels_of(part, own, edge=edge, settled=0.75 * ahead)
    level = levels_from_the_first(part, own, level, edge=edge)
    fractions = _of_change(levels, rising=level.change > 0)
    return here, level, passages(part, own, level, fractions=fractions, edge=float(part[0]))


def _of_change(levels: tuple[float, float], *, rising: bool) -> tuple[float, float]:
    """Return the fractions of a change from its beginning on, dimensionless, of levels of the range from below."""
    return levels if rising else (1 - levels[1], 1 - levels[0])


@dataclass(frozen=True, kw_only=True)
class Columns:
    """A signal in its unit over increasing times, and the drive at the same times, or the signal that was chosen for it."""

    signal: str
    unit: str
    time: Real
    values: Real
    drive: Real | None


def columns_of(
    record: xarray.Dataset | str | Path,
    *,
    quantity: str | None,
    by: str | None = None,
    readback: Readback | None = None,
) -> Columns:
    """Return the signal, the only one besides `by` if None, and the drive of a record, without missing samples."""
    if isinstance(record, (str, Path)):
        from electrovib.data.traces import open_trace

        record = open_trace(record)
    signal = _named(record, quantity, by)
    if readback is not None and by is None:
        raise InputError("readback: states how a signal relates to the drive; name that signal with by")
    time = np.asarray(record["time"].values, dtype=float)
    values = np.asarray(record[signal].values, dtype=float)
    drive = None if by is None else np.asarray(record[by].values, dtype=float)
    whole = np.isfinite(values) & (True if drive is None else np.isfinite(drive))
    time, values = time[whole], values[whole]
    if time.size < 40:
        raise InputError(f"quantity = {signal}: it has {time.size} samples; 40 are needed")
    if not (np.diff(time) > 0).all():
        raise InputError("time: the times do not increase; import the record with stamps = 'keep_increasing'")
    if drive is not None:
        drive = drive[whole]
        try:
            drive = drive if readback is None else readback.driving(time - time[0], drive)
        except ValueError as error:
            raise InputError(f"by = {by}: {error}") from None
    unit = SIGNALS[signal].unit if signal in SIGNALS else str(record[signal].attrs.get("units", ""))
    return Columns(signal=signal, unit=unit, time=time, values=values, drive=drive)


def _named(record: xarray.Dataset, quantity: str | None, by: str | None) -> str:
    """Refuse signals that the record does not hold, and return the one to measure."""
    over_time = [str(name) for name, values in record.data_vars.items() if values.dims == ("time",)]
    if quantity is None:
        left = [name for name in over_time if name != by]
        if len(left) != 1:
            raise InputError(
                f"quantity: the record has {len(left)} signals over time ({', '.join(left) or 'none'}); name the one to measure"
            )
        quantity = left[0]
    for option, name in (("quantity", quantity), ("by", by)):
        if name is not None and name not in over_time:
            raise InputError(
                f"{option} = {name}: the record has no such signal over time; it has {', '.join(over_time) or 'none'}."
                f"{nearest(name, over_time)}"
            )
    return quantity


_ABOVE: Final = 4.0
"""Deviation from the level, in standard deviations of the noise, that counts as oscillation."""
LONGER: Final = 1.25
"""Length of the fitted section over that in which the oscillation is above the noise."""
_FADED: Final = 1.5
"""Rms of the signal about its last level during a period, over the noise, below which the oscillation has ended."""
_STRUCK: Final = 3.0
"""Ratio of the rms of successive periods from which on there was another impact."""
_SMALLEST: Final = 8.0
"""Smallest impact, in standard deviations of the noise."""
_SMALLEST_FAINT: Final = 10.0
"""The same in the band in which it stands out most; noise alone stays below."""
_LEAST: Final = 0.05
"""Smallest impact, relative to the largest."""
_BLOCKS: Final = 8000
_PERIODS: Final = 6.0
"""Periods of the lowest band in one of the parts of a record."""
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
    `returns` says whether the signal swings about one level, the same before and after. `seen` is the whole record
    in the band in which a faint one was found; None of others.
    """

    at: float
    begin: int
    end: int
    rest: int
    size: float
    returns: bool
    seen: Real | None = None


@dataclass(frozen=True)
class RingSpan:
    """The end of an oscillation, in the noise or at the next impact, its rough period, and whether it is about one level."""

    end: float
    period: float
    swings: bool


def find_impacts(time: Real, values: Real, *, faint: bool = False) -> list[Impact]:
    """Find the impacts of a record; none if the signal does not leave its noise.

    The level is a moving median, so that a drift is none. The largest deviation from it is an impact, and its
    oscillation lasts until it has fallen into the noise or the next impact strikes; what is left is searched
    again, down to a twentieth of that impact. `faint` ones are searched in the band in which they stand out most.
    """
    level, seen = _level(values), None
    deviation = values - level
    noise, size = _at_rest(deviation), np.abs(deviation)
    if faint and 0 < size.max() < 2 * _SMALLEST * noise:  # a part of the impacts may be below the noise
        band = max(_bands(time, deviation), key=lambda each: np.abs(each).max() / _at_rest(each))
        if np.abs(band).max() > _SMALLEST_FAINT * _at_rest(band):
            seen = deviation = band
            noise, size = _at_rest(band), np.abs(band)
    least = max(_SMALLEST * noise, _LEAST * float(size.max()))
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
        replace(each, rest=max(min(each.rest, later), each.end), seen=seen)
        for each, later in zip(found, following, strict=True)
    ]


def _at_rest(deviation: Real) -> float:
    """Return the standard deviation of a record where it is quiet, in a quarter of its parts."""
    return float(np.quantile([np.std(each) for each in np.array_split(deviation, _STRETCHES)], 0.25))


def _bands(time: Real, deviation: Real) -> Iterator[Real]:
    """Filter a deviation to bands of a quarter of an octave, without delay; the part at rest holds periods of the lowest."""
    from scipy.signal import butter, sosfiltfilt

    yield deviation
    rate = 1 / float(np.median(np.diff(time)))
    lowest, half = _PERIODS * _STRETCHES * rate / time.size, 2**0.125
    for centre in lowest * half ** np.arange(math.log(max(rate / 3 / lowest, 1.0), half)):
        filtering = butter(2, [centre / half, centre * half], "bandpass", fs=rate, output="sos")
        yield np.asarray(sosfiltfilt(filtering, deviation))


def _level(values: Real) -> Real:
    count = max(1, values.size // _BLOCKS)
    whole = values.size // count
    blocks = np.median(values[: whole * count].reshape(whole, count), axis=1)
    level = running_median(blocks, 2 * int(_LEVEL * whole / 2) + 1, beyond="edge")
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
        # at rest, or in an oscillation that decays towards this impact
        if not _ABOVE * noise < part.max() <= before:
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
            last, strength = last + period, rms
            powers, means = powers + rms**2, means + float(np.mean(block)) ** 2
    swings = faded and means < _ONE_LEVEL**2 * powers
    return RingSpan(begin + LONGER * max(last - begin, period), period, swings)


_FEW: Final = 3


def in_few(reasons: Sequence[str]) -> list[str]:
    """Return at most three reasons, the last with the number of those left out."""
    left = len(reasons) - _FEW
    return [*reasons[: _FEW - 1], f"{reasons[_FEW - 1]} (and {left} more)"] if left > 0 else list(reasons)
