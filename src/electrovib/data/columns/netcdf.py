"""Columns of a netCDF file: its variables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import Column, real_numbers

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


def from_netcdf(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    """Read variables by name; their attribute ``units`` has priority over a unit in the name."""
    from electrovib.data.guarded import read_guarded
    from electrovib.data.readers.netcdf import reader

    content = read_guarded(reader(path, "columns"), path, wanted=list(columns))
    found: dict[str | int, Column] = {}
    for column in columns:
        name, unit = content[f"{column} about"]
        found[column] = real_numbers(path, f"column '{name}'", content[f"{column} values"], unit, "index")
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{column.label} {len(column.values)}" for column in found.values())
        raise DataFileError(f"the columns differ in length: {sizes}.", path=path)
    return found
