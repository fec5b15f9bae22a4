"""Text of any instrument: CSV and TSV with a preamble, a row of units, decimal commas, or a time step instead of a column."""

from __future__ import annotations

import io
import itertools
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.faults import check_file
from electrovib.data.readers.layout import INSPECTED, Layout, find_layout, is_number, split
from electrovib.data.readers.preamble import settings_of, timing
from electrovib.data.readers.recorded import DataColumn, Recorded

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.core.arrays import Real

DESCRIPTION: Final = "delimited text of any instrument (.csv, .tsv, .txt, .dat)"
_COUNTS: Final = frozenset({"sequence", "index", "nr", "no", "point", "points", "sample", "samples", "#"})
_TIMES: Final = re.compile(
    r"(elapsed |trigger )?time\b.*|t|zeit|x-axis|x[_ ]?value|x|seconds?|source", re.IGNORECASE
)
_UNEVEN: Final = 2
_LONGEST_LINE: Final = 1_000_000


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
        Every column of numbers, and the statements of the preamble.

    Raises
    ------
    DataFileError
        If there is no row of numbers, or rows are not alike; it names the option that helps.
    """
    check_file(path)
    return read_laboratory_bytes(path, path.read_bytes(), delimiter=delimiter, decimal_comma=decimal_comma)


def read_laboratory_bytes(
    path: Path,
    raw: bytes,
    *,
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    origin: str = "",
) -> Recorded:
    """Read the text of an instrument that is in memory.

    Parameters
    ----------
    path : Path
        File, for messages.
    raw : bytes
        Its text.
    delimiter : str, optional
        As for `read_laboratory_text`.
    decimal_comma : bool, optional
        As for `read_laboratory_text`.
    origin : str
        Name of the sheet that the text comes from, which becomes the attribute ``sheet``; empty if there is none.

    Returns
    -------
    Recorded
        Every column of numbers, and the statements of the preamble.

    Raises
    ------
    DataFileError
        If there is no row of numbers, or rows are not alike; it names the option that helps.
    """
    encoding = _encoding(path, raw)
    first = list(itertools.islice(_lines(raw, encoding), INSPECTED))
    layout = find_layout(first, delimiter=delimiter, decimal_comma=decimal_comma)
    if layout is None:
        raise DataFileError(
            "holds no rows of numbers; if it does, state delimiter (--delimiter) and decimal_comma (--decimal-comma).",
            path=path,
        )
    numbers = _numbers(path, raw, encoding, layout)
    settings = settings_of(layout) | ({"sheet": origin} if origin else {})
    step, start = timing(layout, settings)
    return _recorded(layout, numbers, settings, step, start)


def _encoding(path: Path, raw: bytes) -> str:
    """Find the encoding of a text."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if b"\0" in raw[:4096]:
        raise DataFileError("is not a text file; it holds zero bytes.", path=path)
    try:
        raw.decode("utf-8-sig")
    except UnicodeDecodeError:  # instruments write the micro sign in Latin-1
        return "latin-1"
    return "utf-8-sig"


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
    """Return a number with a decimal point; an empty field and stars become NaN."""
    if not cell or cell in ("****", "--"):
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
    """Name the channels and find the time among them."""
    channels: list[DataColumn] = []
    for place, column in enumerate(layout.columns):
        name = layout.names[place] or f"column {column}"
        while any(each.name == name for each in channels):
            name = f"{name}'"
        channels.append(DataColumn(name=name, unit=layout.units[place], values=numbers[:, place]))
    time = ""
    first = channels[0]
    counts = first.name.lower() in _COUNTS or first.unit.lower() in _COUNTS or _counts(first.values)
    if step is not None and (counts or layout.names[0].lower() == "x"):
        channels = channels[1:] or channels
    else:
        candidate = channels[1] if len(channels) > 2 and _is_index(layout, first) else first
        if (
            len(channels) > 1
            and not (candidate is first and _is_index(layout, first))
            and _is_time(candidate)
        ):
            time, step = candidate.name, None
    return Recorded(channels=tuple(channels), time=time, step=step, start=start, attributes=settings)


def _counts(values: Real) -> bool:
    """Return whether a column numbers the samples."""
    return bool(np.array_equal(values, np.arange(values.size) + values[0]) and values[0] in (0, 1))


def _is_index(layout: Layout, first: DataColumn) -> bool:
    """Return whether the first column numbers the rows: it counts, and it alone has no heading."""
    return _counts(first.values) and not layout.names[0] and all(layout.names[1:])


def _is_time(channel: DataColumn) -> bool:
    """Return whether the first column is the time: by name and unit, or by its rise."""
    rises = bool(np.isfinite(channel.values).all() and (np.diff(channel.values) >= 0).all())
    if channel.unit in ("s", "ms", "us", "ns"):
        return rises or bool(_TIMES.fullmatch(channel.name))
    unnamed = channel.name.startswith("column ")
    return rises and (unnamed or (not channel.unit and bool(_TIMES.fullmatch(channel.name))))
