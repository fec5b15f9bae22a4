"""Times of the samples of a file: from a column or a step, with dropped, repeated and rounded time stamps noticed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.importing.choice import column_of

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_GAP: Final = 1.5
"""Interval, in units of the median interval, from which on samples are missing."""
STAMPS: Final = ("refuse", "keep_increasing")
"""Treatments of time stamps that do not increase."""


@dataclass(frozen=True, kw_only=True)
class SampleTimes:
    """The times of the samples that are kept, increasing [s], with their numbers from 0 and one sentence for each step."""

    time: Real
    rows: np.ndarray[tuple[int], np.dtype[np.intp]]
    steps: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


def sample_times(
    recorded: Recorded, *, time: str = "", step: str | float | None = None, stamps: str = "refuse"
) -> SampleTimes:
    """Return the times of the samples of a file; a `step` [s] has priority over the file, `stamps` is one of `STAMPS`."""
    if stamps not in STAMPS:
        raise InputError(f"stamps = {stamps}: expected one of {', '.join(STAMPS)}")
    if step is not None and time:
        raise InputError("step: the time column is given too; omit one of the two")
    if step is not None or (not time and not recorded.time and recorded.step is not None):
        return _even(recorded, step)
    if not time and not recorded.time:
        raise InputError(
            "time: the file states neither times nor a time step; state the column with its unit, such as time ="
            f" '{recorded.channels[0].name} [s]', or a step such as '10 us'"
        )
    column = column_of(recorded, time or recorded.time, option="time")
    known = kind_and_factor(column.unit or "s")
    if known is None or known[0] != "s":
        raise InputError(f"time = {column.name}: '{column.unit}' is not a unit of time")
    steps = [f"time: column '{column.name}' [{column.unit or 's'}]"]
    unsure = []
    if not column.unit:
        unsure = [
            Diagnostic(
                "unit of time", "unknown", f"the file states no unit for '{column.name}'; s were assumed"
            )
        ]
    with np.errstate(all="ignore"):  # time stamps of a damaged file may overflow
        found, rows, more = _increasing(np.asarray(column.values * known[1]), stamps)
        gaps = _gaps(found)
    return SampleTimes(time=found, rows=rows, steps=(*steps, *more), diagnostics=(*unsure, *gaps))


def _even(recorded: Recorded, step: str | float | None) -> SampleTimes:
    """Return even times from a given step or that of the file."""
    every = recorded.step if step is None else float(step) if not isinstance(step, str) else 0.0
    start = recorded.start if step is None else 0.0
    if isinstance(step, str):
        try:
            every = parse_quantity(step, "s")
        except ValueError as error:
            raise InputError(f"step = {step}: {error}") from None
    if every is None or not np.isfinite(every) or every <= 0:
        raise InputError(
            f"step = {step if step is not None else every}: expected a time above 0, such as '10 us'"
        )
    whence = "as given" if step is not None else "as the file states"
    return SampleTimes(
        time=np.asarray(start + every * np.arange(recorded.size), dtype=float),
        rows=np.arange(recorded.size),
        steps=(f"time: step of {format_quantity(every, 's')}, {whence}",),
        diagnostics=(
            Diagnostic(
                "dropped samples",
                "unknown",
                "the file has no time stamps, so dropped samples cannot be noticed",
            ),
        ),
    )


def _increasing(time: Real, stamps: str) -> tuple[Real, np.ndarray[tuple[int], np.dtype[np.intp]], list[str]]:
    """Return increasing times with the numbers of their samples, and the steps that this took."""
    rows = np.flatnonzero(np.isfinite(time))
    steps = (
        [f"time: {time.size - rows.size} samples without a time stamp omitted"]
        if rows.size < time.size
        else []
    )
    kept = time[rows]
    if kept.size < 2:
        raise InputError("time: fewer than two samples have a time stamp")
    change = np.diff(kept)
    if (change > 0).all():
        return kept, rows, steps
    even = np.linspace(kept[0], kept[-1], kept.size)
    rounding = float(np.min(change[change > 0], initial=np.inf))
    if (change >= 0).all() and np.isfinite(rounding) and np.abs(kept - even).max() <= rounding:
        steps.append(
            f"time: the stamps are rounded to {format_quantity(rounding, 's', digits=3)} and repeat; replaced by"
            f" {kept.size} even times between the first and the last"
        )
        return even, rows, steps
    best = np.concatenate([[-np.inf], np.maximum.accumulate(kept)[:-1]])
    good = kept > best
    if stamps == "refuse":
        bad, first = int(np.count_nonzero(~good)), int(rows[int(np.argmin(good))])
        raise InputError(
            f"time: {bad} time stamps do not increase, the first at sample {first}; stamps = 'keep_increasing'"
            " (--set stamps=keep_increasing) drops such samples"
        )
    steps.append(f"time: {int(np.count_nonzero(~good))} samples whose time stamp does not increase dropped")
    return kept[good], rows[good], steps


def _gaps(time: Real) -> tuple[Diagnostic, ...]:
    """State how many samples are missing between others."""
    if time.size < 3:
        return ()
    change = np.diff(time)
    usual = float(np.median(change))
    wide = change > _GAP * usual
    lost = int(np.sum(np.round(change[wide] / usual) - 1)) if wide.any() else 0
    if not lost:
        return (Diagnostic("dropped samples", "ok", "no interval exceeds 1.5 times the median interval"),)
    where = format_quantity(float(time[:-1][wide][0]), "s", digits=4)
    return (
        Diagnostic(
            "dropped samples", "warning",
            f"about {lost} samples are missing in {int(wide.sum())} intervals longer than 1.5 times the median, the first"
            f" after {where}", float(lost), 0.0, "1",
        ),
    )  # fmt: skip
