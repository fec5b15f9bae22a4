"""Columns of delimited text."""

from __future__ import annotations

import csv
import io
import itertools
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import Column
from electrovib.data.columns.headings import choose, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

_WORD_WITH_UNIT = re.compile(r"\S+(?:\s{1,9}[\[(][^\])]{0,40}[\])])?")
_LONGEST_ROW = 1_000_000
_MOST_COLUMNS = 100_000


@dataclass(frozen=True, kw_only=True)
class TextTable:
    """Delimited text, of which only the first lines have been interpreted; as bytes it is smaller than a list of lines."""

    path: Path
    raw: bytes
    encoding: str
    delimiter: str | None
    headings: tuple[str, ...]
    units: tuple[str, ...]
    width: int

    def lines(self) -> Iterator[str]:
        """Iterate over all lines, including comments."""
        return _lines(self.raw, self.encoding)

    def rows(self) -> Iterator[tuple[int, str]]:
        """Iterate over the rows of numbers, each with its line number in the file, starting at 1."""
        numbered = _rows(self.path, self.raw, self.encoding)
        return itertools.islice(numbered, bool(self.headings) + bool(self.units), None)

    def label(self, index: int) -> str:
        """Return the name of a column for a message."""
        return f"column '{self.headings[index]}'" if self.headings else f"column {index}"

    def numbers(self, indices: Sequence[int], *, missing: bool = False) -> NDArray[np.float64]:
        """Read columns, shape (rows, indices), in the units of the file; `missing` reads empty fields as NaN."""
        if next(self.rows(), None) is None:
            return np.empty((0, len(indices)))
        said = ""
        # a Python function for each field is slow, so it is used only after the fast conversion has failed
        for converters in (None, _number_or_missing)[: 2 if missing else 1]:
            try:
                return np.loadtxt(
                    self._even_rows(),
                    delimiter=self.delimiter,
                    comments=None,
                    usecols=indices,
                    ndmin=2,
                    quotechar='"' if b'"' in self.raw else None,
                    converters=converters,
                )
            except ValueError as error:
                said = str(error)
        raise DataFileError(f"{self.path}: {self._fault(indices, missing) or said}.")

    def _even_rows(self) -> Iterator[str]:
        """Iterate over the rows of numbers as long as they have the same number of fields."""
        delimiter, width = self.delimiter, self.width
        for _, row in self.rows():
            simple = '"' not in row
            if (row.count(delimiter) + 1 if delimiter and simple else len(_split(row, delimiter))) != width:
                raise ValueError("rows of unequal length")
            yield row

    def _fault(self, indices: Sequence[int], missing: bool) -> str:
        for number, line in self.rows():
            cells = _split(line, self.delimiter)
            if len(cells) != self.width:
                first = "the headings have" if self.headings else "the first row has"
                return f"line {number} has {len(cells)} fields, but {first} {self.width}"
            for index in indices:
                cell = cells[index]
                if not _is_number(cell) and not (missing and not cell):
                    hint = "; write decimals with a point" if re.fullmatch(r"[+-]?\d+,\d+", cell) else ""
                    why = f"'{cell[:40]}' is not a number{hint}" if cell else "the number is missing"
                    return f"line {number}, {self.label(index)}: {why}"
        return ""


