"""Text of any instrument: CSV and TSV with a preamble, a row of units, decimal commas, or a time step instead of a column."""

from __future__ import annotations

import dataclasses
import io
import itertools
import re
from datetime import date
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.core.units import parse_quantity
from electrovib.data.recorded import CanRead, DataColumn, FileFormat, Recorded, unique
from electrovib.data.text.layout import (
    INSPECTED,
    MISSING,
    Layout,
    check_width,
    encoding_of,
    find_layout,
    is_number,
    lines_of,
    split,
)
from electrovib.data.text.table import one_table, read_columns, repeated_table
from electrovib.data.unit_words import as_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

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


_STEP: Final = frozenset({
    "increment", "sample interval", "sampleinterval", "sampling interval", "xincr", "x increment", "xincrement", "dt",
    "tinc", "t inc", "time step", "timestep", "sampling period", "sample period", "xinc", "horizontal interval",
    "time interval", "resolution", "interval", "delta x", "hresolution", "clock",
})  # fmt: skip
_RATE: Final = frozenset(
    {"sample rate", "samplerate", "sampling rate", "sampling frequency", "sample frequency", "fs"}
)
_START: Final = frozenset(
    {"start", "xzero", "x zero", "xorg", "xorigin", "t0", "x0", "start time", "first sample", "hoffset"}
)
_TIMING: Final = _STEP | _START
_SECONDS: Final = re.compile(r"(?<=[\d. munµp])([munµp]?)S\b")
"""A second that is written as S, as some oscilloscopes do."""
_LONGEST_SETTING: Final = 200
_MOST_SETTINGS: Final = 200
_NAMES: Final = frozenset({"tracename", "channeltitle", "channel title", "channel name", "channel names"})
_UNITS: Final = frozenset({"vertical units", "vunit", "y unit label", "units", "unit", "yunits"})
_ACROSS: Final = ("horizontal units", "hunit", "xunits")
_TIME_HEADINGS: Final = ("", "time", "t", "x_value", "x value")
_CHANNEL: Final = re.compile(r"[A-Za-z]+\s?\d*\s*:\s*")
_COUNTS: Final = frozenset(
    {"sequence", "index", "nr", "no", "pt", "point", "points", "point #", "sample", "samples", "#", "n"}
)
_TIMES: Final = re.compile(
    r"(elapsed |trigger )?time\b.*|t|zeit|x-axis|x[_ ]?value|x|seconds?|source", re.IGNORECASE
)
FREQUENCY: Final = re.compile(r"freq|hz|hertz|omega", re.IGNORECASE)


def settings_of(layout: Layout) -> dict[str, str]:
    """Collect the settings of the preamble: a key with its value beside it, or below it in headings."""
    found: dict[str, str] = {}
    for row in layout.preamble[:_MOST_SETTINGS]:
        filled = [cell.strip().lstrip("#").strip() for cell in row if cell.strip()]
        if len(filled) == 1 and (sign := next((sign for sign in ":=" if sign in filled[0]), "")):
            filled = [part.strip() for part in filled[0].split(sign, 1)]
        if len(filled) >= 2 and not _looks_like_number(filled[0]):
            found.setdefault(
                filled[0].rstrip(" :=")[:_LONGEST_SETTING], ", ".join(filled[1:])[:_LONGEST_SETTING]
            )
    for above, below in itertools.pairwise(layout.preamble):
        pairs = zip(above, below, strict=False)
        found |= {
            name: value for name, value in pairs if name.lower() in _TIMING and _looks_like_number(value)
        }
    return found


def _looks_like_number(text: str) -> bool:
    return is_number(text, decimal_comma=False) or is_number(text, decimal_comma=True)


def timing(layout: Layout, settings: Mapping[str, str]) -> tuple[float | None, float]:
    """Find the time step [s], None if it is not stated, and the first time [s], 0 if it is not stated, in the preamble."""
    step: float | None = None
    start = 0.0
    for key, value in settings.items():
        name = re.sub(r"[\[(].*?[\])]", "", key).strip().lower().replace("_", " ")
        unit = (re.search(r"[\[(](.*?)[\])]", key) or [None, ""])[1] or ""
        if name in _STEP:
            step = _seconds(value, unit, layout) or step
        elif name in _RATE and (rate := _hertz(value, unit, layout)):
            step = 1 / rate
        elif name in _START:
            start = _seconds(value, unit, layout) or start
    return step, start


def _seconds(value: str, unit: str, layout: Layout) -> float | None:
    return _quantity(_SECONDS.sub(r"\1s", value.removeprefix("Analog:")), unit, "s", layout)


def _hertz(value: str, unit: str, layout: Layout) -> float | None:
    return _quantity(re.sub(r"S(a|ample)?(/s|ps)$", "Hz", value.partition(", ")[0]), unit, "Hz", layout)


