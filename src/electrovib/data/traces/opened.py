"""Reading of a Trace in the format given by the suffix of the file name."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from electrovib.core.errors import DataFileError
from electrovib.core.files import note_input
from electrovib.data.faults import check_file
from electrovib.data.traces.comma_separated import load_csv
from electrovib.data.traces.matlab import load_mat
from electrovib.data.traces.netcdf import load_nc

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

FORMATS: Final[dict[str, Callable[[Path], xarray.Dataset]]] = {
    ".nc": load_nc,
    ".csv": load_csv,
    ".mat": load_mat,
}
"""Maps a suffix to its reader."""

_FORMER: Final = "lamps"
"""Attribute of Traces that commits up to 74849e5d could read; their models and parameters have other names since."""


Source = TypeVar("Source")


def is_trace_file(source: object) -> bool:
    """Return whether something is, by its suffix, the name of a file of a Trace."""
    return isinstance(source, (str, os.PathLike)) and Path(source).suffix.lower() in FORMATS


def open_if_trace(source: Source) -> Source | xarray.Dataset:
    """Open a file of a Trace, and return anything else unchanged."""
    return open_trace(source) if is_trace_file(source) else source  # type: ignore[arg-type]  # it is a name


def open_trace(path: str | Path) -> xarray.Dataset:
    """Read a Trace, computed or measured.

    Parameters
    ----------
    path : str or Path
        File written by `electrovib.save`: ``.nc``, ``.csv`` (the main file of one or two) or ``.mat``.

    Returns
    -------
    xarray.Dataset
        Trace in memory, identical to the one that was saved, with attributes by their present names.

    Raises
    ------
    DataFileError
        If there is no such file, if it is damaged, or if it holds no Trace.
    """
    place = Path(path)
    note_input(place)
    reader = FORMATS.get(place.suffix.lower())
    if reader is None:
        if place.suffix or place.is_dir():
            check_file(place)
        raise DataFileError(
            f"a Trace is opened from {', '.join(FORMATS)}, not from '{place.suffix or place}'; 'electrovib run' makes one of a"
            " scenario, which electrovib.load reads",
            path=place,
        )
    trace = reader(place)
    if _FORMER in trace.attrs:
        raise DataFileError(
            "was written when models and parameters had other names, and is read by electrovib up to commit 74849e5d; compute"
            " it again from its scenario, or read its numbers with xarray",
            path=place,
        )
    return trace
