"""NumPy arrays (.npy)."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.faults import DAMAGE, damaged
from electrovib.data.recorded import MOST_COLUMNS, FileFormat, begins, choose, real_numbers, recorded_of
from electrovib.data.unit_words import name_and_known_unit, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from electrovib.data.recorded import DataColumn, Recorded

_MOST_ROWS: Final = 64
"""Rows of an array that may hold a signal each."""


def _opened(path: Path) -> np.ndarray[Any, np.dtype[Any]]:
    """Map an array into memory, which needs none for a false size; nothing is unpickled."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NumPy warns of what it finds in a damaged header
            return np.lib.format.open_memmap(path, mode="r")
    except DAMAGE as error:
        raise damaged(path, "a NumPy file of plain numbers", error) from None


def _no_table(path: Path, shape: tuple[int, ...]) -> DataFileError:
    return DataFileError(
        f"holds an array of shape {shape}, not a row per sample and a column per signal.", path=path
    )


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns of an array with a row per sample, or of a structured array."""
    del missing
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


def read_numpy(path: Path) -> Recorded:
    """Read an array of numbers, one channel for each column or field.

    An array with more columns than rows, and at most 64 rows, is taken for a row per signal, which the
    attribute ``arrangement`` states.
    """
    array, attributes = _opened(path), {}
    if fields := array.dtype.names or ():
        table = [(*name_and_unit(name), np.asarray(array[name])) for name in fields[:MOST_COLUMNS]]
    elif array.ndim in (1, 2):
        whole = array if array.ndim == 2 else array[:, None]
        if whole.shape[1] > whole.shape[0] and whole.shape[0] <= _MOST_ROWS:
            whole, attributes = whole.T, {"arrangement": "a row per signal"}
        if whole.shape[1] > MOST_COLUMNS:
            raise DataFileError(
                f"holds {whole.shape[1]} columns; at most {MOST_COLUMNS} are read.", path=path
            )
        table = [(f"column {at}", "", np.asarray(whole[:, at])) for at in range(whole.shape[1])]
    else:
        raise _no_table(path, array.shape)
    with np.errstate(all="ignore"):  # what a damaged file holds may be no number at all
        good = [
            (name, unit, values.astype(float))
            for name, unit, values in table
            if values.ndim == 1 and values.dtype.kind in "fiub"
        ]
    return recorded_of(path, good, attributes=attributes)


FORMAT: Final = FileFormat(
    name="numpy",
    description="NumPy arrays (.npy): a row per sample, or a structured array",
    can_read=begins(rb"\x93NUMPY", ".npy"),
    read=read_numpy,
    columns=read_columns,
)
