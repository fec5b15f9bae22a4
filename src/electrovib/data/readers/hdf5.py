"""Files of netCDF (of version 4, which is HDF5, and of the classic one) and HDF5: variables, and arrays in groups.

What looks into a file is called in a guarded process.
"""

from __future__ import annotations

import functools
import math
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.faults import packed
from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.recorded import (
    CanRead,
    FileFormat,
    check_row,
    choose,
    columns_of_array,
    real_numbers,
    recorded_of,
)
from electrovib.data.unit_words import name_and_known_unit, name_and_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn, Recorded

_CLASSIC: Final = b"CDF"
_OF_THE_FORMAT: Final = {
    "CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "DIMENSION_LABELS", "_Netcdf4Dimid", "_Netcdf4Coordinates",
    "_nc3_strict", "_NCProperties",
}  # fmt: skip
"""Attributes that the format itself needs."""
_NO_VARIABLE: Final = "This is a netCDF dimension but not a netCDF variable"
_UNITS: Final = ("units", "unit", "Units", "Unit")
_MOST_OBJECTS: Final = 2000
_DEEPEST: Final = 12


def reader(path: Path, function: str) -> Reader:
    """Return a function of this module as a reader, with the library that the file needs."""
    with path.open("rb") as file:
        needs = ("scipy.io",) if file.read(3) == _CLASSIC else ("h5py",)
    return Reader(f"{__name__}:{function}", needs, "a netCDF file")


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read variables by name; their attribute ``units`` has priority over a unit in the name."""
    del missing
    content = read_guarded(reader(path, "chosen"), path, wanted=list(columns))
    return {
        column: real_numbers(path, f"column '{name}'", values, unit, "index")
        for (column, name, unit), values in content.items()
    }


def read_hdf5(path: Path, *, part: str = "") -> Recorded:
    """Read the arrays of a netCDF or HDF5 file that have the length with most numbers, or that of the array `part`."""
    columns: list[tuple[str, str, Real]] = []
    for (name, unit), values in read_guarded(reader(path, "arrays"), path).items():
        label, stated = name_and_unit(name)
        columns += columns_of_array(label, unit or stated, values.astype(float))
    return recorded_of(path, columns, part=part)


@dataclass(frozen=True, kw_only=True)
class NetcdfVariable:
    """A variable that is not yet read.

    The type is ``object`` for texts. `attributes` returns all attributes, or those with the given names,
    `dimensions` the names of the dimensions, and `read` the numbers, or the texts as nested lists. `refusal`
    is the reason why the variable must not be read; empty if it may be read.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: Callable[..., dict[str, Any]]
    dimensions: Callable[[], list[str]]
    read: Callable[[], NDArray[Any] | list[Any] | str]
    refusal: str = ""
    is_stored: bool = True


def chosen(path: Path, wanted: Sequence[str | int]) -> Iterator[tuple[Any, Any]]:
    """Yield each column with its name and unit, and its values, decoded by the conventions for packed and missing numbers."""
    with _opened(path) as (variables, _):
        names = list(variables)
        for column in wanted:
            if isinstance(column, int):
                raise DataFileError(
                    f"ask for column {column} by its name; it has: {', '.join(names)}.", path=path
                )
            name = names[choose(path, names, column, len(names))]
            variable = _allowed(path, variables[name])
            check_row(path, f"column '{name}'", len(variable.shape), variable.dtype)
            values = _whole(path, name, variable)
            assert isinstance(values, np.ndarray)
            attributes = variable.attributes()
            unit = str(attributes.get("units", "")) or name_and_known_unit(name)[1]
            yield (column, name, unit), _decoded(values, attributes)


