"""Times of the samples of a file: of the clock that the chosen columns share, of repeated stamps, of records of changes."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.recorded import ChannelClock, column_of
from electrovib.data.text.preamble import segments_of
from electrovib.data.unit_words import HAS_POWER, kind_and_factor
from electrovib.recordings.importing.choice import proposed_time
from electrovib.recordings.importing.reduction import seconds

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded

_FEWEST: Final = 4
_MOST_LEVELS: Final = 16
_SHARE: Final = 2 / 3
"""Largest number of levels, in units of the number of rows; readings hardly repeat."""
_INSPECTED: Final = 1000
"""Rows in which more levels than a record of changes has are looked for first."""
_ALIKE: Final = 0.1
"""Deviation from the median interval, relative to it, within which an interval is a usual one."""
_EVEN: Final = 0.6
"""Share of usual intervals from which on a record is one of samples, some of which may be missing."""
_EDGE: Final = 1e-6
"""Time between two levels, in units of the shortest interval."""


def is_held(time: Real, recorded: Recorded, clock: str) -> bool:
    """Return whether each row differs from the one before, at uneven times, and no column has more than a few levels.

    Times do not matter where each column has two levels: samples of such a signal would repeat.
    """
    times = {recorded.time, clock, *(each.time for each in recorded.clocks.values())}
    columns = [
        each.values for each in recorded.channels if each.name not in times and each.values.size == time.size
    ]
    if len(columns) < 1 or time.size < _FEWEST:
        return False
    if any(np.unique(each[:_INSPECTED]).size > _MOST_LEVELS for each in columns):
        return False
    rows = np.nan_to_num(np.array(columns), nan=np.inf)
    levels = max(np.unique(each).size for each in rows)
    changes = (np.diff(rows, axis=1) != 0).any(axis=0)
    if (
        levels > min(_MOST_LEVELS, _SHARE * time.size) or not changes[:-1].all()
    ):  # the last row may be the end alone
        return False
    change = np.diff(time)
    usual = np.abs(change - np.median(change)) <= _ALIKE * np.median(change)
    return levels == 2 or float(np.mean(usual)) < _EVEN


def held(time: Real, signals: dict[str, Real]) -> tuple[Real, dict[str, Real]]:
    """Return signals that keep each value until just before the next row, so that lines between their samples are levels."""
    before = np.minimum(time[1:] - _EDGE * np.diff(time).min(), np.nextafter(time[1:], -np.inf))
    found = np.append(np.stack([time[:-1], before], axis=1).ravel(), time[-1])
    return found, {name: np.append(np.repeat(values[:-1], 2), values[-1]) for name, values in signals.items()}


_GAP: Final = 1.5
"""Interval, in units of the median interval, from which on samples are missing."""
_MOST_GAPS: Final = 0.2
"""Share of intervals above `_GAP` from which on a record is not evenly sampled."""
_OFF: Final = 0.15
"""Distance from a whole number of median intervals beyond which an interval is no gap of an even record."""
_FEW_GAPS: Final = 0.02
"""Share of intervals above `_GAP` up to which these are gaps, of whatever length, as of a logger that paused."""
_BLOCK: Final = 2**17
"""Steps that are looked at together."""
_NO_STAMPS: Final = "the file has no time stamps, so dropped samples cannot be noticed"
_HELD: Final = (
    "the file has a row only where a value changes; each value is held until just before the next row"
)
_AGREE: Final = 0.01
"""Difference between the steps of times and a stated one, relative to it, that counts as rounding."""
_STAMP: Final = re.compile(r"time[\s_]?stamp", re.IGNORECASE)
"""Headings of times that may count any unit."""
_FAR: Final = 100
"""Distance of the first time from zero, in lengths of the record, from which on the times count from another day or year."""
STAMPS: Final = ("refuse", "keep_increasing")
"""Treatments of time stamps that do not increase."""


Rows: TypeAlias = slice | np.ndarray[tuple[int], np.dtype[np.intp]]
_ALL: Final = slice(None)


@dataclass(frozen=True, kw_only=True)
class SampleTimes:
    """The times of the samples that are kept, increasing [s], with their numbers from 0 and one sentence for each step.

    The numbers are a slice where all samples are kept. `held` tells that the file has a row only where a value changes.
    """

    time: Real
    rows: Rows
    steps: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]
    held: bool = False


def sample_times(
    recorded: Recorded,
    columns: Sequence[str] = (),
    *,
    time: str = "",
    step: str | float | None = None,
    stamps: str = "refuse",
) -> SampleTimes:
    """Return the times of the samples of `columns`; a `step` [s] has priority over the file, `stamps` is one of `STAMPS`."""
    if stamps not in STAMPS:
        raise InputError(f"stamps = {stamps}: expected one of {', '.join(STAMPS)}")
    if step is not None and time:
        raise InputError("step: the time column is given too; omit one of the two")
    if step is not None:
        return _even(recorded.size, seconds("step", step), 0.0, "as given")
    column = column_of(recorded, time, option="time") if time else None
    clock = ChannelClock(time=column.name) if column else _shared(recorded, columns)
    if not clock.time and clock.step is not None:
        return _even(recorded.size, clock.step, clock.start, "as the file states")
    if not clock.time:
        example = proposed_time(recorded) or recorded.channels[0]
        raise InputError(
            "time: the file states neither times nor a time step; state the column with its unit, such as time ="
            f" '{example.name} [s]', or a step such as '10 us'"
        )
    column = column or column_of(recorded, clock.time, option="time")
    known = kind_and_factor(column.unit or "s")
    if known is None or known[0] != "s":
        raise InputError(f"time = {column.name}: '{column.unit}' is not a unit of time")
    if needs_unit(column):
        name = column.name
        raise InputError(
            f"time: the file states no unit for '{name}'; state it: time = '{name} [s]' if it is in s"
        )
    steps = [f"time: column '{column.name}' [{column.unit or 's'}]"]
    text = f"the file states no unit for '{column.name}'; s were assumed"
    unsure = [] if column.unit else [Diagnostic("unit of time", "unknown", text)]
    unsure += [each for each in _others(recorded, columns, clock) if time]
    with np.errstate(all="ignore"):  # time stamps of a damaged file may overflow
        stated = column.values if known[1] == 1 else column.values * known[1]
        found, rows, more, doubts = _increasing(stated, stamps)
        if not time and clock.step is not None:
            _refuse_other_step(f"{column.name} [{column.unit or 'UNIT'}]", found, clock.step)
        changes = found.size == recorded.size and is_held(found, recorded, column.name)
        gaps = (Diagnostic("dropped samples", "ok", _HELD),) if changes else _gaps(found)
    more += [f"time: {_HELD}"] * changes
    return SampleTimes(
        time=found, rows=rows, steps=(*steps, *more), diagnostics=(*unsure, *doubts, *gaps), held=changes
    )


def has_times(recorded: Recorded) -> bool:
    """Return whether the times of the samples follow from the file alone."""
    with suppress(InputError):
        return sample_times(recorded).time.size > 1
    return False


def needs_unit(column: DataColumn) -> bool:
    """Return whether a column of times may count any unit, which the file does not state, such as days of a spreadsheet."""
    if column.unit:
        return False
    known = column.values[np.isfinite(column.values)]
    far = known.size > 1 and abs(known[0]) > _FAR * abs(known[-1] - known[0])
    return bool(far or _STAMP.search(column.name) or HAS_POWER.search(column.name))


def clocks_of(recorded: Recorded, columns: Sequence[str]) -> dict[ChannelClock, list[str]]:
    """Return each clock of the columns, with the columns that it is of; times that are equal are one clock."""
    common = ChannelClock(time=recorded.time, step=recorded.step, start=recorded.start)
    found: dict[ChannelClock, list[str]] = {}
    for name in columns:
        own = recorded.clocks.get(name, common)
        alike = next((each for each in found if _is_equal(recorded, each, own)), own)
        found.setdefault(alike, []).append(name)
    return found or {common: []}


def _is_equal(recorded: Recorded, one: ChannelClock, two: ChannelClock) -> bool:
    """Return whether two clocks are one, or two columns of the same times."""
    if one == two or not (one.time and two.time):
        return one == two
    first, second = (column_of(recorded, each.time, option="time") for each in (one, two))
    return first.unit == second.unit and np.array_equal(first.values, second.values, equal_nan=True)


def _shared(recorded: Recorded, columns: Sequence[str]) -> ChannelClock:
    """Return the clock that the columns share, or refuse columns of several clocks."""
    first, *others = clocks = clocks_of(recorded, columns)
    if not others:
        return first
    listed = "; ".join(
        f"{', '.join(map(repr, names))}: {clock_words(recorded, each)}" for each, names in clocks.items()
    )
    onto = (
        " the later ones are put onto the first with --set with=FIRST.nc --set clock_shift='0 s' (merge_traces(first, later,"
        " shift=0) in Python)."
    )
    apart = " their records do not overlap."
    raise InputError(
        f"columns: they have {len(clocks)} clocks ({listed}). Import those of each clock by themselves;"
        f"{onto if all(overlap(recorded, first, each) for each in others) else apart} If all have the same times, state them"
        " with time or step"
    )


def _others(recorded: Recorded, columns: Sequence[str], stated: ChannelClock) -> list[Diagnostic]:
    """Say which columns have other times in the file than those that were stated."""
    found = []
    for clock, names in clocks_of(recorded, columns).items():
        if (clock.time or clock.step) and not _is_equal(recorded, clock, stated) and names:
            text = f"the times '{stated.time}' were stated; in the file {', '.join(map(repr, names))} have another clock, "
            found.append(Diagnostic("clock", "warning", text + clock_words(recorded, clock)))
    return found


def span_of(recorded: Recorded, clock: ChannelClock) -> tuple[float, float, float] | None:
    """Return the first and the last time of a clock, and its usual step [s]; None if it is not known."""
    if not clock.time:
        if clock.step is None:
            return None
        return clock.start, clock.start + clock.step * (recorded.size - 1), clock.step
    column = column_of(recorded, clock.time, option="time")
    known = kind_and_factor(column.unit or "s")
    times = column.values[np.isfinite(column.values)] * (known[1] if known else 1.0)
    return (float(times[0]), float(times[-1]), float(np.median(np.diff(times)))) if times.size > 1 else None


def overlap(recorded: Recorded, one: ChannelClock, two: ChannelClock) -> bool:
    """Return whether the times of two clocks have a span in common."""
    spans = span_of(recorded, one), span_of(recorded, two)
    return None not in spans and max(each[0] for each in spans if each) < min(
        each[1] for each in spans if each
    )


def clock_words(recorded: Recorded, clock: ChannelClock) -> str:
    """Write start, end and step of a clock."""
    name = f"column '{clock.time}' " if clock.time else ""
    if (span := span_of(recorded, clock)) is None:
        return f"{name}without times"
    first, last, every = (format_quantity(each, "s", digits=6) for each in span)
    return f"{name}from {first} to {last} in steps of {every}"


def contradicted(recorded: Recorded) -> bool:
    """Return whether the file states times, and a step that is not theirs."""
    span = span_of(recorded, ChannelClock(time=recorded.time)) if recorded.time else None
    return span is not None and recorded.step is not None and not _agree(span[2], recorded.step)


def _agree(usual: float, step: float) -> bool:
    return abs(usual - step) <= _AGREE * step


def _refuse_other_step(name: str, time: Real, step: float) -> None:
    """Refuse times that contradict the time step that the file states too."""
    usual = float(np.median(np.diff(time)))
    if not _agree(usual, step):
        own, stated = (format_quantity(each, "s", digits=6) for each in (usual, step))
        raise InputError(
            f"time: the column '{name}' has steps of {own}, but the file states a time step of {stated}; state which one is"
            f" right: time = '{name}' (--set time=\"{name}\") or step = '{stated}' (--set step=\"{stated}\")"
        )


def _even(size: int, step: float, start: float, whence: str) -> SampleTimes:
    """Return even times."""
    if not np.isfinite(step) or step <= 0:
        raise InputError(f"step = {step}: expected a time above 0, such as '10 us'")
    return SampleTimes(
        time=np.asarray(start + step * np.arange(size), dtype=float),
        rows=_ALL,
        steps=(f"time: step of {format_quantity(step, 's')}, {whence}",),
        diagnostics=(Diagnostic("dropped samples", "unknown", _NO_STAMPS),),
    )


def _increasing(time: Real, stamps: str) -> tuple[Real, Rows, list[str], tuple[Diagnostic, ...]]:
    """Return increasing times with the numbers of their samples, the steps that this took, and what may be wrong."""
    if time.size > 1 and _steps(time)[0] > 0 and np.isfinite(time[[0, -1]]).all():
        return time, _ALL, [], ()
    rows = np.flatnonzero(np.isfinite(time))
    lost = time.size - rows.size
    steps = [f"time: {lost} samples without a time stamp omitted"] if lost else []
    kept = time[rows]
    if kept.size < 2:
        raise InputError("time: fewer than two samples have a time stamp")
    change = np.diff(kept)
    if (change > 0).all():
        return kept, rows, steps, ()
    if (change >= 0).all():
        try:
            even, words, doubts = even_times(kept)
        except InputError:
            if stamps == "refuse" and np.count_nonzero(change) < change.size / 2:
                raise
        else:
            return even, rows, [*steps, words], doubts
    if len(parts := segments_of(kept)) > 1:
        raise InputError(
            f"time: the stamps turn back to their beginning {len(parts) - 1} times, first at sample {rows[parts[1].start]}:"
            " there are several records; choose one with part (--set part='segment 1'), or write each into a file"
        )
    best = np.concatenate([[-np.inf], np.maximum.accumulate(kept)[:-1]])
    good = kept > best
    if stamps == "refuse":
        bad, first = int(np.count_nonzero(~good)), int(rows[int(np.argmin(good))])
        raise InputError(
            f"time: {bad} time stamps do not increase, the first at sample {first}; stamps = 'keep_increasing'"
            " (--set stamps=keep_increasing) drops such samples"
        )
    steps.append(f"time: {int(np.count_nonzero(~good))} samples whose time stamp does not increase dropped")
    return kept[good], rows[good], steps, ()


def _steps(time: Real) -> tuple[float, float]:
    """Return the shortest and the longest step of times, in blocks that fit into the cache; NaN where one is no number."""
    blocks = (np.diff(time[at : at + _BLOCK + 1]) for at in range(0, time.size - 1, _BLOCK))
    ends = np.array([(each.min(), each.max()) for each in blocks])
    return float(ends[:, 0].min()), float(ends[:, 1].max())


def _gaps(time: Real) -> tuple[Diagnostic, ...]:
    """State how many samples are missing between others."""
    if time.size < 3:
        return ()
    even = (Diagnostic("dropped samples", "ok", "no interval exceeds 1.5 times the median interval"),)
    shortest, longest = _steps(time)
    if longest <= _GAP * shortest:
        return even
    change = np.diff(time)
    usual = float(np.median(change))
    wide = change > _GAP * usual
    if not wide.any():
        return even
    times = change[wide] / usual
    odd = np.mean(np.abs(times - np.round(times)) > _OFF) > 0.5
    if np.mean(wide) > _MOST_GAPS or (odd and np.mean(wide) > _FEW_GAPS):
        ends = " to ".join(format_quantity(each, "s", digits=3) for each in (shortest, longest))
        text = (
            f"the samples are not evenly spaced (intervals of {ends}), so dropped samples cannot be noticed"
        )
        return (Diagnostic("dropped samples", "unknown", text),)
    lost = float(np.sum(np.round(times) - 1))  # infinite where a damaged file overflows
    where = format_quantity(float(time[:-1][wide][0]), "s", digits=4)
    return (
        Diagnostic(
            "dropped samples", "warning",
            f"about {lost:.15g} samples are missing in {int(wide.sum())} intervals longer than 1.5 times the median, the first"
            f" after {where}", lost, 0.0, "1",
        ),
    )  # fmt: skip


_STATE: Final = "state the step (--set step='10 us')"
_UNEVEN: Final = 1.5
"""Largest interval of stamps over the smallest one up to which both are one step, rounded."""
_ROUNDING: Final = 1e-6
"""Error of a stamp, in units of the step of the stamps, that is its rounding."""


def even_times(stamps: Real) -> tuple[Real, str, tuple[Diagnostic, ...]]:
    """Return even times [s] that explain stamps which repeat: each is its time, cut off at the step of the stamps.

    With them are the sentence that says how they were found, and what may be wrong with them. A first or a
    last stamp with fewer rows than the others does not change the step. Stamps that no even step explains are
    refused.
    """
    change = np.diff(stamps)
    first = np.flatnonzero(np.concatenate([[True], change > 0]))
    last = np.concatenate([first[1:] - 1, [stamps.size - 1]])
    values, rows = stamps[first], np.diff(np.append(first, stamps.size))
    if rows.size < 3:
        raise InputError(f"time: all samples have {rows.size} time stamps, too few for a time step; {_STATE}")
    least, most = float(change[change > 0].min()), float(change.max())
    resolution = 2 * most - least if most < _UNEVEN * least else least
    words = format_quantity(least, "s", digits=3)

    def room(step: float) -> float:
        """Return by how much the time of the first sample is free if the samples have this step, below 0 if none fits."""
        return float(np.min(values + resolution - step * last) - np.max(values - step * first))

    allowed = -_ROUNDING * resolution
    inner = rows[1:-1]
    step = least / round(float(np.median(inner)))
    if most > least * (1 + _ROUNDING) or room(step) <= allowed:
        from scipy.optimize import minimize_scalar

        about = float(values[-1] - values[1]) / float(first[-1] - first[1])
        near = 2 * resolution / stamps.size
        found = minimize_scalar(
            lambda each: -room(each),
            bounds=(about - near, about + near),
            method="bounded",
            options={"xatol": 1e-9 * about},
        )
        step = float(found.x)
    if room(step) <= allowed:
        apart = format_quantity(most, "s", digits=3)
        raise InputError(
            f"time: the stamps are cut off at {words} and repeat, with {rows.min()} to {rows.max()} rows each and up to {apart}"
            " between them: no even step explains them, samples are missing or were not taken evenly; cut the file where it"
            f" pauses, or {_STATE}"
        )
    start = float(np.max(values - step * first))
    often = " to ".join(str(each) for each in sorted({inner.min(), inner.max()}))
    text = (
        f"time: the stamps are cut off at {words} and repeat, {often} times each; replaced by"
        f" {stamps.size} even times in steps of {format_quantity(step, 's')}"
    )
    time = np.asarray(start + step * np.arange(stamps.size), dtype=float)
    if inner.min() == inner.max():
        return time, text, ()
    why = f"the number of rows for each time stamp varies from {often}: a sample may be missing"
    return time, text, (Diagnostic("rows of a time stamp", "unknown", why),)
