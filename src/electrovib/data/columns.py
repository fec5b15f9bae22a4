"""Columns of a measured file as SI arrays, from delimited text, NumPy or netCDF."""

from __future__ import annotations

import csv
import functools
import re
import struct
import tokenize
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError, nearest
from electrovib.core.units import KINDS, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    import xarray
    from numpy.typing import NDArray

DAMAGE: Final = (
    OSError, RuntimeError, ValueError, LookupError, TypeError, AttributeError, EOFError, MemoryError,
    ArithmeticError, SyntaxError, AssertionError, struct.error, tokenize.TokenError,
)  # fmt: skip
"""What NumPy, HDF5 and netCDF libraries raise at damaged files."""

_ANGLE = re.compile(r"rad|deg|°|turn|rev|rpm|cycle")
_HEADING = re.compile(r"(.*\S)(\s*)([\[(])([^\[\]()]*)[\])]")
_WORD_WITH_UNIT = re.compile(r"\S+(?:\s+[\[(][^\])]*[\])])?")


def read_columns(path: Path, wanted: Mapping[str, tuple[str | int, str]]) -> dict[str, NDArray[np.float64]]:
    """Read the wanted columns of a measured file, converted to SI.

    Parameters
    ----------
    path : Path
        ``.csv``, ``.txt`` or ``.tsv`` (delimiter found, lines with ``#`` skipped, headings such as
        ``time [us]`` or none), ``.npy`` (a row per sample, or a structured array) or ``.nc`` (variables).
    wanted : mapping
        Parameter name to (heading or 0-based number, unit of the numbers where the file names none).

    Returns
    -------
    dict of str to array
        One-dimensional, SI, finite, at least two values; keys as in `wanted`.

    Raises
    ------
    DataFileError
        In one sentence with file, line or row, and column, whatever is wrong with the file.

    Notes
    -----
    A unit in the file overrides the one asked for, but it has to be of the same kind.
    """
    check_file(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise DataFileError(f"{path}: columns are read from {', '.join(_READERS)}, not from '{path.suffix}'.")
    found = reader(path, [column for column, _ in wanted.values()])
    return {name: found[column].in_si(path, unit) for name, (column, unit) in wanted.items()}


def check_file(path: Path) -> None:
    """Refuse what is not an ordinary file with something in it.

    Raises
    ------
    DataFileError
        If it is missing, a folder, a device, empty or may not be read.
    """
    try:
        if path.is_dir():
            raise DataFileError(f"{path}: is a folder; give the name of a file in it.")
        if not path.exists():
            siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            raise DataFileError(f"{path}: there is no such file.{_close(path.name, siblings)}")
        if not path.is_file():
            raise DataFileError(f"{path}: is not an ordinary file.")
        with path.open("rb") as file:
            if not file.read(1):
                raise DataFileError(f"{path}: the file is empty.")
    except (OSError, ValueError) as error:
        raise DataFileError(f"{path}: cannot be read: {error}.") from None


def damaged(path: Path, what: str, error: BaseException) -> DataFileError:
    """Make one sentence of what a library said about a damaged file."""
    said = (str(error).splitlines() or [""])[0][:160] or type(error).__name__
    return DataFileError(f"{path}: is damaged or not {what} ({said}).")


def _close(word: str, known: Sequence[str]) -> str:
    """Suggest a name without listing all of them."""
    near = nearest(word, known)
    return near if near.startswith(" Did") else ""


# ------------------------------------------------------------------------------ headings and units


@functools.cache
def _kind_and_factor(unit: str) -> tuple[str, float] | None:
    """Find the SI unit that a unit text belongs to, and its size in it."""
    if unit in ("1", "-"):
        return "1", 1.0
    if not unit or len(unit) > 24:
        return None
    # likely kinds first, because each miss asks pint; to pint an angle is a plain number and rad/s is Hz
    for kind in sorted(KINDS, key=lambda kind: -len(kind) if unit.endswith(kind) else 0):
        if (kind == "rad") == bool(_ANGLE.search(unit)):
            try:
                return kind, parse_quantity(f"1 {unit}", kind)
            except ValueError:
                continue
    return None


def _name_and_unit(heading: str) -> tuple[str, str]:
    """Split ``time [us]``; brackets that are round or stand close may belong to the name instead."""
    match = _HEADING.fullmatch(heading)
    if match is None or not match[4].strip():
        return heading, ""
    is_unit = match[2] and match[3] == "["
    return (match[1], match[4].strip()) if is_unit or _kind_and_factor(match[4].strip()) else (heading, "")


def _choose(path: Path, headings: Sequence[str], column: str | int, width: int) -> int:
    """Find a column by its number, its heading, or its heading without the unit."""
    if isinstance(column, int):
        if not 0 <= column < width:
            raise DataFileError(f"{path}: there is no column {column}; they are numbered 0 to {width - 1}.")
        return column
    if not headings:
        raise DataFileError(f"{path}: has no headings; ask for column '{column}' by its number, 0 first.")
    names = [_name_and_unit(heading)[0] for heading in headings]
    for known in (list(headings), names):
        if known.count(column) > 1:
            raise DataFileError(f"{path}: more than one column is called '{column}'; give its number.")
        if column in known:
            return known.index(column)
    listed = ", ".join([name for name in names if name][:20]) + (", ..." if len(names) > 20 else "")
    raise DataFileError(f"{path}: there is no column '{column}'.{_close(column, names)} It has: {listed}.")


@dataclass(frozen=True)
class _Column:
    """Numbers as they stand in the file."""

    label: str
    unit: str
    values: NDArray[np.float64]
    place: Callable[[int], str]

    def in_si(self, path: Path, asked: str) -> NDArray[np.float64]:
        """Check and convert."""
        if len(self.values) < 2:
            count = "only one row" if len(self.values) else "no rows"
            raise DataFileError(f"{path}: {self.label} has {count}; at least two are needed.")
        bad = np.flatnonzero(~np.isfinite(self.values))
        if len(bad):
            more = f", nor are {len(bad) - 1} more below" if len(bad) > 1 else ""
            where, value = self.place(int(bad[0])), self.values[bad[0]]
            raise DataFileError(f"{path}: {where}, {self.label}: {value} is not a finite number{more}.")
        factor = self._factor(path, asked)
        inverse = round(1 / factor) if factor < 1 else 0
        # dividing by a whole number gives the float nearest to the decimal number, multiplying does not
        return self.values / inverse if inverse and 1 / inverse == factor else self.values * factor

    def _factor(self, path: Path, asked: str) -> float:
        expected, own = _kind_and_factor(asked), _kind_and_factor(self.unit or asked)
        if expected is None or own is None:
            unknown = self.unit if expected else asked
            known = ", ".join(kind for kind in KINDS if kind != "1")
            raise DataFileError(
                f"{path}: {self.label}: '{unknown}' is not a known unit; known, also with prefixes: {known}."
            )
        if own[0] != expected[0]:
            kind = KINDS[expected[0]][0]
            raise DataFileError(
                f"{path}: {self.label} is in '{self.unit}', but {kind} is needed, such as '{asked}'."
            )
        return own[1]


# ---------------------------------------------------------------------------------- delimited text


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

    def numbers(self, indices: Sequence[int]) -> NDArray[np.float64]:
        """Read columns as (row, index); refuse rows of unequal length and what is no number."""
        rows = [line for _, line in self.rows()]
        if not rows:
            return np.empty((0, len(indices)))
        quote = '"' if any('"' in row for row in rows) else None
        if quote or self.delimiter is None:
            widths = {len(_split(row, self.delimiter)) for row in rows}
        else:
            widths = {row.count(self.delimiter) + 1 for row in rows}
        said = "rows of unequal length"
        if widths == {self.width}:
            try:
                return np.loadtxt(
                    rows, delimiter=self.delimiter, comments=None, usecols=indices, ndmin=2, quotechar=quote
                )
            except ValueError as error:
                said = str(error)
        raise DataFileError(f"{self.path}: {self._fault(indices) or said}.")

    def _fault(self, indices: Sequence[int]) -> str:
        """Look for the first fault, row by row."""
        for number, line in self.rows():
            cells = _split(line, self.delimiter)
            if len(cells) != self.width:
                first = "the headings have" if self.headings else "the first row has"
                return f"line {number} has {len(cells)} fields, but {first} {self.width}"
            for index in indices:
                cell = cells[index]
                if not _is_number(cell):
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
    known = {name for cell in top for name in (cell, _name_and_unit(cell)[0])}
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


def _from_text(path: Path, columns: Sequence[str | int]) -> dict[str | int, _Column]:
    table = read_table(path, [column for column in columns if isinstance(column, str)])
    indices = [_choose(path, table.headings, column, table.width) for column in columns]
    numbers = table.numbers(indices)

    def line(row: int) -> str:
        return f"line {next(number for i, (number, _) in enumerate(table.rows()) if i == row)}"

    found: dict[str | int, _Column] = {}
    for column, index, values in zip(columns, indices, numbers.T, strict=True):
        own = _name_and_unit(table.headings[index])[1] if table.headings else ""
        own = own or (table.units[index] if index < len(table.units) else "")
        found[column] = _Column(table.label(index), own, values.copy(), line)
    return found


# ---------------------------------------------------------------------------------- binary formats


def _real(path: Path, label: str, array: NDArray[Any], unit: str, word: str) -> _Column:
    if array.ndim != 1 or array.dtype.kind not in "fiu":
        kind = f"{array.ndim} dimensions" if array.ndim != 1 else f"'{array.dtype}'"
        raise DataFileError(f"{path}: {label} holds {kind}, but a row of real numbers is needed.")
    return _Column(label, unit, np.array(array, dtype=np.float64), lambda row: f"{word} {row} (first is 0)")


def _from_npy(path: Path, columns: Sequence[str | int]) -> dict[str | int, _Column]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NumPy warns of what it finds in a damaged header
            array = np.lib.format.open_memmap(path, mode="r")  # needs no memory for a size that is a lie
    except DAMAGE as error:
        raise damaged(path, "a NumPy file of plain numbers", error) from None
    fields = array.dtype.names or ()
    if array.ndim != (1 if fields else 2):
        raise DataFileError(
            f"{path}: holds an array of shape {array.shape}, not a row per sample and a column per signal."
        )
    width = len(fields) or array.shape[1]
    found: dict[str | int, _Column] = {}
    for column in columns:
        index = _choose(path, fields, column, width)
        label = f"column '{fields[index]}'" if fields else f"column {index}"
        values = array[fields[index]] if fields else array[:, index]
        found[column] = _real(path, label, values, _name_and_unit(fields[index])[1] if fields else "", "row")
    return found


def _from_netcdf(path: Path, columns: Sequence[str | int]) -> dict[str | int, _Column]:
    import xarray

    with path.open("rb") as file:
        engine = "scipy" if file.read(3) == b"CDF" else "h5netcdf"
    try:
        if engine == "h5netcdf":
            check_hdf5(path)
        with xarray.open_dataset(path, engine=engine, decode_times=False, decode_timedelta=False) as data:
            found = {column: _variable(path, data, column) for column in columns}
    except DAMAGE as error:
        raise damaged(path, "a netCDF file", error) from None
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{column.label} {len(column.values)}" for column in found.values())
        raise DataFileError(f"{path}: the columns differ in length: {sizes}.")
    return found


def check_hdf5(path: Path) -> None:
    """Fail early where h5netcdf would also print a traceback of its own."""
    import h5py

    with h5py.File(path, "r") as file:
        file.attrs.get("_nc3_strict")


def _variable(path: Path, data: xarray.Dataset, column: str | int) -> _Column:
    names = [str(name) for name in data.variables]
    if isinstance(column, int):
        raise DataFileError(f"{path}: ask for column {column} by its name; it has: {', '.join(names)}.")
    name = names[_choose(path, names, column, len(names))]
    own = str(data[name].attrs.get("units", "")) or _name_and_unit(name)[1]
    return _real(path, f"column '{name}'", data[name].values, own, "index")


_READERS: Final[dict[str, Callable[[Path, Sequence[str | int]], dict[str | int, _Column]]]] = {
    ".csv": _from_text,
    ".txt": _from_text,
    ".tsv": _from_text,
    ".npy": _from_npy,
    ".nc": _from_netcdf,
}
