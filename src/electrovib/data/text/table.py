"""Delimited text whose first row holds headings or numbers, read strictly."""

from __future__ import annotations

import functools
import itertools
import re
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import DataColumn, choose
from electrovib.data.text.body import table_of
from electrovib.data.text.hypotheses import find_layout
from electrovib.data.text.layout import (
    WORD_WITH_UNIT,
    as_utf8,
    check_width,
    lines_of,
    place_of,
    split,
)
from electrovib.data.unit_words import name_and_known_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real


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
