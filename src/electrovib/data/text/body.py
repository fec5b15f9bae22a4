"""The rows of a text through `pandas.read_csv`, each with its line, and what is no row; columns of plain tables, strictly."""

from __future__ import annotations

import csv
import dataclasses
import functools
import io
import itertools
import re
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import DataColumn, NotRead, choose
from electrovib.data.text.hypotheses import find_layout
from electrovib.data.text.layout import (
    RULE,
    STATISTICS,
    WIDE,
    WORD_WITH_UNIT,
    as_utf8,
    check_width,
    end_of,
    is_comment,
    lines_of,
    place_of,
    split,
)
from electrovib.data.unit_words import name_and_known_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.text.layout import Layout

_MOST_BEHIND: Final = 1000
"""Lines at the end of a text among which rows that are no samples are looked for."""
_SHOWN: Final = 40


@dataclass(frozen=True, kw_only=True)
class Body:
    """The rows of a text: a table of pandas with numbered columns, the line of a row from 1, and what is left out.

    `commented` rows have comments among them.
    """

    table: Any
    line: Callable[[int], int]
    left_out: tuple[NotRead, ...] = ()
    commented: bool = False

    @property
    def is_plain(self) -> bool:
        """Whether there are numbers in all fields of all lines, so that no line divides the text into tables."""
        return (
            not self.left_out and not self.commented and all(each.kind in "fiu" for each in self.table.dtypes)
        )


def table_of(
    raw: bytes, start: int, *, delimiter: str, width: int, decimal: str = ".", **options: Any
) -> Any:
    """Read rows of text from a place on with pandas, whose numbers are the nearest floats."""
    import pandas as pd

    exact = (
        {"float_precision": "round_trip"} if tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1) else {}
    )
    content = io.BytesIO(raw)
    content.seek(start)
    with warnings.catch_warnings():
        warnings.simplefilter("error", pd.errors.ParserWarning)  # more fields than there are columns
        warnings.simplefilter("ignore", pd.errors.DtypeWarning)  # words among numbers are looked at later
        return pd.read_csv(
            content,
            header=None,
            index_col=False,
            names=range(width),
            sep=delimiter or r"\s+",
            decimal=decimal,
            encoding_errors="replace",
            **exact,
            **options,
        )


def body_of(path: Path, raw: bytes, layout: Layout) -> Body:
    """Read the rows behind the headings; rows of statistics and words at the end are left out, and cut off rows refused."""
    import pandas as pd

    start = place_of(raw, layout.first)
    end, behind = _behind(raw, start, layout)
    rows = raw if end == len(raw) else raw[:end]
    decimal = layout.notation.decimal
    try:
        sign = rows.find(b"#", start)
        simple = sign < 0 or not re.search(rb"^[ \t]*#", memoryview(rows)[sign - 1 :], re.MULTILINE)
        table = None
        if simple and layout.delimiter != WIDE:
            table = table_of(
                rows,
                start,
                delimiter=layout.delimiter,
                width=layout.width,
                decimal=decimal,
                skipinitialspace=rows.find(b'"', start) >= 0,  # which takes a quarter longer
            )
    except (pd.errors.ParserError, pd.errors.ParserWarning, pd.errors.EmptyDataError):
        table = None
    if table is not None and _is_even(rows, start, layout, table):

        def line(row: int) -> int:
            numbered = enumerate(lines_of(rows, start), layout.first + 1)
            filled = (number for number, text in numbered if text.strip())
            return next(itertools.islice(filled, row, None))

        return Body(table=table, line=line, left_out=behind)
    return dataclasses.replace(_uneven(path, rows, start, layout, behind), commented=not simple)


def _is_even(raw: bytes, start: int, layout: Layout, table: Any) -> bool:
    """Return whether all rows have the same number of fields; pandas fills short ones without a word."""
    if not table[layout.width - 1].isna().any():
        return True
    if layout.delimiter:
        return raw.count(layout.delimiter.encode(), start) == len(table) * (layout.width - 1)
    return False


