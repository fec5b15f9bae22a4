"""Times of rows that a text states as date and time of day, as a clock, or as a duration: seconds from the first row.

The form of a column is found once and pandas reads it, as whole nanoseconds.
"""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.data.recorded import DataColumn, NotRead, Recorded, unique
from electrovib.data.text.layout import Layout, split
from electrovib.data.text.preamble import keeps_step, without_doubt

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any, TypeAlias

    import pandas as pd

    from electrovib.core.arrays import Real

    Whole: TypeAlias = np.ndarray[tuple[int], np.dtype[np.int64]]

_DATE: Final = r"(?P<a>\d{1,4}|[A-Za-z]{3})(?P<sign>[-/. ])(?P<b>\d{1,2}|[A-Za-z]{3})(?P<end>[-/. ]|, )(?P<c>\d{4}|\d{1,2})"
_CLOCK: Final = (
    r"(?P<hour>\d{1,4}):(?P<minute>\d{2})(?P<second>:\d{1,2})?(?P<decimals>\.\d{1,9})?(?P<half> ?[AP]M)?"
    r"(?P<zone> ?(?:Z|[+-]\d{2}:?\d{2}))?"
)
_FORMS: Final = {
    "moments": re.compile(rf"{_DATE}(?P<between>T|, ?| )\s*{_CLOCK}", re.ASCII),
    "clock": re.compile(_CLOCK, re.ASCII),
    "dates": re.compile(_DATE, re.ASCII),
    "spans": re.compile(
        r"-?\d+ days?(?:,? [+-]?\d{1,2}:\d{2}:\d{2}(?:\.\d{1,9})?)?|-?P\d\w*T[\d.HM]+S", re.ASCII
    ),
}
_PLAIN: Final = (
    (re.compile(r"^\s+|\s+$"), ""),
    (re.compile(r"(?<=\d),(?=\d+(?!\d|:|[-/.]\d))"), "."),
    (re.compile(r"(?<=:\d\d):(?=\d{3}(?!\d))"), "."),  # milliseconds behind a colon
    (re.compile(r"(?<=\d) ?[Aa]\.?[Mm]\b\.?"), " AM"),
    (re.compile(r"(?<=\d) ?[Pp]\.?[Mm]\b\.?"), " PM"),
    (re.compile(r"(?<=\d) ?(?:UTC|GMT)\b"), "Z"),
)
"""What is written otherwise, and how pandas reads it."""
_LONGEST: Final = 48
_MOST_FORMATS: Final = 50
_INSPECTED: Final = 400
_KNOWN: Final = 0.75
"""Smallest share of the fields of a column of stamps that are one; the others are missing."""
_DAY: Final = 86_400_000_000_000
_HOUR: Final = _DAY // 24
_NANOSECONDS: Final = 1e9
_NONE: Final = np.iinfo(np.int64).min
"""No stamp, as pandas and numpy store it."""
_MINUTES: Final = re.compile(r"(?<!:)\bm{1,2}(in)?:s", re.IGNORECASE)
_HOURS: Final = re.compile(r"\bh{1,2}:m", re.IGNORECASE)
_FRACTION: Final = re.compile(r"(?P<ms>ms|milli.*)|(?P<us>[uµμ]s|micro.*)|(?P<ns>ns|nano.*)", re.IGNORECASE)
"""Heading of a column that holds the decimals of stamps of whole seconds."""


def stamp_columns(layout: Layout, lines: Sequence[str]) -> tuple[int, ...]:
    """Return the columns of a text that hold date and time of a row: one, or one of each; empty if there is none."""
    rows = [split(line, layout.delimiter) for line in lines[layout.first :] if line.strip()]
    rows = [row for row in rows if len(row) > layout.columns[-1]]
    kinds = {
        at: kind_of([row[at] for row in rows if at < len(row)])
        for at in range(layout.width)
        if at not in layout.columns
    }
    dates, clocks, moments, spans = (
        [at for at, kind in kinds.items() if kind == wanted]
        for wanted in ("dates", "clock", "moments", "spans")
    )
    whole = moments or spans
    return tuple(whole[:1]) if whole else (*dates[:1], *clocks[:1])


