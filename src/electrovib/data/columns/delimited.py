"""Columns of delimited text."""

from __future__ import annotations

import csv
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

_WORD_WITH_UNIT = re.compile(r"\S+(?:\s+[\[(][^\])]*[\])])?")


@dataclass(frozen=True)
class Table:
    """Delimited text, split into lines but not yet into numbers."""

    path: Path
    lines: list[str]
    delimiter: str | None
    headings: tuple[str, ...]
    units: tuple[str, ...]
    width: int

    def rows(self) -> Iterator[tuple[int, str]]:
        """Go through the rows of numbers, each with its line in the file, 1 first."""
        numbered = ((i, line) for i, line in enumerate(self.lines, 1) if _is_row(line))
        for _ in range(bool(self.headings) + bool(self.units)):
            next(numbered, None)
        return numbered

    def label(self, index: int) -> str:
        """Name a column in a message."""
        return f"column '{self.headings[index]}'" if self.headings else f"column {index}"

    def numbers(self, indices: Sequence[int], *, missing: bool = False) -> NDArray[np.float64]:
        """Read columns as (row, index); refuse rows of unequal length and what is no number, empty fields included.

        Parameters
        ----------
        indices : sequence of int
            Columns, 0 first.
        missing : bool
            Read empty fields as NaN instead.

        Returns
        -------
        ndarray, shape (rows, indices)
            In the units of the file.
        """
        rows = [line for _, line in self.rows()]
        if not rows:
            return np.empty((0, len(indices)))
        quote = '"' if any('"' in row for row in rows) else None
        if quote or self.delimiter is None:
            widths = {len(_split(row, self.delimiter)) for row in rows}
        else:
            widths = {row.count(self.delimiter) + 1 for row in rows}
        said = "rows of unequal length"
        # fields that may be empty take a function of Python for each, so only where the fast way has failed
        for converters in (None, _number_or_missing)[: 2 if missing else 1] * (widths == {self.width}):
            try:
                return np.loadtxt(
                    rows,
                    delimiter=self.delimiter,
                    comments=None,
                    usecols=indices,
                    ndmin=2,
                    quotechar=quote,
                    converters=converters,
                )
            except ValueError as error:
                said = str(error)
        raise DataFileError(f"{self.path}: {self._fault(indices, missing) or said}.")

    def _fault(self, indices: Sequence[int], missing: bool) -> str:
        """Look for the first fault, row by row."""
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


def read_table(path: Path, names: Sequence[str] = (), *, delimiter: str | None = None) -> Table:
    """Split delimited text into lines, headings and units.

    Parameters
    ----------
    path : Path
        Text file; ``#`` starts a comment line.
    names : sequence of str
        A first row that mixes words and numbers is taken for headings if it has one of these.
    delimiter : str, optional
        One character; found from the first lines if not given.

    Returns
    -------
    Table
        Without headings if the first row is made of numbers.

    Raises
    ------
    DataFileError
        If the file holds no rows.
    """
    lines = _text(path).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    first = [line for line, _ in zip(filter(_is_row, lines), range(12), strict=False)]
    if not first:
        raise DataFileError(f"{path}: holds no rows, only comments or blank lines.")
    delimiter = delimiter or _delimiter(first)
    top = _split(first[0], delimiter, headings=True)
    second = _split(first[1], delimiter) if len(first) > 1 else []
    known = {name for cell in top for name in (cell, name_and_unit(cell)[0])}
    if any(map(_is_number, top)) and not known.intersection(names):
        for above, below in zip(top, second, strict=False):
            if above and not _is_number(above) and _is_number(below):
                raise DataFileError(
                    f"{path}: the first row has '{above[:40]}' above a number and is neither headings nor"
                    " data; mend it or begin it with '#'."
                )
        return Table(path, lines, delimiter, (), (), len(_split(first[0], delimiter)))
    while not top[-1] and len(top) > max(1, len(second)):
        top.pop()  # a delimiter after the last heading
    has_units = any(second) and all(not cell or re.fullmatch(r"[\[(].*[\])]", cell) for cell in second)
    units = tuple(cell[1:-1].strip() for cell in second) if has_units else ()
    return Table(path, lines, delimiter, tuple(top), units, len(top))


def _text(path: Path) -> str:
    raw = path.read_bytes()
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", errors="replace")
    if b"\0" in raw:
        raise DataFileError(f"{path}: is not a text file; it holds zero bytes.")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:  # instruments write the micro sign in Latin-1
        return raw.decode("latin-1")


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
    """Find the character that all of the first lines have; None stands for blanks."""
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
    """Read columns by heading or number; a unit stands in the heading or in a row of its own; empty fields may be NaN.

    Raises
    ------
    DataFileError
        If the file is no text or no table, lacks a column, or a number in it is none.
    """
    table = read_table(path, [column for column in columns if isinstance(column, str)])
    indices = [choose(path, table.headings, column, table.width) for column in columns]
    numbers = table.numbers(indices, missing=missing)

    def line(row: int) -> str:
        return f"line {next(number for i, (number, _) in enumerate(table.rows()) if i == row)}"

    found: dict[str | int, Column] = {}
    for column, index, values in zip(columns, indices, numbers.T, strict=True):
        own = name_and_unit(table.headings[index])[1] if table.headings else ""
        own = own or (table.units[index] if index < len(table.units) else "")
        found[column] = Column(table.label(index), own, values.copy(), line)
    return found
