"""Reading of columns in the format given by the suffix of the file name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.core.errors import DataFileError
from electrovib.data.columns.delimited import from_text
from electrovib.data.columns.faults import check_file
from electrovib.data.columns.netcdf import from_netcdf
from electrovib.data.columns.npy import from_npy

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from electrovib.data.columns.column import Column


def _from_matlab(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    from electrovib.data.readers.matlab import from_matlab  # which builds on the columns of this package

    return from_matlab(path, columns)


_READERS: Final[dict[str, Callable[[Path, Sequence[str | int]], dict[str | int, Column]]]] = {
    ".csv": from_text,
    ".txt": from_text,
    ".tsv": from_text,
    ".npy": from_npy,
    ".nc": from_netcdf,
    ".mat": _from_matlab,
}


def read_columns(
    path: Path, wanted: Mapping[str, tuple[str | int, str]], *, missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Read the wanted columns of a measured file, converted to SI.

    `wanted` maps a name to heading, or number from 0, and unit; a unit in the file has priority over it, and
    must be of the same kind. With `missing`, NaN, infinities and empty fields of text (as NaN) are accepted.
    Text has lines of ``#`` as comments; of a ``.mat`` file ``"name[3]"`` is column 3 of the array ``name``,
    and ``"trial.force"`` a field of a struct.
    """
    check_file(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise DataFileError(
            f"columns are read from {', '.join(_READERS)}, not from '{path.suffix}'.", path=path
        )
    columns = [column for column, _ in wanted.values()]
    # only text has empty fields
    found = from_text(path, columns, missing=missing) if reader is from_text else reader(path, columns)
    return {name: found[column].in_si(path, unit, missing=missing) for name, (column, unit) in wanted.items()}
