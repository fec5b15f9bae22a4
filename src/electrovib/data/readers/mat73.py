"""MATLAB files of version 7.3, which are HDF5; to be called in a guarded process."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.guarded import Reader
from electrovib.data.readers.mat_choice import Known, chosen, structs_on_path

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

_NUMERIC: Final = "double|single|u?int(?:8|16|32|64)"
_COMPLEX: Final = ("real", "imag")


def reader(function: str) -> Reader:
    """Return a function of this module as a reader."""
    return Reader(f"{__name__}:{function}", ("h5py",), "a MATLAB file")


def one_array(path: Path, wanted: str) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield the selected real array, in the order of HDF5."""
    import h5py

    with h5py.File(path, "r") as file:
        known = members(file)
        for name in structs_on_path(wanted, known):
            # a sparse matrix or an object is a group too, but its parts are no fields
            if known[name][0] == "struct":
                known |= members(file[name.replace(".", "/")], f"{name}.")
        entry = file[chosen(path, wanted, known).replace(".", "/")]
        _check_size(path, wanted, entry, 8)
        yield "values", np.asarray(entry[()], dtype=np.float64)


def whole_variables(path: Path, names: Collection[str]) -> Iterator[tuple[str, NDArray[Any] | str]]:
    """Yield real and complex arrays, in the order of HDF5, and rows of characters; other kinds are omitted."""
    import h5py

    with h5py.File(path, "r") as file:
        known = members(file)
        for name in (name for name in names if name in known):
            entry, (kind, shape, numeric) = file[name], known[name]
            if numeric:
                _check_size(path, name, entry, 8)
                yield name, np.asarray(entry[()], dtype=np.float64)
            elif kind == "char" and _is_own(entry) and entry.dtype.kind == "u":
                _check_size(path, name, entry, 2)
                yield name, np.asarray(entry[()], dtype="<u2").tobytes().decode("utf-16-le")
            elif re.fullmatch(_NUMERIC, kind) and _is_own(entry) and entry.dtype.names == _COMPLEX:
                _check_size(path, name, entry, 16)
                whole, parts = np.empty(tuple(reversed(shape)), np.complex128), entry[()]
                whole.real, whole.imag = parts["real"], parts["imag"]
                yield name, whole


def _check_size(path: Path, name: str, entry: h5py.Dataset, each: int) -> None:
    count, size = math.prod(entry.shape), path.stat().st_size
    if count * each > content_allowed(size):
        raise DataFileError(
            f"is damaged, or packed too tightly: {megabytes(size)} are too small for the {count} numbers of"
            f" '{name}'. If it is whole, save it with -v6 or -nocompression.",
            path=path,
        )


def _is_own(data: h5py.Dataset) -> bool:
    """Return whether the numbers are in this file, and not in another one, which could be any file of the computer."""
    return not data.is_virtual and not data.external and "MATLAB_empty" not in data.attrs


def members(group: h5py.Group, prefix: str = "") -> Known:
    """List the members of a file of version 7.3 or of a struct in it; links to other files are not followed."""
    import h5py

    known: Known = {}
    for name in group:
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        entry = group[name]
        data = entry if isinstance(entry, h5py.Dataset) else None
        kind = entry.attrs.get("MATLAB_class", b"")
        kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
        if "MATLAB_object_decode" in entry.attrs and kind not in ("", "function_handle"):
            kind = f"object of class {kind}"
        elif data is not None and h5py.check_ref_dtype(data.dtype) is not None and not kind:
            kind = "field of an array of structs"
        kind = kind or ("double" if data is not None else "struct")
        own = data is not None and _is_own(data) and data.dtype.kind in "fiu"
        numeric = bool(own and re.fullmatch(_NUMERIC, kind))
        known[prefix + name] = (kind, tuple(reversed(data.shape)) if data is not None else (), numeric)
    return known
