"""Text of any instrument: CSV and TSV with a preamble, a row of units, decimal commas, or a time step instead of a column."""

from __future__ import annotations

import dataclasses
import io
import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
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
from electrovib.data.text.parts import one_segment, one_table, repeated_table
from electrovib.data.text.preamble import named_by_preamble, settings_of, with_clocks
from electrovib.data.text.stamps import stamp_columns, with_stamps
from electrovib.data.text.table import read_columns

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real


_UNEVEN: Final = 2
_LONGEST_LINE: Final = 1_000_000


def read_laboratory_text(
    path: Path, *, delimiter: str | None = None, decimal_comma: bool | None = None, part: str = ""
) -> Recorded:
    """Read every column of numbers of a text file of an instrument, and the statements of its preamble.

    An empty `delimiter` stands for blanks. Of a file with several tables, as Gamry and VersaStudio write
    them, `part` names the table; by default it is the spectrum or the longest one.
    """
    raw, about, others = one_table(path, path.read_bytes(), part)
    if about and delimiter is None:
        delimiter = "\t" if b"\t" in raw else ","
    found = read_laboratory_bytes(
        path, raw, delimiter=delimiter, decimal_comma=decimal_comma, part="" if about else part
    )
    return dataclasses.replace(
        found, attributes={**found.attributes, **about}, not_read=(*found.not_read, *others)
    )


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
    raw, about, others = repeated_table(path, raw, part)
    if about:
        first = list(itertools.islice(_lines(raw, encoding), INSPECTED))
        layout = find_layout(first, delimiter=layout.delimiter, decimal_comma=layout.decimal_comma) or layout
    stamped = stamp_columns(layout, first)
    numbers, stamps = _numbers(path, raw, encoding, layout, stamped)
    settings = settings_of(layout) | ({"sheet": origin} if origin else {}) | about | _left_out(layout)
    found = _recorded(layout, numbers, settings)
    if stamps:
        above = split(first[layout.headings], layout.delimiter) if layout.headings < layout.first else []
        found = with_stamps(found, stamps, " ".join(above[at] for at in stamped if at < len(above)))
    found = one_segment(path, found, "" if about else part)
    return dataclasses.replace(found, not_read=(*found.not_read, *others))


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


def _recorded(layout: Layout, numbers: Real, settings: dict[str, str]) -> Recorded:
    layout = named_by_preamble(layout, settings)
    channels: list[DataColumn] = []
    for place, column in enumerate(layout.columns):
        name = unique(layout.names[place] or f"column {column}", channels)
        channels.append(DataColumn(name=name, unit=layout.units[place], values=numbers[:, place]))
    return with_clocks(layout, channels, settings)


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