def _uneven(path: Path, raw: bytes, start: int, layout: Layout, behind: tuple[NotRead, ...]) -> Body:
    """Read rows with different numbers of fields: lines of words are left out, rows that are cut off refused."""
    rows: list[list[str]] = []
    numbers: list[int] = []
    words: list[tuple[int, str]] = []
    for number, line in enumerate(lines_of(raw, start), layout.first + 1):
        if not line.strip() or is_comment(line):
            continue
        cells = split(line, layout.delimiter)
        if len(cells) <= layout.columns[-1]:
            if not any(layout.notation.is_number(cell) for cell in cells):
                words.append((number, line))
                continue
            raise DataFileError(
                f"line {number} has {len(cells)} fields, fewer than the {layout.width} of the other rows: it is cut off,"
                " or the delimiter is another one; state it.",
                path=path,
            )
        rows.append([cell.replace("\t", " ") for cell in cells])
        numbers.append(number)
    width = max(layout.width, *map(len, rows)) if rows else layout.width
    text = "\n".join("\t".join(row + [""] * (width - len(row))) + "\t." for row in rows)
    table = table_of(
        text.encode(),
        0,
        delimiter="\t",
        width=width + 1,
        decimal=layout.notation.decimal,
        quoting=csv.QUOTE_NONE,
    )
    return Body(
        table=table.drop(columns=width),
        line=numbers.__getitem__,
        left_out=(*_named(words, "words between the rows of numbers"), *behind),
    )


