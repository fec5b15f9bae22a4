"""Numeric arrays of a MATLAB file: version 5 (-v6, -v7) and version 7.3 (HDF5)."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import Column, real_numbers
from electrovib.data.columns.faults import DAMAGE, check_file, damaged
from electrovib.data.guarded import read_guarded
from electrovib.data.readers import mat73
from electrovib.data.readers.mat5 import Mat5
from electrovib.data.readers.mat_choice import chosen, structs_on_path

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

_COLUMN: Final = re.compile(r"(([A-Za-z]\w*(?:\.[A-Za-z]\w*)*)(?:\[(\d{1,9})\])?)(?:\s+\[([^\[\]]+)\])?")


def read_matlab(path: Path, variable: str = "") -> NDArray[np.float64]:
    """Read one real numeric array of a MATLAB file, in the shape that MATLAB shows.

    `variable` may be the path of a field of a struct, ``"trial.force"``; it may be omitted if the file holds
    only one real numeric array that is no single number.
    """
    version = _version_73 if _is_version_73(path) else _version_5
    try:
        return version(path, variable)
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None


def read_variables(path: Path, names: Collection[str]) -> dict[str, NDArray[Any] | str]:
    """Read those of the named variables that a MATLAB file has: arrays of real or complex numbers, and rows of characters."""
    version = _variables_of_version_73 if _is_version_73(path) else _variables_of_version_5
    try:
        return version(path, names)
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None


def _is_version_73(path: Path) -> bool:
    check_file(path)
    with path.open("rb") as file:
        begin = file.read(512)
    return b"MATLAB 7.3" in begin[:116] or begin[:4] == b"\x89HDF"


def from_matlab(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    """Read columns of the arrays of a MATLAB file: ``"name[3]"`` is column 3, from 0, and ``"trial.force"`` a field."""
    arrays: dict[str, NDArray[np.float64]] = {}
    found: dict[str | int, Column] = {}
    for column in columns:
        wanted, name, unit = f"[{column}]", "", ""
        number = column if isinstance(column, int) else None
        if isinstance(column, str):
            match = _COLUMN.fullmatch(column)
            if match is None:
                raise DataFileError(
                    f"'{column}' names no column; write 'name[3]' for column 3, 0 first, of the array 'name'.",
                    path=path,
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
        raise DataFileError(f"the columns differ in length: {sizes}.", path=path)
    return found


def _of(path: Path, name: str, array: NDArray[np.float64], number: int | None) -> NDArray[np.float64]:
    called = f"'{name}'" if name else "the array"
    shape = " x ".join(map(str, array.shape))
    if number is None:
        if array.size != max(array.shape):
            raise DataFileError(
                f"{called} is {shape}; name one of its columns, as in '{name}[0]'.", path=path
            )
        return array.ravel()
    if array.ndim != 2:
        raise DataFileError(f"{called} is {shape}, not a row per sample and a column per signal.", path=path)
    if not 0 <= number < array.shape[1]:
        turned = "; is it transposed?" if array.shape[1] > 10 * array.shape[0] else ""
        raise DataFileError(
            f"there is no column {number} in {called} ({shape}); they are numbered 0 to"
            f" {array.shape[1] - 1}{turned}.",
            path=path,
        )
    return array[:, number]


def _version_5(path: Path, wanted: str) -> NDArray[np.float64]:
    file = Mat5(path, path.read_bytes())
    entries = {variable.name: variable for variable in file.variables()}
    for name in structs_on_path(wanted, entries):
        entries |= {field.name: field for field in file.fields(entries[name])}
    known = {name: (entry.kind, entry.shape, entry.numeric) for name, entry in entries.items()}
    return file.values(entries[chosen(path, wanted, known)])


def _version_73(path: Path, wanted: str) -> NDArray[np.float64]:
    values: NDArray[np.float64] = read_guarded(mat73.reader("one_array"), path, wanted=wanted)["values"]
    return values.T  # MATLAB counts along columns, HDF5 along rows


def _variables_of_version_5(path: Path, names: Collection[str]) -> dict[str, NDArray[Any] | str]:
    file = Mat5(path, path.read_bytes())
    found: dict[str, NDArray[Any] | str] = {}
    for variable in file.variables():
        if variable.name in names and variable.kind == "char":
            found[variable.name] = file.text(variable)
        elif variable.name in names and variable.kind.startswith("complex "):
            found[variable.name] = file.complex_values(variable)
        elif variable.name in names and variable.numeric:
            found[variable.name] = file.values(variable)
    return found


def _variables_of_version_73(path: Path, names: Collection[str]) -> dict[str, NDArray[Any] | str]:
    found = read_guarded(mat73.reader("whole_variables"), path, names=[*names])
    return {name: value if isinstance(value, str) else value.T for name, value in found.items()}
