"""Numeric arrays of HDF5 and netCDF files; the functions that read are called in a guarded process."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed
from electrovib.core.errors import DataFileError
from electrovib.data.columns.faults import check_file
from electrovib.data.columns.headings import name_and_unit
from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.readers.foreign import columns_of_array, recorded_of
from electrovib.data.readers.netcdf import reader

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    import h5py

    from electrovib.core.arrays import Real
    from electrovib.data.readers.recorded import Recorded

DESCRIPTION: Final = "netCDF and HDF5 (.nc, .h5, .hdf5): arrays of one or two dimensions"
_MOST_OBJECTS: Final = 2000
_DEEPEST: Final = 12
_UNITS: Final = ("units", "unit", "Units", "Unit")


def read_hdf5(path: Path, *, part: str = "") -> Recorded:
    """Read the arrays of a netCDF or HDF5 file that have the length with most numbers, or that of the array `part`."""
    check_file(path)
    with path.open("rb") as file:
        classic = file.read(3) == b"CDF"
    if classic:
        content = read_guarded(reader(path, "everything"), path)
        names = [key.removeprefix("about ") for key in content if key.startswith("about ")]
        table = [
            (
                name,
                str(content[f"about {name}"]["attributes"].get("units", "")),
                np.asarray(content[f"values {name}"]),
            )
            for name in names
            if not content[f"about {name}"]["text"]
        ]
    else:
        found = read_guarded(Reader(f"{__name__}:arrays", ("h5py",), "an HDF5 file"), path)
        table = [(*found[f"about {at}"], found[f"values {at}"]) for at in range(len(found) // 2)]
    columns: list[tuple[str, str, Real]] = []
    for name, unit, values in table:
        label, stated = name_and_unit(name)
        if values.dtype.kind in "fiu":
            columns += columns_of_array(label, unit or stated, values.astype(float))
    return recorded_of(path, columns, part=part)


def arrays(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield name and unit, then values, of each array of real numbers; links are not followed."""
    import h5py

    left = content_allowed(path.stat().st_size)
    with h5py.File(path, "r") as file:
        for at, (name, entry) in enumerate(_datasets(file)):
            left -= entry.size * max(entry.dtype.itemsize, 8)
            if left < 0:
                raise DataFileError(
                    "is damaged, or packed too tightly: it declares more numbers than a file of its size may hold."
                    " If it is whole, save it without compression.",
                    path=path,
                )
            unit = next((entry.attrs[key] for key in _UNITS if key in entry.attrs), "")
            unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else unit
            yield f"about {at}", [name, unit if isinstance(unit, str) else ""]
            yield f"values {at}", np.asarray(entry[()])


def _datasets(file: h5py.File) -> list[tuple[str, h5py.Dataset]]:
    """List the arrays of real numbers in a file and its groups, each object once."""
    import h5py

    found: list[tuple[str, h5py.Dataset]] = []
    waiting: list[tuple[str, h5py.Group, int]] = [("", file, 0)]
    count = 0
    while waiting:
        prefix, group, depth = waiting.pop(0)
        for name in group:
            count += 1
            if count > _MOST_OBJECTS:
                return found
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                continue
            entry = group[name]
            if isinstance(entry, h5py.Group) and depth < _DEEPEST:
                waiting.append((f"{prefix}{name}/", entry, depth + 1))
            elif isinstance(entry, h5py.Dataset) and _is_plain(entry):
                found.append((f"{prefix}{name}", entry))
    return found


def _is_plain(entry: h5py.Dataset) -> bool:
    """Return whether an array holds real numbers in this file."""
    if entry.is_virtual or entry.external or entry.shape is None or entry.dtype.kind not in "fiu":
        return False
    return 1 <= len(entry.shape) <= 2 and bool(entry.size) and bool(entry.id.get_storage_size())
