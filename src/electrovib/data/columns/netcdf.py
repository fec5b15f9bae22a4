"""Columns of a netCDF file: its variables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import Column, real_numbers
from electrovib.data.columns.faults import DAMAGE, damaged
from electrovib.data.columns.headings import choose, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import xarray


def from_netcdf(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    """Read variables by name; their attribute ``units`` comes before a unit in the name.

    Raises
    ------
    DataFileError
        If the file is damaged, lacks a variable, or the variables differ in length.
    """
    import xarray

    with path.open("rb") as file:
        engine = "scipy" if file.read(3) == b"CDF" else "h5netcdf"
    try:
        if engine == "h5netcdf":
            check_hdf5(path)
        with xarray.open_dataset(path, engine=engine, decode_times=False, decode_timedelta=False) as data:
            found = {column: _variable(path, data, column) for column in columns}
    except DAMAGE as error:
        raise damaged(path, "a netCDF file", error) from None
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{column.label} {len(column.values)}" for column in found.values())
        raise DataFileError(f"{path}: the columns differ in length: {sizes}.")
    return found


def check_hdf5(path: Path) -> None:
    """Fail early where h5netcdf would also print a traceback of its own."""
    import h5py

    with h5py.File(path, "r") as file:
        file.attrs.get("_nc3_strict")


def _variable(path: Path, data: xarray.Dataset, column: str | int) -> Column:
    names = [str(name) for name in data.variables]
    if isinstance(column, int):
        raise DataFileError(f"{path}: ask for column {column} by its name; it has: {', '.join(names)}.")
    name = names[choose(path, names, column, len(names))]
    own = str(data[name].attrs.get("units", "")) or name_and_unit(name)[1]
    return real_numbers(path, f"column '{name}'", data[name].values, own, "index")
