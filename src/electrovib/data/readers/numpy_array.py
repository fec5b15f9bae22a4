"""NumPy arrays (.npy), and archives of them (.npz)."""

from __future__ import annotations

import warnings
import zipfile
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.array_columns import chosen_columns, table_of_arrays
from electrovib.data.guarded import DAMAGE, damaged, packed
from electrovib.data.recorded import MOST_COLUMNS, FileFormat, begins
from electrovib.data.unit_words import name_and_unit

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
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
            raise DataFileError(f"{_OBJECTS}.") from None
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


def _arrays(path: Path) -> tuple[Iterable[tuple[str, str, NDArray[Any] | str]], dict[str, str]]:
    """Return the arrays of an archive, or the columns of an array, and how that is arranged.

    An array with more columns than rows, and at most 64 rows, is taken for a row per signal.
    """
    if _is_archive(path):
        return _in_archive(path), {}
    array = _opened(path)
    if fields := array.dtype.names or ():
        return [(*name_and_unit(name), array[name]) for name in fields[:MOST_COLUMNS]], {}
    if array.ndim not in (1, 2):
        why = f"holds an array of shape {array.shape}, not a row per sample and a column per signal."
        raise DataFileError(why)
    whole = array if array.ndim == 2 else array[:, None]
    turned = whole.shape[1] > whole.shape[0] and whole.shape[0] <= _MOST_ROWS
    whole = whole.T if turned else whole
    if whole.shape[1] > MOST_COLUMNS:
        raise DataFileError(f"holds {whole.shape[1]} columns; at most {MOST_COLUMNS} are read.")
    columns = [(f"column {at}", "", whole[:, at]) for at in range(whole.shape[1])]
    return columns, {"arrangement": "a row per signal: column 0 is the first row"} if turned else {}


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns of an array, by number, of a structured array, or of an archive."""
    del missing
    return chosen_columns(_arrays(path)[0], columns, are_numbered=not _is_archive(path))


def read_numpy(path: Path, *, part: str = "") -> Recorded:
    """Read an array of numbers, one channel for each column or field, or the arrays of an archive."""
    arrays, attributes = _arrays(path)
    return table_of_arrays(arrays, part=part, attributes=attributes)


FORMAT: Final = FileFormat(
    name="numpy",
    description="NumPy arrays (.npy, .npz): a row per sample, a structured array, or several arrays",
    can_read=begins(rb"\x93NUMPY|PK.*\.npy", ".npy", ".npz"),
    read=read_numpy,
    columns=read_columns,
    options=("part",),
)
