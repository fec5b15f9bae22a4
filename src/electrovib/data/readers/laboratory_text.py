"""Text of any instrument: CSV and TSV with a preamble, a row of units, decimal commas, or a time step instead of a column."""

from __future__ import annotations

import io
import itertools
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.core.units import parse_quantity
from electrovib.data.columns.faults import check_file
from electrovib.data.readers.layout import INSPECTED, Layout, find_layout, is_number, split
from electrovib.data.readers.recorded import Channel, Recorded

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.core.arrays import Real

DESCRIPTION: Final = "delimited text of any instrument (.csv, .tsv, .txt, .dat)"
_STEP: Final = frozenset({
    "increment", "sample interval", "sampleinterval", "sampling interval", "xincr", "x increment", "xincrement", "dt",
    "tinc", "t inc", "time step", "timestep", "sampling period", "sample period", "xinc", "horizontal interval",
    "time interval", "resolution",
})  # fmt: skip
_RATE: Final = frozenset(
    {"sample rate", "samplerate", "sampling rate", "sampling frequency", "sample frequency", "fs"}
)
_START: Final = frozenset({"start", "xzero", "x zero", "xorg", "xorigin", "t0", "start time", "first sample"})
_TIMING: Final = _STEP | _START
_COUNTS: Final = frozenset({"sequence", "index", "nr", "no", "point", "points", "sample", "samples", "#"})
_TIMES: Final = re.compile(r"(elapsed |trigger )?time\b.*|t|zeit|x-axis|x|seconds?|source", re.IGNORECASE)
_UNEVEN: Final = 2
_LONGEST_LINE: Final = 1_000_000
_LONGEST_SETTING: Final = 200
_MOST_SETTINGS: Final = 200


def read_laboratory_text(
    path: Path, *, delimiter: str | None = None, decimal_comma: bool | None = None
) -> Recorded:
    """Read a text file of an instrument.

    Parameters
    ----------
    path : Path
        The file.
    delimiter : str, optional
        One character, or empty for blanks; found if not given.
    decimal_comma : bool, optional
        Whether decimals are written with a comma; found if not given.

    Returns
    -------
    Recorded
        Every column of numbers, and what the preamble states.

    Raises
    ------
    DataFileError
        If there is no row of numbers, or rows are not alike; it names the option that helps.
    """
    check_file(path)
    raw, encoding = _text(path)
    first = list(itertools.islice(_lines(raw, encoding), INSPECTED))
    layout = find_layout(first, delimiter=delimiter, decimal_comma=decimal_comma)
    if layout is None:
        raise DataFileError(
            "holds no rows of numbers; if it does, state its delimiter and its decimal sign.", path=path
        )
    numbers = _numbers(path, raw, encoding, layout)
    settings = _settings(layout)
    step, start = _timing(layout, settings)
    return _recorded(layout, numbers, settings, step, start)


def _text(path: Path) -> tuple[bytes, str]:
    """Read the bytes and find how they are written."""
    raw = path.read_bytes()
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw, "utf-16"
    if b"\0" in raw[:4096]:
        raise DataFileError("is not a text file; it holds zero bytes.", path=path)
    try:
        raw.decode("utf-8-sig")
    except UnicodeDecodeError:  # instruments write the micro sign in Latin-1
        return raw, "latin-1"
    return raw, "utf-8-sig"


def _lines(raw: bytes, encoding: str) -> Iterator[str]:
    with io.TextIOWrapper(io.BytesIO(raw), encoding, errors="replace") as text:
        for line in text:
            yield line.rstrip("\n")[:_LONGEST_LINE]


def _numbers(path: Path, raw: bytes, encoding: str, layout: Layout) -> Real:
    """Read the columns of numbers, shape (rows, columns); an empty or starred field is not a number."""

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
            yield "\t".join(_plain(path, number, cells[at], layout) for at in layout.columns)

    found = np.loadtxt(rows(), delimiter="\t", comments=None, ndmin=2)
    if found.shape[0] < _UNEVEN:
        raise DataFileError("holds fewer than two rows of numbers.", path=path)
    return np.asarray(found, dtype=float)


def _plain(path: Path, number: int, cell: str, layout: Layout) -> str:
    """Write a number with a point; nothing and stars as not a number."""
    if not cell or cell in ("****", "--"):
        return "nan"
    if not is_number(cell, decimal_comma=layout.decimal_comma):
        sign = "point" if layout.decimal_comma else "comma"
        raise DataFileError(
            f"line {number}: '{cell[:40]}' is not a number; if decimals are written with a {sign}, state it.",
            path=path,
        )
    return (cell.replace(",", ".") if layout.decimal_comma else cell).replace("D", "E").replace("d", "e")


def _settings(layout: Layout) -> dict[str, str]:
    """Collect what the preamble states: key and value beside each other, or one above the other in headings."""
    found: dict[str, str] = {}
    for row in layout.preamble[:_MOST_SETTINGS]:
        filled = [cell.strip().lstrip("#").strip() for cell in row if cell.strip()]
        if len(filled) == 1 and ":" in filled[0]:
            filled = [part.strip() for part in filled[0].split(":", 1)]
        if len(filled) >= 2 and not _looks_like_number(filled[0]):
            found.setdefault(
                filled[0].rstrip(":")[:_LONGEST_SETTING], ", ".join(filled[1:])[:_LONGEST_SETTING]
            )
    for above, below in itertools.pairwise(layout.preamble):
        pairs = zip(above, below, strict=False)
        found |= {
            name: value for name, value in pairs if name.lower() in _TIMING and _looks_like_number(value)
        }
    return found


def _looks_like_number(text: str) -> bool:
    return is_number(text, decimal_comma=False) or is_number(text, decimal_comma=True)


def _timing(layout: Layout, settings: dict[str, str]) -> tuple[float | None, float]:
    """Find the time step and the first time in the preamble [s]."""
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
    return _quantity(value, unit, "s", layout)


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


def _recorded(
    layout: Layout, numbers: Real, settings: dict[str, str], step: float | None, start: float
) -> Recorded:
    """Name the channels and find the time among them."""
    channels: list[Channel] = []
    for place, column in enumerate(layout.columns):
        name = layout.names[place] or f"column {column}"
        while any(each.name == name for each in channels):
            name = f"{name}'"
        channels.append(Channel(name=name, unit=layout.units[place], values=numbers[:, place]))
    time = ""
    first = channels[0]
    counts = first.name.lower() in _COUNTS or first.unit.lower() in _COUNTS or _counts(first.values)
    if step is not None and (counts or layout.names[0].lower() == "x"):
        channels = channels[1:] or channels
    elif len(channels) > 1 and _is_time(first):
        time = first.name
        step = None
    return Recorded(channels=tuple(channels), time=time, step=step, start=start, attributes=settings)


def _counts(values: Real) -> bool:
    """Tell whether a column numbers the samples."""
    return bool(np.array_equal(values, np.arange(values.size) + values[0]) and values[0] in (0, 1))


def _is_time(channel: Channel) -> bool:
    """Tell whether the first column is the time: by its name or unit, or unnamed by its rise."""
    rises = bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())
    if channel.unit in ("s", "ms", "us", "ns"):
        return rises
    unnamed = channel.name.startswith("column ")
    return rises and (unnamed or (not channel.unit and bool(_TIMES.fullmatch(channel.name))))
