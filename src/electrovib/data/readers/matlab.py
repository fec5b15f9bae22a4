"""Numeric arrays of a MATLAB file: version 5 (-v6, -v7) and version 7.3 (HDF5)."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.allowance import content_allowed, megabytes
from electrovib.core.errors import DataFileError, suggestion
from electrovib.data.columns.column import Column, real_numbers
from electrovib.data.columns.faults import DAMAGE, check_file, damaged
from electrovib.data.readers.mat5 import Mat5

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

_COLUMN: Final = re.compile(r"(([A-Za-z]\w*(?:\.[A-Za-z]\w*)*)(?:\[(\d{1,9})\])?)(?:\s+\[([^\[\]]+)\])?")
_NUMERIC: Final = "double|single|u?int(?:8|16|32|64)"
Known = dict[str, tuple[str, tuple[int, ...], bool]]
"""Name of a variable or path of a field to its kind, its shape and whether it is a real numeric array."""


def read_matlab(path: Path, variable: str = "") -> NDArray[np.float64]:
    """Read one real numeric array of a MATLAB file.

    Parameters
    ----------
    path : Path
        Saved by MATLAB with ``-v6``, ``-v7`` or ``-v7.3``, or by another program in these formats.
    variable : str
        Its name, or the path of a field of a struct, ``"trial.force"``; may be left out if the file holds only one
        real numeric array that is no single number.

    Returns
    -------
    ndarray
        Shaped as MATLAB shows it, whatever type the numbers are stored in.

    Raises
    ------
    DataFileError
        If the file is damaged, of another format, or has no such array: the message lists what it has.
    """
    check_file(path)
    with path.open("rb") as file:
        begin = file.read(512)
    version = _version_73 if b"MATLAB 7.3" in begin[:116] or begin[:4] == b"\x89HDF" else _version_5
    try:
        return version(path, variable)
    except DAMAGE as error:
        raise damaged(path, "a MATLAB file", error) from None


def from_matlab(path: Path, columns: Sequence[str | int]) -> dict[str | int, Column]:
    """Read columns of the arrays of a MATLAB file.

    Parameters
    ----------
    path : Path
        As for `read_matlab`.
    columns : sequence of str or int
        ``"name[3]"`` is column 3, 0 first, of the array ``name``; ``"name"`` an array of one row or column; a
        number is a column of the only array in the file. A field of a struct is named by its path, ``"trial.force"``.
        A unit may follow: ``"name[3] [us]"``.

    Returns
    -------
    dict
        Of the columns asked for.

    Raises
    ------
    DataFileError
        If the file is damaged or lacks one of them.
    """
    arrays: dict[str, NDArray[np.float64]] = {}
    found: dict[str | int, Column] = {}
    for column in columns:
        wanted, name, unit = f"[{column}]", "", ""
        number = column if isinstance(column, int) else None
        if isinstance(column, str):
            match = _COLUMN.fullmatch(column)
            if match is None:
                raise DataFileError(
                    f"'{column}' names no column; write 'name[3]' for column 3, 0 first, of the array 'name'.",
                    path=path,
                )
            wanted, name, unit = match[1], match[2], match[4] or ""
            number = int(match[3]) if match[3] else None
        if name not in arrays:
            arrays[name] = read_matlab(path, name)
        found[column] = real_numbers(
            path, f"column {wanted}", _of(path, name, arrays[name], number), unit, "row"
        )
    if len({len(column.values) for column in found.values()}) > 1:
        sizes = ", ".join(f"{column.label} {len(column.values)}" for column in found.values())
        raise DataFileError(f"the columns differ in length: {sizes}.", path=path)
    return found


def _of(path: Path, name: str, array: NDArray[np.float64], number: int | None) -> NDArray[np.float64]:
    """Take a column of an array."""
    called = f"'{name}'" if name else "the array"
    shape = " x ".join(map(str, array.shape))
    if number is None:
        if array.size != max(array.shape):
            raise DataFileError(
                f"{called} is {shape}; name one of its columns, as in '{name}[0]'.", path=path
            )
        return array.ravel()
    if array.ndim != 2:
        raise DataFileError(f"{called} is {shape}, not a row per sample and a column per signal.", path=path)
    if not 0 <= number < array.shape[1]:
        turned = "; is it transposed?" if array.shape[1] > 10 * array.shape[0] else ""
        raise DataFileError(
            f"there is no column {number} in {called} ({shape}); they are numbered 0 to"
            f" {array.shape[1] - 1}{turned}.",
            path=path,
        )
    return array[:, number]


def _version_5(path: Path, wanted: str) -> NDArray[np.float64]:
    file = Mat5(path, path.read_bytes())
    entries = {variable.name: variable for variable in file.variables()}
    for name in _on_the_way(wanted, entries):
        entries |= {field.name: field for field in file.fields(entries[name])}
    known = {name: (entry.kind, entry.shape, entry.numeric) for name, entry in entries.items()}
    return file.values(entries[_chosen(path, wanted, known)])


def _version_73(path: Path, wanted: str) -> NDArray[np.float64]:
    from electrovib.data.guarded import Reader, read_guarded

    hdf5 = Reader(f"{__name__}:array_of_version_73", ("h5py",), "a MATLAB file")
    values: NDArray[np.float64] = read_guarded(hdf5, path, wanted=wanted)["values"]
    return values.T  # MATLAB counts along columns, HDF5 along rows


def array_of_version_73(path: Path, wanted: str) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield the array of a file of version 7.3 as HDF5 has it; to be called in a guarded process."""
    import h5py

    with h5py.File(path, "r") as file:
        known = _members(file)
        for name in _on_the_way(wanted, known):
            # a sparse matrix or an object is a group too, but its parts are no fields
            if known[name][0] == "struct":
                known |= _members(file[name.replace(".", "/")], f"{name}.")
        entry = file[_chosen(path, wanted, known).replace(".", "/")]
        count, size = math.prod(entry.shape), path.stat().st_size
        if count * np.dtype(np.float64).itemsize > content_allowed(size):
            raise DataFileError(
                f"is damaged, or packed too tightly: {megabytes(size)} are too small for the {count} numbers of"
                f" '{wanted}'. If it is whole, save it with -v6 or -nocompression.",
                path=path,
            )
        yield "values", np.asarray(entry[()], dtype=np.float64)


