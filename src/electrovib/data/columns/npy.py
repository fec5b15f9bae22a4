"""Columns of a NumPy file."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import Column, real_numbers
from electrovib.data.columns.faults import DAMAGE, damaged
from electrovib.data.columns.headings import choose, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


def from_npy(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    """Read columns of an array with a row per sample, or of a structured array."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NumPy warns of what it finds in a damaged header
            array = np.lib.format.open_memmap(path, mode="r")  # needs no memory for a false size
    except DAMAGE as error:
        raise damaged(path, "a NumPy file of plain numbers", error) from None
    fields = array.dtype.names or ()
    if array.ndim != (1 if fields else 2):
        raise DataFileError(
            f"holds an array of shape {array.shape}, not a row per sample and a column per signal.", path=path
        )
    width = len(fields) or array.shape[1]
    found: dict[str | int, Column] = {}
    for column in columns:
        index = choose(path, fields, column, width)
        label = f"column '{fields[index]}'" if fields else f"column {index}"
        values = array[fields[index]] if fields else array[:, index]
        found[column] = real_numbers(
            path, label, values, name_and_unit(fields[index])[1] if fields else "", "row"
        )
    return found
