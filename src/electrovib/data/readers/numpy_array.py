"""NumPy arrays (.npy)."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.faults import DAMAGE, check_file, damaged
from electrovib.data.columns.headings import name_and_unit
from electrovib.data.readers.foreign import recorded_of

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.data.readers.recorded import Recorded

DESCRIPTION: Final = "NumPy arrays (.npy): a row per sample, or a structured array"
_MOST: Final = 1024


def read_numpy(path: Path) -> Recorded:
    """Read an array of numbers, one channel for each column or field; nothing is unpickled.

    An array with more columns than rows, and at most 64 rows, is taken for a row per signal, which the
    attribute ``arrangement`` states.
    """
    check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # NumPy warns of what it finds in a damaged header
            array = np.lib.format.open_memmap(path, mode="r")  # needs no memory for a false size
            fields = array.dtype.names or ()
            attributes = {}
            if fields:
                table = [(*name_and_unit(name), np.asarray(array[name])) for name in fields[:_MOST]]
            elif array.ndim in (1, 2):
                whole = array if array.ndim == 2 else array[:, None]
                if whole.shape[1] > whole.shape[0] and whole.shape[0] <= 64:
                    whole, attributes = whole.T, {"arrangement": "a row per signal"}
                if whole.shape[1] > _MOST:
                    raise DataFileError(
                        f"holds {whole.shape[1]} columns; at most {_MOST} are read.", path=path
                    )
                table = [(f"column {at}", "", np.asarray(whole[:, at])) for at in range(whole.shape[1])]
            else:
                raise DataFileError(
                    f"holds an array of shape {array.shape}, not a row per sample and a column per signal.",
                    path=path,
                )
            good = [
                (name, unit, values.astype(float))
                for name, unit, values in table
                if values.ndim == 1 and values.dtype.kind in "fiub"
            ]
    except DAMAGE as error:
        raise damaged(path, "a NumPy file of plain numbers", error) from None
    return recorded_of(path, good, attributes=attributes)
