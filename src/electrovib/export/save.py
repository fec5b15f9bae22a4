"""One call to write a Trace, in the format that the file name says."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError, nearest
from electrovib.data.atomic import check_writable
from electrovib.data.traces import csv_files, save_csv, save_nc
from electrovib.export.matlab import save_mat

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray

FORMATS: Final[dict[str, Callable[[xarray.Dataset, Path], list[Path]]]] = {
    ".nc": save_nc,
    ".csv": save_csv,
    ".mat": save_mat,
}
"""Suffix to writer."""


def save(trace: xarray.Dataset, path: str | Path) -> list[Path]:
    """Write a Trace.

    Parameters
    ----------
    trace : xarray.Dataset
        Any Trace; units are stamped again.
    path : str or Path
        The output: ``.nc`` (everything, netCDF), ``.csv`` (one dimension a file) or ``.mat`` (MATLAB).

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the suffix is unknown, the file cannot be written, or the format cannot hold this Trace.
    """
    path = Path(path)
    return _writer(path)(trace, path)


def check_output(path: str | Path, sizes: Mapping[str, int]) -> None:
    """Tell, before a long computation, whether `save` will work.

    Parameters
    ----------
    path : str or Path
        The output.
    sizes : mapping of str to int
        The dimensions that the Trace will have; the sizes do not matter.

    Raises
    ------
    InputError
        As `save` would.
    """
    path = Path(path)
    _writer(path)
    check_writable(csv_files(sizes, path) if path.suffix.lower() == ".csv" else [path])


def _writer(path: Path) -> Callable[[xarray.Dataset, Path], list[Path]]:
    writer = FORMATS.get(path.suffix.lower())
    if writer is None:
        near = nearest(path.suffix.lower(), FORMATS) if path.suffix else ""
        near = near if near.startswith(" Did") else ""
        allowed = ", ".join(FORMATS)
        raise InputError(f"{path}: a Trace is saved as {allowed}, not as '{path.suffix}'.{near}")
    return writer
