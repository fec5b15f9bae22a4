"""Text of any instrument: CSV and TSV with a preamble, a row of units, decimal commas, or a time step instead of a column."""

from __future__ import annotations

import dataclasses
import io
import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.faults import check_file
from electrovib.data.readers.column_facts import named_by_preamble
from electrovib.data.readers.date_times import stamp_columns, with_stamps
from electrovib.data.readers.layout import INSPECTED, Layout, find_layout, split
from electrovib.data.readers.number_cells import MISSING, is_number
from electrovib.data.readers.preamble import settings_of, timing
from electrovib.data.readers.recorded import DataColumn, Recorded
from electrovib.data.readers.tables import one_table, repeated_table
from electrovib.data.readers.time_column import FREQUENCY, counts, is_index, is_time, keeps_step

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real

DESCRIPTION: Final = "delimited text of any instrument (.csv, .tsv, .txt, .dat, .lvm, .dta, .mpt, .par)"
_UNEVEN: Final = 2
_LONGEST_LINE: Final = 1_000_000


def read_laboratory_text(
    path: Path, *, delimiter: str | None = None, decimal_comma: bool | None = None, part: str = ""
) -> Recorded:
    """Read every column of numbers of a text file of an instrument, and the statements of its preamble.

    An empty `delimiter` stands for blanks. Of a file with several tables, as Gamry and VersaStudio write
    them, `part` names the table; by default it is the spectrum or the longest one.
    """
    check_file(path)
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
    encoding = _encoding(path, raw)
    first = list(itertools.islice(_lines(raw, encoding), INSPECTED))
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


def _encoding(path: Path, raw: bytes) -> str:
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
        name = layout.names[place] or f"column {column}"
        while any(each.name == name for each in channels):
            name = f"{name}'"
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
