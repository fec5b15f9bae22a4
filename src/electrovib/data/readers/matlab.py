"""Numeric arrays of a MATLAB file: version 5 (-v6, -v7) and version 7.3 (HDF5)."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import Column, real_numbers
from electrovib.data.columns.faults import DAMAGE, check_file, damaged, suggestion
from electrovib.data.readers.mat5 import Mat5

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

_COLUMN: Final = re.compile(r"(([A-Za-z]\w*)(?:\[(\d{1,9})\])?)(?:\s+\[([^\[\]]+)\])?")
_NUMERIC: Final = "double|single|u?int(?:8|16|32|64)"


def read_matlab(path: Path, variable: str = "") -> NDArray[np.float64]:
    """Read one real numeric array of a MATLAB file.

    Parameters
    ----------
    path : Path
        Saved by MATLAB with ``-v6``, ``-v7`` or ``-v7.3``, or by another program in these formats.
    variable : str
        Its name; may be left out if the file holds only one real numeric array that is no single number.

    Returns
    -------
    ndarray
        Shaped as MATLAB shows it, whatever type the numbers are stored in.

    Raises
    ------
    DataFileError
        If the file is damaged, of another format, or has no such array: the message lists what it has.
    """
    check_file(path)
    with path.open("rb") as file:
        begin = file.read(512)
    version = _version_73 if b"MATLAB 7.3" in begin[:116] or begin[:4] == b"\x89HDF" else _version_5
    try:
        return version(path, variable)
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None


def from_matlab(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    """Read columns of the arrays of a MATLAB file.

    Parameters
    ----------
    path : Path
        As for `read_matlab`.
    columns : sequence of str or int
        ``"name[3]"`` is column 3, 0 first, of the array ``name``; ``"name"`` an array of one row or column; a
        number is a column of the only array in the file. A unit may follow: ``"name[3] [us]"``.

    Returns
    -------
    dict
        Of the columns asked for.

    Raises
    ------
    DataFileError
        If the file is damaged or lacks one of them.
    """
    arrays: dict[str, NDArray[np.float64]] = {}
    found: dict[str | int, Column] = {}
    for column in columns:
        wanted, name, unit = f"[{column}]", "", ""
        number = column if isinstance(column, int) else None
        if isinstance(column, str):
            match = _COLUMN.fullmatch(column)
            if match is None:
                raise DataFileError(
                    f"{path}: '{column}' names no column; write 'name[3]' for column 3, 0 first, of the array 'name'."
                )
            wanted, name, unit = match[1], match[2], match[4] or ""
            number = int(match[3]) if match[3] else None
        if name not in arrays:
            arrays[name] = read_matlab(path, name)
        found[column] = real_numbers(
            path, f"column {wanted}", _of(path, name, arrays[name], number), unit, "row"
        )
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{column.label} {len(column.values)}" for column in found.values())
        raise DataFileError(f"{path}: the columns differ in length: {sizes}.")
    return found


def _of(path: Path, name: str, array: NDArray[np.float64], number: int | None) -> NDArray[np.float64]:
    """Take a column of an array."""
    called = f"'{name}'" if name else "the array"
    shape = " x ".join(map(str, array.shape))
    if number is None:
        if array.size != max(array.shape):
            raise DataFileError(f"{path}: {called} is {shape}; name one of its columns, as in '{name}[0]'.")
        return array.ravel()
    if array.ndim != 2:
        raise DataFileError(f"{path}: {called} is {shape}, not a row per sample and a column per signal.")
    if not 0 <= number < array.shape[1]:
        turned = "; is it transposed?" if array.shape[1] > 10 * array.shape[0] else ""
        raise DataFileError(
            f"{path}: there is no column {number} in {called} ({shape}); they are numbered 0 to"
            f" {array.shape[1] - 1}{turned}."
        )
    return array[:, number]


def _version_5(path: Path, wanted: str) -> NDArray[np.float64]:
    file = Mat5(path, path.read_bytes())
    entries = {variable.name: variable for variable in file.variables()}
    known = {name: (entry.kind, entry.shape, entry.numeric) for name, entry in entries.items()}
    return file.values(entries[_chosen(path, wanted, known)])


def _version_73(path: Path, wanted: str) -> NDArray[np.float64]:
    import h5py

    with h5py.File(path, "r") as file:
        known = {}
        for name, entry in file.items():
            if not name.startswith("#"):
                shape = entry.shape if isinstance(entry, h5py.Dataset) else ()
                kind = entry.attrs.get("MATLAB_class", b"")
                kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
                kind = kind or ("double" if isinstance(entry, h5py.Dataset) else "struct")
                plain = isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiu"
                numeric = bool(plain and re.fullmatch(_NUMERIC, kind) and "MATLAB_empty" not in entry.attrs)
                known[name] = (kind, tuple(reversed(shape)), numeric)
        # MATLAB counts along columns, HDF5 along rows
        return np.array(file[_chosen(path, wanted, known)][()], dtype=np.float64).T


def _chosen(path: Path, wanted: str, known: dict[str, tuple[str, tuple[int, ...], bool]]) -> str:
    """Find the variable that is meant, or say which there are."""

    def listed(names: Sequence[str]) -> str:
        shown = [f"{name} ({' x '.join(map(str, known[name][1]))} {known[name][0]})" for name in names[:20]]
        return ", ".join(shown) + (", ..." if len(names) > 20 else "")

    if not known:
        raise DataFileError(f"{path}: holds no variables.")
    if wanted:
        if wanted not in known:
            near = suggestion(wanted, list(known))
            raise DataFileError(
                f"{path}: there is no variable '{wanted}'.{near} It has: {listed(list(known))}."
            )
        if not known[wanted][2]:
            raise DataFileError(f"{path}: '{wanted}' is no real numeric array, but {listed([wanted])}.")
        return wanted
    arrays: list[str] = [
        name for name, (_, shape, numeric) in known.items() if numeric and max(shape, default=0) > 1
    ]
    if len(arrays) != 1:
        what = "no real numeric array" if not arrays else "more than one numeric array"
        how = f"; name one, as in '{arrays[0]}[0]'" if arrays else ""
        raise DataFileError(f"{path}: holds {what}{how}. It has: {listed(list(known))}.")
    return arrays[0]