def _on_the_way(wanted: str, known: Mapping[str, object]) -> Iterator[str]:
    """Go through the structs on the path to a field, and to the last one, whose fields a message may list."""
    parts = wanted.split(".")
    for depth in range(1, len(parts) + 1):
        if (name := ".".join(parts[:depth])) in known:
            yield name


def _members(group: h5py.Group, prefix: str = "") -> Known:
    """List the members of a file of version 7.3 or of a struct in it; what lies in other files is not followed."""
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
        own = data is not None and not data.is_virtual and not data.external and data.dtype.kind in "fiu"
        numeric = bool(own and re.fullmatch(_NUMERIC, kind) and "MATLAB_empty" not in entry.attrs)
        known[prefix + name] = (kind, tuple(reversed(data.shape)) if data is not None else (), numeric)
    return known


def _chosen(path: Path, wanted: str, known: Known) -> str:
    """Find the variable that is meant, or say which there are."""

    def listed(names: Sequence[str]) -> str:
        shown = [_described(name, *known[name][:2]) for name in names[:20]]
        return ", ".join(shown) + (", ..." if len(names) > 20 else "")

    if not known:
        raise DataFileError("holds no variables.", path=path)
    outside = [name for name in known if "." not in name]
    if wanted:
        if wanted not in known:
            above = next((name for name in reversed(list(_on_the_way(wanted, known)))), "")
            if above and not (inside := _fields(known, above)):
                raise DataFileError(
                    f"'{wanted}' cannot be reached, {_unreachable(above, *known[above][:2])}", path=path
                )
            names = inside if above else outside
            near = suggestion(wanted, names)
            what = "field" if above else "variable"
            has = f"'{above}'" if above else "It"
            raise DataFileError(
                f"there is no {what} '{wanted}'.{near} {has} has: {listed(names)}.", path=path
            )
        if not known[wanted][2]:
            fields = _fields(known, wanted)
            more = f"; name one of its fields: {listed(fields)}" if fields else ""
            raise DataFileError(
                f"'{wanted}' is no real numeric array, but {listed([wanted])}{more}.", path=path
            )
        return wanted
    arrays = [name for name in outside if known[name][2] and max(known[name][1], default=0) > 1]
    if len(arrays) != 1:
        what = "no real numeric array" if not arrays else "more than one numeric array"
        how = f"; name one, as in '{arrays[0]}[0]'" if arrays else ""
        structs = [name for name in outside if known[name][0] == "struct"]
        how = how or (f"; a field of a struct is named as in '{structs[0]}.force'" if structs else "")
        raise DataFileError(f"holds {what}{how}. It has: {listed(outside)}.", path=path)
    return arrays[0]


def _described(name: str, kind: str, shape: tuple[int, ...]) -> str:
    return f"{name} ({' x '.join(map(str, shape))} {kind})" if shape else f"{name} ({kind})"


def _fields(known: Known, name: str) -> list[str]:
    """Paths of the fields of a struct."""
    depth = name.count(".") + 1
    return [path for path in known if path.startswith(f"{name}.") and path.count(".") == depth]


def _unreachable(name: str, kind: str, shape: tuple[int, ...]) -> str:
    """Say why what is on the way to a field has no fields here."""
    if kind.startswith("object of class"):
        return f"because '{name}' is an {kind}: only MATLAB reads it; save its numbers there as arrays."
    if kind == "struct" and any(size != 1 for size in shape):
        of = " x ".join(map(str, shape))
        return f"because '{name}' is an array of {of} structs: save the one that is meant on its own."
    return f"because {_described(name, kind, shape)} is no struct with fields."