def _quantity(value: str, unit: str, kind: str, layout: Layout) -> float | None:
    """Read '1.0E-6', '2,0 us', or '1 us' with its unit in the key; None if it is no such quantity."""
    text = value.partition(", ")[0].strip()
    if layout.decimal_comma:
        text = text.replace(",", ".")
    for candidate in (f"{text} {unit}" if unit else text, f"{text} {kind}", text):
        try:
            found = parse_quantity(candidate, kind)
        except ValueError:
            continue
        return float(found)
    return None


def named_by_preamble(layout: Layout, settings: Mapping[str, str]) -> Layout:
    """Return a layout with the names and units that rows such as ``Vertical Units,V,A`` or ``TraceName,CH1,CH2`` state."""
    names, units = list(layout.names), list(layout.units)
    rows = {_key_of(row[0]): row for row in layout.preamble if row and row[0].strip()}
    for key, row in rows.items():
        for place, column in enumerate(layout.columns):
            cell = row[column].strip() if 0 < column < len(row) else ""
            if key in _NAMES and cell:
                names[place] = cell
            elif key in _UNITS and cell and not units[place]:
                units[place] = as_unit(_CHANNEL.sub("", cell, count=1)) or ""
    stated = {_key_of(name): value.partition(", ")[0] for name, value in settings.items()}
    across = next((as_unit(stated[key]) for key in _ACROSS if key in stated), None)
    if stated.get("x dimension", "").lower() == "time":  # LabVIEW writes seconds
        across = "s"
    if (
        across in ("s", "ms", "us", "ns")
        and len(names) > 1
        and not units[0]
        and names[0].lower() in _TIME_HEADINGS
    ):
        units[0] = across or ""
    if len(names) == 2 and not any(names) and "source" in stated:  # settings stand beside the numbers
        names = ["time", stated["source"]]
    upright = next((as_unit(stated[key]) for key in _UNITS if key in stated), None)
    if len(names) <= 2 and not units[-1] and upright:
        units[-1] = upright
    return dataclasses.replace(layout, names=tuple(names), units=tuple(units))


def _key_of(cell: str) -> str:
    return cell.strip().lstrip("#").rstrip(" :=").replace("_", " ").lower()


def counts(values: Real) -> bool:
    """Return whether a column numbers the samples."""
    return bool(np.array_equal(values, np.arange(values.size) + values[0]) and values[0] in (0, 1))


def is_index(layout: Layout, first: DataColumn) -> bool:
    """Return whether the first column numbers the rows: by its heading, or it counts and it alone has no heading."""
    if {first.name.lower().rstrip("."), first.unit.lower()} & _COUNTS:
        return True
    return counts(first.values) and not layout.names[0] and all(layout.names[1:])


def keeps_step(channel: DataColumn, step: float) -> bool:
    """Return whether a column increases by the time step that the preamble states, within 1 % of it on average."""
    values = channel.values
    even = (values.size - 1) * step
    return bool(np.isfinite(values).all() and abs(values[-1] - values[0] - even) <= 0.01 * abs(even))


def is_time(channel: DataColumn, step: float | None, *, first: bool) -> bool:
    """Return whether a column is the time: by name and unit, and the first column also by its rise."""
    rises = bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())
    named = bool(_TIMES.fullmatch(channel.name))
    if channel.unit in ("s", "ms", "us", "ns"):
        return (rises and (first or named)) or (first and named)
    if not rises or channel.unit or channel.values[0] == channel.values[-1]:
        return False
    if first and step is not None and keeps_step(channel, step):
        return True
    return (
        named and not (channel.name.lower() == "x" and not first)
        if not first
        else (named or channel.name.startswith("column "))
    )


_UNEVEN: Final = 2
_LONGEST_LINE: Final = 1_000_000


def read_laboratory_text(
    path: Path, *, delimiter: str | None = None, decimal_comma: bool | None = None, part: str = ""
) -> Recorded:
    """Read every column of numbers of a text file of an instrument, and the statements of its preamble.

    An empty `delimiter` stands for blanks. Of a file with several tables, as Gamry and VersaStudio write
    them, `part` names the table; by default it is the spectrum or the longest one.
    """
    raw, about = one_table(path, path.read_bytes(), part)
    if about and delimiter is None:
        delimiter = "\t" if b"\t" in raw else ","
    found = read_laboratory_bytes(
        path, raw, delimiter=delimiter, decimal_comma=decimal_comma, part="" if about else part
    )
    return dataclasses.replace(found, attributes={**found.attributes, **about})