def read_table(path: Path, names: Sequence[str] = (), *, delimiter: str | None = None) -> TextTable:
    """Split delimited text into lines, headings and units; there are no headings if the first row consists of numbers."""
    raw, encoding = _text(path)
    first = [line for _, line in itertools.islice(_rows(path, raw, encoding), 12)]
    if not first:
        raise DataFileError("holds no rows, only comments or blank lines.", path=path)
    delimiter = delimiter or _delimiter(first)
    _check_width(path, first[0], delimiter)
    top = _split(first[0], delimiter, headings=True)
    second = _split(first[1], delimiter) if len(first) > 1 else []
    known = {name for cell in top for name in (cell, name_and_unit(cell)[0])}
    if any(map(_is_number, top)) and not known.intersection(names):
        for above, below in zip(top, second, strict=False):
            if above and not _is_number(above) and _is_number(below):
                raise DataFileError(
                    f"the first row has '{above[:40]}' above a number and is neither headings nor"
                    " data; mend it or begin it with '#'.",
                    path=path,
                )
        return TextTable(
            path=path,
            raw=raw,
            encoding=encoding,
            delimiter=delimiter,
            headings=(),
            units=(),
            width=len(_split(first[0], delimiter)),
        )
    while not top[-1] and len(top) > max(1, len(second)):
        top.pop()  # a delimiter after the last heading
    has_units = any(second) and all(not cell or re.fullmatch(r"[\[(].*[\])]", cell) for cell in second)
    units = tuple(cell[1:-1].strip() for cell in second) if has_units else ()
    return TextTable(
        path=path,
        raw=raw,
        encoding=encoding,
        delimiter=delimiter,
        headings=tuple(top),
        units=units,
        width=len(top),
    )


def _text(path: Path) -> tuple[bytes, str]:
    raw = path.read_bytes()
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw, "utf-16"
    if b"\0" in raw:
        raise DataFileError("is not a text file; it holds zero bytes.", path=path)
    try:
        raw.decode("utf-8-sig")
    except UnicodeDecodeError:  # instruments write the micro sign in Latin-1
        return raw, "latin-1"
    return raw, "utf-8-sig"


def _lines(raw: bytes, encoding: str) -> Iterator[str]:
    with io.TextIOWrapper(io.BytesIO(raw), encoding, errors="replace") as text:
        for line in text:
            yield line.rstrip("\n")


def _rows(path: Path, raw: bytes, encoding: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(_lines(raw, encoding), 1):
        if _is_row(line):
            if len(line) > _LONGEST_ROW:
                raise DataFileError(
                    f"line {number} has {len(line)} characters; a table has a row per sample.", path=path
                )
            yield number, line


def _check_width(path: Path, line: str, delimiter: str | None) -> None:
    width = len(line.split(delimiter, _MOST_COLUMNS))
    if width > _MOST_COLUMNS:
        raise DataFileError(
            f"has more than {_MOST_COLUMNS} columns; a table has a row per sample and a column per signal.",
            path=path,
        )


def _is_row(line: str) -> bool:
    start = line.lstrip()[:1]
    return start not in ("", "#")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return cell.isascii() and "_" not in cell


def _number_or_missing(cell: str) -> float:
    if not cell.strip():
        return np.nan
    if not _is_number(cell.strip()):
        raise ValueError(cell)
    return float(cell)


def _delimiter(lines: Sequence[str]) -> str | None:
    """Return the delimiter that all, or else some, of the first lines contain; None stands for blanks."""
    for has in (all, any):
        for character in "\t;,":
            if has(character in line for line in lines):
                return character
    return None


def _split(line: str, delimiter: str | None, *, headings: bool = False) -> list[str]:
    if delimiter is None:
        return _WORD_WITH_UNIT.findall(line) if headings else line.split()
    cells = line.split(delimiter)
    if '"' in line:
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
        except csv.Error:  # a field beyond the limit of the csv module
            return cells
    return [cell.strip() for cell in cells]


def from_text(path: Path, columns: Sequence[str | int], *, missing: bool = False) -> dict[str | int, Column]:
    """Read columns by heading or number; units are in the headings or in a row of their own."""
    table = read_table(path, [column for column in columns if isinstance(column, str)])
    indices = [choose(path, table.headings, column, table.width) for column in columns]
    numbers = table.numbers(indices, missing=missing)

    def line(row: int) -> str:
        return f"line {next(number for i, (number, _) in enumerate(table.rows()) if i == row)}"

    found: dict[str | int, Column] = {}
    for column, index, values in zip(columns, indices, numbers.T, strict=True):
        own = name_and_unit(table.headings[index])[1] if table.headings else ""
        own = own or (table.units[index] if index < len(table.units) else "")
        found[column] = Column(label=table.label(index), unit=own, values=values, place=line)
    return found