def kind_of(cells: Sequence[str]) -> str:
    """Return what the fields of a column are: one of `_FORMS`; empty if they are none of them."""
    import pandas as pd

    filled = _plain(pd.Series([cell[: _LONGEST + 1] for cell in cells if cell], dtype=str))
    for kind, form in _FORMS.items():
        if filled.size and filled.str.fullmatch(form).mean() >= _KNOWN:
            return kind
    return ""


def _plain(cells: pd.Series[str]) -> pd.Series[str]:
    """Write stamps as pandas reads them; what the first ones do not have is not looked for in the others."""
    for form, known in _PLAIN:
        if cells.iloc[:_INSPECTED].str.contains(form).any():
            cells = cells.str.replace(form, known, regex=True)
    return cells


def with_stamps(recorded: Recorded, stamps: pd.Series[str], heading: str = "") -> Recorded:
    """Return the content of a text with the channel ``time`` [s] of its stamps, one a row; else they are named as not read.

    Where the file states another time step than the stamps have, both are in the record.
    """
    time, order, why = np.empty(0), "", ""
    try:
        time, order = seconds_from_first(stamps, heading)
    except ValueError as error:
        why = str(error)
    column = DataColumn(name=unique("time", recorded.channels), unit="s", values=time)
    known, shown = time[np.isfinite(time)], stamps.iloc[0][:_LONGEST]
    decimals = _decimals_of(recorded, time) if known.size == len(recorded.channels[0].values) else None
    if not why and known.size < 2:
        why = f"no date or time is recognised in '{shown}'"
    elif known.size and (known == known[0]).all():
        why = f"'{shown}' in all rows"
    elif (
        decimals is None and recorded.time and not recorded.time.startswith("column ")
    ):  # without a heading it may be anything
        why = f"stamps; the times are those of column '{recorded.time}'"
    elif recorded.step is not None and keeps_step(column, recorded.step):
        why = "stamps; the times follow from the step that the file states"
    if why:
        unread = NotRead(name=heading or "date and time", why=why)
        return dataclasses.replace(recorded, not_read=(*recorded.not_read, unread))
    about = {"first_time": shown}
    if order:
        about |= {"date_order": order, "unsure": f"the order of the dates such as '{shown}', read as {order}"}
    if decimals is not None:
        column = dataclasses.replace(column, values=time + decimals - decimals[0])
    return dataclasses.replace(
        recorded,
        channels=(column, *recorded.channels),
        time=column.name,
        attributes=without_doubt(recorded) | about,
    )


def _decimals_of(recorded: Recorded, time: Real) -> Real | None:
    """Return the column of the decimals [s] of stamps of whole seconds; None if there is none."""
    if not (np.diff(time) == 0).any() or not (time == np.round(time)).all():
        return None
    for channel in recorded.channels:
        match = _FRACTION.fullmatch(channel.unit or channel.name)
        if match is None or match.lastgroup is None:
            continue
        per_second = {"ms": 1e3, "us": 1e6, "ns": 1e9}[match.lastgroup]
        part = np.asarray(channel.values / per_second)  # noqa: PD011
        if ((part >= 0) & (part < 1)).all() and (np.diff(time + part) > 0).all():
            return part
    return None


def seconds_from_first(stamps: Sequence[str] | pd.Series[str], heading: str = "") -> tuple[Real, str]:
    """Return the times [s] after the first field that is a stamp, and the order of the date if it was assumed.

    A field without a stamp is NaN; a duration is counted from 0. A clock without a date that goes back by
    more than half a day has passed midnight, one of minutes and seconds the full hour. Stamps that have
    two readings are a ValueError.
    """
    import pandas as pd

    cells = _plain(pd.Series(stamps, dtype=str))
    kind, order = kind_of(cells.iloc[:_INSPECTED]), ""
    if kind == "spans":
        found = _whole(pd.to_timedelta(cells, errors="coerce"))
    elif kind == "clock" and not cells.str.endswith("M").any():
        found = _whole(pd.to_timedelta(_with_hours(cells, heading), errors="coerce"))
    else:
        found, order = _moments("2000-01-01 " + cells if kind == "clock" else cells)
    known = np.flatnonzero(found != _NONE)
    if kind == "clock":
        turn = _DAY if cells.str.count(":").max() > 1 or not (found[known] < _HOUR).all() else _HOUR
        far = turn // 2 if turn == _DAY else turn // 10 * 9
        found[known[1:]] += turn * np.cumsum(np.diff(found[known]) < -far)
    first = found[known[0]] if known.size and kind != "spans" else 0
    return np.where(found != _NONE, (found - first) / _NANOSECONDS, np.nan), order