def read_laboratory_bytes(
    path: Path,
    raw: bytes,
    *,
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    origin: str = "",
    part: str = "",
) -> Recorded:
    """Read the text of an instrument that is in memory; `origin` names the sheet that it comes from."""
    encoding = encoding_of(path, raw)
    first = list(itertools.islice(_lines(raw, encoding), INSPECTED))
    check_width(path, first)
    layout = find_layout(first, delimiter=delimiter, decimal_comma=decimal_comma)
    if layout is None:
        raise DataFileError(
            "holds no rows of numbers; if it does, state delimiter and decimal_comma (--set delimiter=...).",
            path=path,
        )
    raw, about = repeated_table(path, raw, layout, part)
    if about:
        first = list(itertools.islice(_lines(raw, encoding), INSPECTED))
        layout = find_layout(first, delimiter=layout.delimiter, decimal_comma=layout.decimal_comma) or layout
    elif part:
        raise DataFileError(
            f"part = {part}: the file does not consist of parts with names; omit it.", path=path
        )
    numbers, stamps = _numbers(path, raw, encoding, layout, stamp_columns(layout, first))
    settings = settings_of(layout) | ({"sheet": origin} if origin else {}) | about | _left_out(layout)
    step, start = timing(layout, settings)
    found = _recorded(layout, numbers, settings, step, start)
    return found if found.time or found.step is not None or not stamps else with_stamps(found, stamps)


def _left_out(layout: Layout) -> dict[str, str]:
    """State the rows at the beginning that hold words in place of numbers."""
    if not layout.left_out:
        return {}
    rows = "the first row" if layout.left_out == 1 else f"the first {layout.left_out} rows"
    return {"left_out": f"{rows} behind the headings, with words in place of numbers"}


def _lines(raw: bytes, encoding: str) -> Iterator[str]:
    return (line[:_LONGEST_LINE] for line in lines_of(raw, encoding))


def _numbers(
    path: Path, raw: bytes, encoding: str, layout: Layout, stamped: Sequence[int]
) -> tuple[Real, str]:
    """Read the columns of numbers, shape (rows, columns), and the dates and times of the rows; an empty field is no number."""
    stamps = io.StringIO()

    def rows() -> Iterator[str]:
        for number, line in enumerate(
            itertools.islice(_lines(raw, encoding), layout.first, None), layout.first + 1
        ):
            if not line.strip() or line.lstrip().startswith("#"):
                continue
            cells = split(line, layout.delimiter)
            if len(cells) <= layout.columns[-1]:
                if not any(is_number(cell, decimal_comma=layout.decimal_comma) for cell in cells):
                    continue  # a line of words between or behind the numbers
                raise DataFileError(
                    f"line {number} has {len(cells)} fields, fewer than the {layout.width} of the other rows: it is cut off,"
                    " or the delimiter is another one; state it.",
                    path=path,
                )
            if stamped:
                stamps.write(" ".join(cells[at] for at in stamped if at < len(cells)) + "\n")
            yield "\t".join(_plain(path, number, cells[at], layout) for at in layout.columns)

    found = np.loadtxt(rows(), delimiter="\t", comments=None, ndmin=2)
    if found.shape[0] < _UNEVEN:
        raise DataFileError("holds fewer than two rows of numbers.", path=path)
    return np.asarray(found, dtype=float), stamps.getvalue()


def _plain(path: Path, number: int, cell: str, layout: Layout) -> str:
    """Return a number with a decimal point; an empty field and stars become NaN."""
    if cell.lower() in MISSING:
        return "nan"
    if not is_number(cell, decimal_comma=layout.decimal_comma):
        sign = "point" if layout.decimal_comma else "comma"
        raise DataFileError(
            f"line {number}: '{cell[:40]}' is not a number; if decimals are written with a {sign}, state it.",
            path=path,
        )
    return (cell.replace(",", ".") if layout.decimal_comma else cell).replace("D", "E").replace("d", "e")


def _recorded(
    layout: Layout, numbers: Real, settings: dict[str, str], step: float | None, start: float
) -> Recorded:
    layout = named_by_preamble(layout, settings)
    channels: list[DataColumn] = []
    for place, column in enumerate(layout.columns):
        name = unique(layout.names[place] or f"column {column}", channels)
        channels.append(DataColumn(name=name, unit=layout.units[place], values=numbers[:, place]))
    time, is_count = "", is_index(layout, channels[0])
    counting = is_count or counts(channels[0].values)
    if (
        step is not None
        and (counting or layout.names[0].lower() == "x")
        and not keeps_step(channels[0], step)
    ):
        channels = channels[1:] or channels
    elif len(channels) > 1:
        frequency = any(FREQUENCY.match(each.name) for each in channels)
        candidates = channels[is_count:] if not frequency else []
        found = next((each for at, each in enumerate(candidates) if is_time(each, step, first=not at)), None)
        if found is not None:
            time, step = found.name, None
    return Recorded(channels=tuple(channels), time=time, step=step, start=start, attributes=settings)


def _can_read(head: bytes, suffix: str) -> CanRead:
    is_text = head.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" not in head
    return CanRead.PERHAPS if is_text or suffix in (".csv", ".tsv", ".txt") else CanRead.NO


FORMAT: Final = FileFormat(
    name="text",
    description="delimited text of any instrument (.csv, .tsv, .txt, .dat, .lvm, .dta, .mpt, .par)",
    can_read=_can_read,
    read=read_laboratory_text,
    columns=read_columns,
    options=("delimiter", "decimal_comma", "part"),
    is_last=True,
)
