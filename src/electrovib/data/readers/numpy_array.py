"""NumPy arrays (.npy), and archives of them (.npz)."""

from __future__ import annotations

import warnings
import zipfile
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.array_columns import chosen_columns, table_of_arrays
from electrovib.data.faults import DAMAGE, damaged, packed
from electrovib.data.recorded import MOST_COLUMNS, CanRead, FileFormat, choose, real_numbers
from electrovib.data.unit_words import name_and_known_unit, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from electrovib.data.recorded import DataColumn, Recorded

_OBJECTS: Final = (
    "holds Python objects, which are not unpickled; save it as numbers, such as with array.astype(float)"
)
_MOST_ROWS: Final = 64
"""Rows of an array that may hold a signal each."""


def _opened(path: Path) -> NDArray[Any]:
    """Map an array into memory, which needs none for a false size; nothing is unpickled."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NumPy warns of what it finds in a damaged header
            return np.lib.format.open_memmap(path, mode="r")
    except DAMAGE as error:
        if "Python objects" in str(error):
            raise DataFileError(f"{_OBJECTS}.", path=path) from None
        raise damaged(path, "a NumPy file of plain numbers", error) from None


def _is_archive(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(2) == b"PK"


def _in_archive(path: Path) -> Iterator[tuple[str, str, NDArray[Any] | str]]:
    """Iterate over the arrays of a ``.npz`` file, which may not unfold to more than its size allows."""
    try:
        with zipfile.ZipFile(path) as archive:
            unfolded, size = sum(each.file_size for each in archive.infolist()), path.stat().st_size
            if unfolded > content_allowed(size):
                raise packed(path, f"{megabytes(size)} would unfold to {megabytes(unfolded)}")
            for name in archive.namelist():
                label, unit = name_and_unit(name.removesuffix(".npy"))
                with archive.open(name) as file:
                    try:
                        yield label, unit, np.lib.format.read_array(file)
                    except ValueError as error:
                        if "Object arrays" not in str(error):
                            raise
                        yield label, unit, _OBJECTS
    except (*DAMAGE, zipfile.BadZipFile) as error:
        raise damaged(path, "a NumPy file of arrays", error) from None


def _no_table(path: Path, shape: tuple[int, ...]) -> DataFileError:
    return DataFileError(
        f"holds an array of shape {shape}, not a row per sample and a column per signal.", path=path
    )


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns of an array with a row per sample, of a structured array, or of an archive."""
    del missing
    if _is_archive(path):
        return chosen_columns(path, _in_archive(path), columns)
    array = _opened(path)
    fields = array.dtype.names or ()
    if array.ndim != (1 if fields else 2):
        raise _no_table(path, array.shape)
    found: dict[str | int, DataColumn] = {}
    for column in columns:
        index = choose(path, fields, column, len(fields) or array.shape[1])
        label = f"column '{fields[index]}'" if fields else f"column {index}"
        values = array[fields[index]] if fields else array[:, index]
        unit = name_and_known_unit(fields[index])[1] if fields else ""
        found[column] = real_numbers(path, label, values, unit)
    return found


def read_numpy(path: Path, *, part: str = "") -> Recorded:
    """Read an array of numbers, one channel for each column or field, or the arrays of an archive.

    An array with more columns than rows, and at most 64 rows, is taken for a row per signal, which the
    attribute ``arrangement`` states.
    """
    if _is_archive(path):
        return table_of_arrays(path, _in_archive(path), part=part)
    array, attributes = _opened(path), {}
    if fields := array.dtype.names or ():
        table = [(*name_and_unit(name), np.asarray(array[name])) for name in fields[:MOST_COLUMNS]]
    elif array.ndim in (1, 2):
        whole = array if array.ndim == 2 else array[:, None]
        if whole.shape[1] > whole.shape[0] and whole.shape[0] <= _MOST_ROWS:
            whole, attributes = whole.T, {"arrangement": "a row per signal: column 0 is the first row"}
        if whole.shape[1] > MOST_COLUMNS:
            raise DataFileError(
                f"holds {whole.shape[1]} columns; at most {MOST_COLUMNS} are read.", path=path
            )
        table = [(f"column {at}", "", np.asarray(whole[:, at])) for at in range(whole.shape[1])]
    else:
        raise _no_table(path, array.shape)
    return table_of_arrays(path, table, attributes=attributes)


def _can_read(head: bytes, suffix: str) -> CanRead:
    if head.startswith(b"\x93NUMPY") or (head.startswith(b"PK") and b".npy" in head):
        return CanRead.YES
    return CanRead.PERHAPS if suffix in (".npy", ".npz") else CanRead.NO


FORMAT: Final = FileFormat(
    name="numpy",
    description="NumPy arrays (.npy, .npz): a row per sample, a structured array, or several arrays",
    can_read=_can_read,
    read=read_numpy,
    columns=read_columns,
    options=("part",),
)