def _whole(stamps: pd.Series[Any]) -> Whole:
    """Return stamps of pandas as whole nanoseconds, `_NONE` where there is none."""
    return np.array(stamps.dt.as_unit("ns").to_numpy().view(np.int64), dtype=np.int64)


def _with_hours(cells: pd.Series[str], heading: str) -> pd.Series[str]:
    """Return clocks as h:mm:ss; those of two numbers are minutes and seconds, or hours and minutes."""
    import pandas as pd

    short = cells.str.count(":") == 1
    cells = cells.str.replace(r" ?(Z|[+-]\d{2}:?\d{2})$", "", regex=True)
    if not short.any():
        return cells
    minutes = not short.all() or cells.str.contains(".", regex=False).any()
    minutes |= bool((pd.to_numeric(cells.str.partition(":")[0], errors="coerce") > 23).any())
    if _MINUTES.search(heading) or minutes:
        return cells.where(~short, "00:" + cells)
    if _HOURS.search(heading):
        return cells + ":00"
    raise ValueError(
        f"'{cells.iloc[0]}' may be hours and minutes or minutes and seconds; write [hh:mm] or [mm:ss] behind the heading"
    )


def _moments(cells: pd.Series[str]) -> tuple[Whole, str]:
    """Read dates and times in the order that explains most rows; of several the one of the shortest record, which is named."""
    sample = next((cell for cell in cells if _format_of(cell, "dmy")), "")
    names = {"month/day": "mdy", "day.month": "dmy", "year/month/day": "ymd"}
    orders = {
        _format_of(sample, order): name for name, order in names.items()
    }  # one form where it shows the order
    found = {name: _in_order(cells, names[name]) for name in orders.values()}
    known = {name: np.count_nonzero(read != _NONE) for name, read in found.items()}
    most = max(known.values())
    spans = {
        name: np.ptp(read[read != _NONE]) for name, read in found.items() if most and known[name] == most
    }
    usual = "day.month" if "." in sample.partition(" ")[0] else "month/day"
    chosen = min(spans, key=lambda name: (spans[name], name != usual), default="month/day")
    return found.get(chosen, np.full(cells.size, _NONE)), chosen if len({*spans.values()}) > 1 else ""


def _in_order(cells: pd.Series[str], order: str) -> Whole:
    """Read dates and times whose date has this order, unless its form shows another one."""
    import pandas as pd

    found = np.full(cells.size, _NONE)
    left = np.arange(cells.size)
    for _ in range(_MOST_FORMATS):  # programs write 10:00:00 between 09:59:59.5 and 10:00:00.5
        if not left.size:
            break
        first = left[0]
        if form := _format_of(cells.iloc[first], order):
            read = pd.to_datetime(cells.iloc[left], format=form, utc=True, errors="coerce")
            found[left] = _whole(read.dt.tz_localize(None))
        left = left[(found[left] == _NONE) & (left != first)]
    return found


def _format_of(cell: str, order: str) -> str:
    """Return the format of a date with or without a clock as pandas expects it; empty if it is none."""
    match = _FORMS["moments"].fullmatch(cell) or _FORMS["dates"].fullmatch(cell)
    if match is None:
        return ""
    known = match.groupdict(default="")
    if len(known["a"]) == 4:
        order = "ymd"
    elif known["a"].isalpha() or known["b"].isalpha():
        order = "mdy" if known["a"].isalpha() else "dmy"
    year = "%Y" if max(map(len, (known["a"], known["c"]))) == 4 else "%y"
    month = "%b" if (known["a"] + known["b"])[-1].isalpha() or known["a"].isalpha() else "%m"
    a, b, c = ({"d": "%d", "m": month, "y": year}[letter] for letter in order)
    date = f"{a}{known['sign']}{b}{known['end']}{c}"
    if "hour" not in known:
        return date
    clock = "%I:%M" if known["half"] else "%H:%M"
    clock += ":%S" * bool(known["second"]) + ".%f" * bool(known["decimals"])
    clock += " %p" * bool(known["half"]) + " " * known["zone"].startswith(" ") + "%z" * bool(known["zone"])
    return f"{date}{known['between']}{clock}"
