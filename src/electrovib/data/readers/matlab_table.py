"""Numeric arrays of MATLAB files as channels: variables and fields of structs by dotted path; objects are omitted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.data.columns.faults import DAMAGE, check_file, damaged
from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.readers.foreign import columns_of_array, recorded_of
from electrovib.data.readers.mat5 import Mat5
from electrovib.data.readers.mat73 import members, one_array

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.core.arrays import Real
    from electrovib.data.readers.mat5 import Mat5Variable
    from electrovib.data.readers.recorded import Recorded

DESCRIPTION: Final = "MATLAB (.mat, -v6, -v7 and -v7.3): arrays, and fields of structs by dotted path"
_DEEPEST: Final = 6
_MOST: Final = 500


def read_matlab_table(path: Path, *, part: str = "") -> Recorded:
    """Read the real numeric arrays of a MATLAB file that have the length with most numbers, or that of the array `part`."""
    check_file(path)
    with path.open("rb") as file:
        begin = file.read(512)
    try:
        if b"MATLAB 7.3" in begin[:116] or begin[:4] == b"\x89HDF":
            found = read_guarded(Reader(f"{__name__}:arrays_of_73", ("h5py",), "a MATLAB file"), path)
            table = [(name, values.T) for name, values in found.items()]
        else:
            whole = Mat5(path, path.read_bytes())
            table = [(name, whole.values(entry)) for name, entry in _entries(whole)]
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None
    columns: list[tuple[str, str, Real]] = []
    for name, values in table:
        columns += columns_of_array(name, "", np.asarray(values, dtype=float))
    return recorded_of(path, columns, part=part)


def _entries(whole: Mat5) -> Iterator[tuple[str, Mat5Variable]]:
    """Iterate over the numeric variables and fields of a file of version 5."""
    waiting = [(entry, 0) for entry in whole.variables()]
    for number, (entry, depth) in enumerate(waiting):
        if number >= _MOST:
            return
        if entry.numeric and max(entry.shape, default=0) > 1 and len(entry.shape) == 2:
            yield entry.name, entry
        elif entry.kind == "struct" and depth < _DEEPEST:
            waiting += [(field, depth + 1) for field in whole.fields(entry)]


def arrays_of_73(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the numeric arrays of a file of version 7.3, in the order of HDF5."""
    import h5py

    names = []
    with h5py.File(path, "r") as file:
        known = members(file)
        waiting = list(known)
        for number, name in enumerate(waiting):
            if number >= _MOST:
                break
            kind, shape, numeric = known[name]
            if numeric and len(shape) == 2 and max(shape) > 1:
                names.append(name)
            elif kind == "struct" and name.count(".") < _DEEPEST:
                inside = members(file[name.replace(".", "/")], f"{name}.")
                known |= inside
                waiting += inside
    for name in names:
        yield name, dict(one_array(path, name))["values"]
