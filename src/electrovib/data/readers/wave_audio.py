"""Sound files (.wav): whole numbers or floats, sampled evenly."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.columns.faults import DAMAGE, check_file, damaged
from electrovib.data.readers.recorded import DataColumn, Recorded

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

DESCRIPTION: Final = "sound files (.wav), as shares of full scale"


def read_wave(path: Path) -> Recorded:
    """Read a sound file.

    Parameters
    ----------
    path : Path
        ``.wav`` file.

    Returns
    -------
    Recorded
        One channel for each of the file, as shares of full scale [1]: the file states no other unit.

    Raises
    ------
    DataFileError
        If the file is damaged or in a compressed form.
    """
    from scipy.io import wavfile

    check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # unknown chunks are skipped
            rate, data = wavfile.read(path, mmap=False)
    except DAMAGE as error:
        raise damaged(path, "a sound file of plain samples", error) from None
    if data.ndim > 2 or data.shape[0] < 2 or rate <= 0:
        raise DataFileError("holds fewer than two samples.", path=path)
    return Recorded(
        channels=tuple(
            DataColumn(name=f"channel {at + 1}", unit="1", values=_shares(row))
            for at, row in enumerate(np.atleast_2d(data.T))
        ),
        step=1 / rate,
    )


def _shares(row: NDArray[Any]) -> Real:
    """Scale whole numbers to full scale; floats are shares already."""
    if row.dtype.kind == "u":
        return (row.astype(float) - 128) / 128
    if row.dtype.kind == "i":
        return row.astype(float) / -float(np.iinfo(row.dtype).min)
    return row.astype(float)