def everything(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the attributes of the file, and for each variable its dimensions, attributes and values."""
    with _opened(path) as (variables, attributes):
        yield "attributes", attributes
        for name, variable in variables.items():
            _allowed(path, variable)
            about = {"dims": variable.dimensions(), "attributes": variable.attributes()}
            yield f"about {name}", about | {"shape": variable.shape, "text": variable.dtype.kind in "OSU"}
            yield f"values {name}", _whole(path, name, variable)


def arrays(path: Path) -> Iterator[tuple[Any, Any]]:
    """Yield name and unit, and the values, of each array of real numbers of one or two dimensions, also in groups."""
    left = content_allowed(path.stat().st_size)
    with _opened(path, deepest=_DEEPEST) as (variables, _):
        plain = {name: each for name, each in variables.items() if _is_plain(each)}
        for name, variable in plain.items():
            left -= math.prod(variable.shape) * max(variable.dtype.itemsize, 8)
            if left < 0:
                raise packed(path, "it declares more numbers than a file of its size may hold")
            stated = variable.attributes(_UNITS)
            unit = next((stated[key] for key in _UNITS if key in stated), "")
            yield (name, unit if isinstance(unit, str) else ""), variable.read()


def _is_plain(variable: NetcdfVariable) -> bool:
    """Return whether a variable holds real numbers of this file in one or two dimensions."""
    is_number = variable.dtype.kind in "fiu" and not variable.refusal and variable.is_stored
    return is_number and 1 <= len(variable.shape) <= 2 and 0 not in variable.shape


def _allowed(path: Path, variable: NetcdfVariable) -> NetcdfVariable:
    if variable.refusal:
        raise DataFileError(f"{variable.refusal}", path=path)
    return variable


def _whole(path: Path, name: str, variable: NetcdfVariable) -> NDArray[Any] | list[Any] | str:
    """Read a variable after its declared size has been checked."""
    declared, size = math.prod(variable.shape) * variable.dtype.itemsize, path.stat().st_size
    if declared > content_allowed(size):
        raise packed(path, f"'{name}' declares {megabytes(declared)} in a file of {megabytes(size)}")
    return variable.read()


@contextmanager
def _opened(path: Path, deepest: int = 0) -> Iterator[tuple[dict[str, NetcdfVariable], dict[str, Any]]]:
    """Open a file; yield its variables, of HDF5 also those in groups up to a depth, and its attributes."""
    with path.open("rb") as file:
        classic = file.read(3) == _CLASSIC
    if classic:
        import scipy.io

        with scipy.io.netcdf_file(path, "r", mmap=False, maskandscale=False) as old:
            found = {name: _of_classic(entry) for name, entry in old.variables.items()}
            yield found, _attributes(old._attributes)  # noqa: SLF001  # there is no other access
        return
    import h5py

    with h5py.File(path, "r") as new:
        yield dict(_in_groups(new, deepest)), _attributes(new.attrs)


def _of_classic(entry: Any) -> NetcdfVariable:
    return NetcdfVariable(
        shape=tuple(entry.shape),
        dtype=np.dtype(object) if entry.data.dtype.kind == "S" else entry.data.dtype,
        attributes=functools.partial(_attributes, entry._attributes),  # noqa: SLF001
        dimensions=lambda: list(entry.dimensions),
        read=lambda: entry.data,
    )


def _in_groups(file: h5py.File, deepest: int) -> Iterator[tuple[str, NetcdfVariable]]:
    """Iterate over the variables of a file, those of a group before those of the groups in it; links are not followed."""
    import h5py

    waiting: list[tuple[str, h5py.Group, int]] = [("", file, 0)]
    count = 0
    for prefix, group, depth in waiting:
        for name in group:
            count += 1
            if deepest and count > _MOST_OBJECTS:
                return
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                yield f"{prefix}{name}", _elsewhere(name)
                continue
            entry = group[name]
            if isinstance(entry, h5py.Group) and depth < deepest:
                waiting.append((f"{prefix}{name}/", entry, depth + 1))
            elif isinstance(entry, h5py.Dataset) and not _text(entry.attrs.get("NAME", "")).startswith(
                _NO_VARIABLE
            ):
                yield f"{prefix}{name}", _dataset(file, name, entry)


def _elsewhere(name: str) -> NetcdfVariable:
    """Return a variable that refuses to be read, for numbers in another file, which could be any file of the computer."""
    refusal = f"'{name}' is a link to another place, which is not followed; copy its numbers into this file."
    return NetcdfVariable(
        shape=(), dtype=np.dtype(object), attributes=dict, dimensions=list, read=str, refusal=refusal
    )


def _dataset(file: h5py.File, name: str, entry: h5py.Dataset) -> NetcdfVariable:
    import h5py

    if entry.external or entry.is_virtual:
        return _elsewhere(name)
    text = h5py.check_string_dtype(entry.dtype) is not None
    stored = not entry.size or bool(entry.id.get_storage_size())

    def read() -> NDArray[Any] | list[Any] | str:
        if entry.shape is None:
            raise ValueError(f"'{name}' is empty")
        if text:
            values = entry.asstr(errors="replace")[()]
            return str(values) if isinstance(values, str) else list(values.tolist())
        if not stored:
            raise ValueError(f"'{name}' declares {entry.size} numbers and holds none")
        return np.asarray(entry[()])

    dtype = np.dtype(object) if text else entry.dtype
    return NetcdfVariable(
        shape=entry.shape or (),
        dtype=dtype,
        attributes=functools.partial(_attributes, entry.attrs),
        dimensions=lambda: _dimensions(file, name, entry),
        read=read,
        is_stored=stored,
    )


def _dimensions(file: h5py.File, name: str, entry: h5py.Dataset) -> list[str]:
    """Return the names of the dimensions: those of the attached scales, or its own if the variable is a scale."""
    if "DIMENSION_LIST" in entry.attrs:
        scales = [file[references[0]] for references in entry.attrs["DIMENSION_LIST"]]
        found = [str(scale.name).rpartition("/")[2] for scale in scales]
    else:
        found = [name] * len(entry.shape)
    if len(found) != len(entry.shape) or len(set(found)) != len(found):
        raise ValueError(f"the dimensions of '{name}' are not declared")
    return found


def _attributes(stated: Mapping[str, Any], names: Collection[str] | None = None) -> dict[str, Any]:
    """Read attributes, all or those with these names; a damaged one that nobody asks for does no harm."""
    return {
        name: _plain(stated[name])
        for name in stated
        if name not in _OF_THE_FORMAT and (names is None or name in names)
    }


def _plain(value: Any) -> Any:
    """Return an attribute as a text, a number or a list."""
    if isinstance(value, (str, bytes)):
        return _text(value)
    if isinstance(value, (np.ndarray, np.generic)) and np.asarray(value).dtype.kind in "fiubSUO":
        listed = np.asarray(value).reshape(-1).tolist()
        plain = [_text(item) if isinstance(item, (str, bytes)) else item for item in listed]
        if all(isinstance(item, (str, int, float)) for item in plain):
            return plain[0] if len(plain) == 1 else plain
    return ""


def _text(value: str | bytes) -> str:
    """Decode a text; bytes that are no UTF-8 become replacement characters."""
    raw = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else bytes(value)
    return raw.decode("utf-8", "replace")


def _decoded(values: NDArray[Any], attributes: Mapping[str, Any]) -> NDArray[np.float64]:
    """Unpack numbers by the conventions for climate data: missing ones, scale and offset."""
    if attributes.get("_Unsigned") == "true" and values.dtype.kind == "i":
        values = values.view(values.dtype.str.replace("i", "u"))
    decoded = values.astype(np.float64)
    for name in ("_FillValue", "missing_value"):
        if isinstance(missing := attributes.get(name), (int, float)):
            decoded[values == np.asarray(missing).astype(values.dtype)] = np.nan
    for name, apply in (("scale_factor", np.multiply), ("add_offset", np.add)):
        if isinstance(number := attributes.get(name), (int, float)):
            apply(decoded, number, out=decoded)
    return decoded


def _can_read(head: bytes, suffix: str) -> CanRead:
    if suffix != ".mat" and (
        head.startswith((b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02")) or head[512:516] == b"\x89HDF"
    ):
        return CanRead.NO if head.startswith(b"MATLAB") else CanRead.YES
    return CanRead.PERHAPS if suffix in (".nc", ".h5", ".hdf5") else CanRead.NO


FORMAT: Final = FileFormat(
    name="hdf5",
    description="netCDF and HDF5 (.nc, .h5, .hdf5): arrays of one or two dimensions",
    can_read=_can_read,
    read=read_hdf5,
    columns=read_columns,
    options=("part",),
)
