"""Times of rows that a text states as date and time of day: a column of moments, or a date and a clock beside each other."""

from __future__ import annotations

import dataclasses
import io
import re
from datetime import date
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.data.recorded import DataColumn, Recorded, unique
from electrovib.data.text.layout import Layout, split

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real


_DAY: Final = 86400.0
_CLOCK: Final = (
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2}(?:[.,]\d{1,9})?)(?::\d{1,9})?)?"
    r"\s?(?P<half>[AaPp]\.?[Mm]\.?)?\s?(?:Z|UTC|GMT|[+-]\d{2}:?\d{2})?"
)
_DATE: Final = r"(?P<a>\d{1,4})(?P<sign>[-/.])(?P<b>\d{1,2})[-/.](?P<c>\d{1,4})"
_BOTH: Final = re.compile(rf"{_DATE}[T ,]+{_CLOCK}", re.ASCII)
_ONLY_CLOCK: Final = re.compile(_CLOCK, re.ASCII)
_ONLY_DATE: Final = re.compile(_DATE, re.ASCII)
_LONGEST: Final = 48
_MOST_DAYS: Final = 10_000


def stamp_columns(layout: Layout, lines: Sequence[str]) -> tuple[int, ...]:
    """Return the columns of a text that hold date and time of a row: one, or one of each; empty if there is none."""
    rows = [split(line, layout.delimiter) for line in lines[layout.first :] if line.strip()]
    rows = [row for row in rows if len(row) > layout.columns[-1]]
    kinds = {
        at: kind_of([row[at] for row in rows if at < len(row)])
        for at in range(layout.width)
        if at not in layout.columns
    }
    moments = [at for at, kind in kinds.items() if kind == "moments"]
    clocks = [at for at, kind in kinds.items() if kind == "clock"]
    dates = [at for at, kind in kinds.items() if kind == "dates"]
    if moments or not clocks:
        return tuple(moments[:1])
    return (*dates[:1], clocks[0])


def with_stamps(recorded: Recorded, stamps: str) -> Recorded:
    """Return the content of a text with the channel ``time`` [s] from the first row; unchanged if times do not increase."""
    time, order = seconds_from_first(stamps)
    known = time[np.isfinite(time)]
    if known.size < 2 or not (np.diff(known) >= 0).all() or known[0] == known[-1]:
        return recorded
    name = unique("time", recorded.channels)
    about = {"first_time": stamps.partition("\n")[0][:_LONGEST]} | ({"date_order": order} if order else {})
    return dataclasses.replace(
        recorded,
        channels=(DataColumn(name=name, unit="s", values=time), *recorded.channels),
        time=name,
        attributes={**recorded.attributes, **about},
    )


def kind_of(cells: Sequence[str]) -> str:
    """Return what the fields of a column are: ``"moments"`` (date and time), ``"clock"``, ``"dates"``, or nothing."""
    forms = {"moments": _BOTH, "clock": _ONLY_CLOCK, "dates": _ONLY_DATE}
    for kind, form in forms.items():
        if cells and all(len(cell) <= _LONGEST and form.fullmatch(cell) for cell in cells):
            return kind
    return ""


def seconds_from_first(text: str) -> tuple[Real, str]:
    """Return the times [s] after the first line that holds a time of day, and the order of the date if it was assumed.

    A line without a time is NaN. A clock without a date that goes back by more than half a day has passed
    midnight.
    """
    day_first, order, dated = _day_first(text)
    lines = (line.rstrip("\n")[:_LONGEST] for line in io.StringIO(text))
    time = np.fromiter((_moment(line, day_first=day_first) for line in lines), dtype=float)
    known = np.flatnonzero(np.isfinite(time))
    if not dated:
        time[known[1:]] += _DAY * np.cumsum(np.diff(time[known]) < -_DAY / 2)
    return time - time[known[0]] if known.size else time, order


def _day_first(text: str) -> tuple[bool, str, bool]:
    """Return whether the day stands before the month, the order where that is an assumption, and whether there are dates."""
    dated, days, signs = False, set[tuple[str, str]](), set[str]()
    for line in io.StringIO(text):
        match = _ONLY_DATE.match(line)
        dated = dated or match is not None
        if match is not None and len(match["a"]) < 3 and len(days) < _MOST_DAYS:
            days.add((match["a"], match["b"]))
            signs.add(match["sign"])
    if any(int(second) > 12 for _, second in days):
        return False, "", dated
    if any(int(first) > 12 for first, _ in days):
        return True, "", dated
    if len(days) < 2:
        return False, "", dated  # one date, so that its order does not matter
    return (True, "day.month", dated) if "." in signs else (False, "month/day", dated)


def _moment(line: str, *, day_first: bool) -> float:
    """Return the seconds of a moment since the beginning of the calendar, or of a clock since midnight; NaN if it is neither."""
    match = _BOTH.fullmatch(line) or _ONLY_CLOCK.fullmatch(line)
    if match is None:
        return np.nan
    hour = int(match["hour"])
    if match["half"]:
        hour = hour % 12 + 12 * (match["half"][0] in "Pp")
    seconds = 3600 * hour + 60 * int(match["minute"]) + float((match["second"] or "0").replace(",", "."))
    if "a" not in match.re.groupindex:
        return seconds
    a, b, c = (int(match[name]) for name in "abc")
    year, month, day = (a, b, c) if len(match["a"]) > 2 else (c, b, a) if day_first else (c, a, b)
    try:
        return date(year, month, day).toordinal() * _DAY + seconds
    except ValueError:
        return np.nan