def _behind(raw: bytes, start: int, layout: Layout) -> tuple[int, tuple[NotRead, ...]]:
    """Return where the rows of numbers end, and what stands behind them: words, or rows of statistics."""
    begin = max(start, end_of(raw, _MOST_BEHIND))
    lines = list(lines_of(raw, begin))
    usual = {cell for line in lines[: len(lines) // 2] for cell in split(line, layout.delimiter)}
    kept = len(lines)
    while kept and not _is_sample(lines[kept - 1], layout, usual):
        kept -= 1
    words = [(at, line) for at, line in enumerate(lines[kept:], kept) if line.strip()]
    if not words or not kept:
        return len(raw), ()
    before = raw.count(b"\n", 0, begin) + 1
    return place_of(raw, kept, begin), _named(
        [(before + at, line) for at, line in words], "no samples: words, or statistics of them"
    )


def _is_sample(line: str, layout: Layout, usual: set[str]) -> bool:
    """Return whether a line is a row of numbers, or one that is cut off."""
    if not line.strip() or is_comment(line) or (RULE.fullmatch(line) and line.strip() not in usual):
        return False
    cells = split(line, layout.delimiter)
    if any(STATISTICS.fullmatch(cell) and cell not in usual for cell in cells):
        return False
    numbers = [cells[at] for at in layout.columns if at < len(cells) and cells[at]]
    notation = layout.notation
    are = [notation.is_number(cell) or notation.quantity(cell) is not None for cell in numbers]
    return all(are) and (any(are) or len(cells) >= layout.width)


def _named(words: list[tuple[int, str]], why: str) -> tuple[NotRead, ...]:
    if not words:
        return ()
    (first, text), (last, _) = words[0], words[-1]
    name = f"line {first}" if len(words) == 1 else f"{len(words)} lines, {first} to {last}"
    return (NotRead(name=name, why=f"{why}, the first '{text.strip()[:_SHOWN]}'"),)


_LONGEST_ROW: Final = 1_000_000
_INSPECTED: Final = 12
_NO_NUMBER: Final = ["", "nan", "NaN", "NAN", "-nan", "+nan"]


@dataclass(frozen=True, kw_only=True)
class TextTable:
    """Delimited text, of which only the first lines have been interpreted; as bytes it is smaller than a list of lines."""

    path: Path
    raw: bytes
    delimiter: str
    headings: tuple[str, ...]
    units: tuple[str, ...]
    width: int

    def rows(self) -> Iterator[tuple[int, str]]:
        """Iterate over the rows of numbers, each with its line number in the file, starting at 1."""
        numbered = _rows(self.path, self.raw)
        return itertools.islice(numbered, bool(self.headings) + bool(self.units), None)

    def label(self, index: int) -> str:
        """Return the name of a column for a message."""
        return f"column '{self.headings[index]}'" if self.headings else f"column {index}"

    def numbers(self, indices: Sequence[int], *, missing: bool = False) -> Real:
        """Read columns, shape (rows, indices), in the units of the file; `missing` reads empty fields as NaN."""
        first = next(self.rows(), None)
        if first is None:
            return np.empty((0, len(indices)))
        start = place_of(self.raw, first[0] - 1)
        read = functools.partial(
            table_of,
            delimiter=self.delimiter,
            width=self.width,
            skipinitialspace=True,
            keep_default_na=False,
            na_values=_NO_NUMBER,
        )
        table = None
        with suppress(ValueError, Warning):  # of pandas, which names no line
            table = read(self.raw, start)[list(indices)]
        if table is None or not self._is_plain(table, start, missing):
            if why := self._fault(indices, missing):
                raise DataFileError(f"{self.path}: {why}.")
            table = read("\n".join(row for _, row in self.rows()).encode(), 0)[list(indices)]
        return np.asarray(table.to_numpy(dtype=float))

    def _is_plain(self, table: Any, start: int, missing: bool) -> bool:
        """Return whether pandas found numbers alone, and rows of one length, so that nothing has to be looked at again."""
        if any(each.kind not in "fiu" for each in table.dtypes) or self.raw.find(b"\n#", start) >= 0:
            return False
        if not missing and table.isna().any(axis=None):
            return False
        fields = len(table) * (self.width - 1)
        return bool(self.delimiter) and self.raw.count(self.delimiter.encode(), start) == fields

    def _fault(self, indices: Sequence[int], missing: bool) -> str:
        for number, line in self.rows():
            cells = split(line, self.delimiter)
            if len(cells) != self.width:
                first = "the headings have" if self.headings else "the first row has"
                return f"line {number} has {len(cells)} fields, but {first} {self.width}"
            for index in indices:
                cell = cells[index]
                if not _is_number(cell) and not (missing and not cell):
                    hint = (
                        "; write decimals with a point"
                        if re.fullmatch(r"[+-]?\d+,\d+([eE][+-]?\d+)?", cell)
                        else ""
                    )
                    why = f"'{cell[:40]}' is not a number{hint}" if cell else "the number is missing"
                    return f"line {number}, {self.label(index)}: {why}"
        return ""


def read_table(path: Path, names: Sequence[str] = ()) -> TextTable:
    """Split delimited text into lines, headings and units; there are no headings if the first row consists of numbers."""
    raw = as_utf8(path, path.read_bytes())
    first = [line for _, line in itertools.islice(_rows(path, raw), _INSPECTED)]
    if not first:
        raise DataFileError("holds no rows, only comments or blank lines.", path=path)
    check_width(path, first)
    delimiter = _delimiter(first)
    second = split(first[1], delimiter) if len(first) > 1 else []
    top = split(first[0], delimiter)
    if not delimiter:
        words = [first[0].strip()] if len(second) == 1 else WORD_WITH_UNIT.findall(first[0])
        top = [word.strip('"') for word in words]
    headings, units, width = tuple(top), tuple[str, ...](), len(top)
    if any(map(_is_number, top)) and not _are_headings(top, names):
        _refuse_mixture(path, top, second)
        headings, width = (), len(split(first[0], delimiter))
    else:
        while not headings[-1] and len(headings) > max(1, len(second)):
            headings = headings[:-1]  # a delimiter after the last heading
        if any(second) and all(not cell or re.fullmatch(r"[\[(].*[\])]", cell) for cell in second):
            units = tuple(cell[1:-1].strip() for cell in second)
        width = len(headings)
    return TextTable(path=path, raw=raw, delimiter=delimiter, headings=headings, units=units, width=width)


def _delimiter(lines: Sequence[str]) -> str:
    """Return the delimiter under which most rows hold numbers, or which headings without numbers contain; empty for blanks."""
    layout = find_layout(lines, decimal_comma=False)
    if layout is not None:  # of one column any is found
        return layout.delimiter if any(layout.delimiter in line for line in lines) else ""
    return next((sign for sign in "\t;," if sign in lines[0]), "")


def _are_headings(cells: Sequence[str], names: Sequence[str]) -> bool:
    """Return whether a name that was asked for is among the cells, which may be numbers."""
    return not {name for cell in cells for name in (cell, name_and_known_unit(cell)[0])}.isdisjoint(names)


def _refuse_mixture(path: Path, top: Sequence[str], second: Sequence[str]) -> None:
    """Refuse a first row that holds words above numbers, and numbers."""
    for above, below in zip(top, second, strict=False):
        if above and not _is_number(above) and _is_number(below):
            raise DataFileError(
                f"the first row has '{above[:40]}' above a number and is neither headings nor data; mend it or begin it"
                " with '#'.",
                path=path,
            )


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns by heading or number; units are in the headings or in a row of their own."""
    table = read_table(path, [column for column in columns if isinstance(column, str)])
    indices = [choose(path, table.headings, column, table.width) for column in columns]
    numbers = table.numbers(indices, missing=missing)

    def line(row: int) -> str:
        return f"line {next(itertools.islice(table.rows(), row, None))[0]}"

    found: dict[str | int, DataColumn] = {}
    for column, index, values in zip(columns, indices, numbers.T, strict=True):
        own = name_and_known_unit(table.headings[index])[1] if table.headings else ""
        own = own or (table.units[index] if index < len(table.units) else "")
        found[column] = DataColumn(
            name=table.label(index), unit=own, values=values, label=table.label(index), place=line
        )
    return found


def _rows(path: Path, raw: bytes) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(lines_of(raw), 1):
        if line.lstrip()[:1] not in ("", "#"):
            if len(line) > _LONGEST_ROW:
                raise DataFileError(
                    f"line {number} has {len(line)} characters; a table has a row per sample.", path=path
                )
            yield number, line


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return cell.isascii() and "_" not in cell
