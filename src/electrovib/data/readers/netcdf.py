"""Variables of a netCDF file of version 4 (HDF5) or of the classic version; to be called in a guarded process."""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.columns.column import check_row
from electrovib.data.columns.headings import choose, name_and_unit
from electrovib.data.guarded import Reader

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

_CLASSIC: Final = b"CDF"
_OF_THE_FORMAT: Final = {
    "CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "DIMENSION_LABELS", "_Netcdf4Dimid", "_Netcdf4Coordinates",
    "_nc3_strict", "_NCProperties",
}  # fmt: skip
"""Attributes that the format itself needs."""
_NO_VARIABLE: Final = "This is a netCDF dimension but not a netCDF variable"


@dataclass(frozen=True, kw_only=True)
class NetcdfVariable:
    """A variable that is not yet read.

    The type is ``object`` for texts. `dimensions` returns the names of the dimensions, and `read` the
    numbers, or the texts as nested lists. `refusal` is the reason why the variable must not be read; empty if
    it may be read.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: Mapping[str, Any]
    dimensions: Callable[[], list[str]]
    read: Callable[[], NDArray[Any] | list[Any] | str]
    refusal: str = ""


def reader(path: Path, function: str) -> Reader:
    """Return a function of this module as a reader, with the library that the file needs."""
    with path.open("rb") as file:
        needs = ("scipy.io",) if file.read(3) == _CLASSIC else ("h5py",)
    return Reader(f"{__name__}:{function}", needs, "a netCDF file")


def columns(path: Path, wanted: Sequence[str | int]) -> Iterator[tuple[str, Any]]:
    """Yield name, unit and values of each column, decoded by the conventions for packed and missing numbers."""
    with _opened(path) as (variables, _):
        for column in wanted:
            names = list(variables)
            if isinstance(column, int):
                raise DataFileError(
                    f"ask for column {column} by its name; it has: {', '.join(names)}.", path=path
                )
            name = names[choose(path, names, column, len(names))]
            variable = _allowed(path, variables[name])
            check_row(path, f"column '{name}'", len(variable.shape), variable.dtype)
            values = _whole(path, name, variable)
            assert isinstance(values, np.ndarray)
            unit = str(variable.attributes.get("units", "")) or name_and_unit(name)[1]
            yield f"{column} about", [name, unit]
            yield f"{column} values", _decoded(values, variable.attributes)


def everything(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the attributes of the file, and for each variable its dimensions, attributes and values."""
    with _opened(path) as (variables, attributes):
        yield "attributes", attributes
        for name, variable in variables.items():
            _allowed(path, variable)
            about = {"dims": variable.dimensions(), "attributes": dict(variable.attributes)}
            yield f"about {name}", about | {"shape": variable.shape, "text": variable.dtype.kind in "OSU"}
            yield f"values {name}", _whole(path, name, variable)


def _allowed(path: Path, variable: NetcdfVariable) -> NetcdfVariable:
    if variable.refusal:
        raise DataFileError(f"{variable.refusal}", path=path)
    return variable


def _whole(path: Path, name: str, variable: NetcdfVariable) -> NDArray[Any] | list[Any] | str:
    """Read a variable after its declared size has been checked."""
    declared, size = math.prod(variable.shape) * variable.dtype.itemsize, path.stat().st_size
    if declared > content_allowed(size):
        raise DataFileError(
            f"is damaged, or packed too tightly: '{name}' declares {megabytes(declared)} in a file of"
            f" {megabytes(size)}. If it is whole, save it without compression.",
            path=path,
        )
    return variable.read()


@contextmanager
def _opened(path: Path) -> Iterator[tuple[dict[str, NetcdfVariable], dict[str, Any]]]:
    with path.open("rb") as file:
        classic = file.read(3) == _CLASSIC
    with (_classic if classic else _hdf5)(path) as found:
        yield found


@contextmanager
def _classic(path: Path) -> Iterator[tuple[dict[str, NetcdfVariable], dict[str, Any]]]:
    import scipy.io

    with scipy.io.netcdf_file(path, "r", mmap=False, maskandscale=False) as file:
        found = {name: _of_classic(entry) for name, entry in file.variables.items()}
        yield found, {key: _plain(value) for key, value in file._attributes.items()}  # noqa: SLF001


def _of_classic(entry: Any) -> NetcdfVariable:
    dtype = np.dtype(object) if entry.data.dtype.kind == "S" else entry.data.dtype
    attributes = {key: _plain(value) for key, value in entry._attributes.items()}  # noqa: SLF001  # there is no other access
    return NetcdfVariable(
        shape=tuple(entry.shape),
        dtype=dtype,
        attributes=attributes,
        dimensions=lambda: list(entry.dimensions),
        read=lambda: entry.data,
    )


@contextmanager
def _hdf5(path: Path) -> Iterator[tuple[dict[str, NetcdfVariable], dict[str, Any]]]:
    import h5py

    with h5py.File(path, "r") as file:
        found = {}
        for name in file:
            if not isinstance(file.get(name, getlink=True), h5py.HardLink):
                found[name] = _elsewhere(name)
                continue
            entry = file[name]
            if isinstance(entry, h5py.Dataset) and not _text(entry.attrs.get("NAME", "")).startswith(
                _NO_VARIABLE
            ):
                found[name] = _dataset(file, name, entry)
        yield found, _attributes(file)


def _elsewhere(name: str) -> NetcdfVariable:
    """Return a variable that refuses to be read, for numbers in another file, which could be any file of the computer."""
    refusal = f"'{name}' is a link to another place, which is not followed; copy its numbers into this file."
    return NetcdfVariable(
        shape=(), dtype=np.dtype(object), attributes={}, dimensions=list, read=str, refusal=refusal
    )


def _dataset(file: h5py.File, name: str, entry: h5py.Dataset) -> NetcdfVariable:
    import h5py

    if entry.external or entry.is_virtual:
        return _elsewhere(name)
    text = h5py.check_string_dtype(entry.dtype) is not None

    def read() -> NDArray[Any] | list[Any] | str:
        if entry.shape is None:
            raise ValueError(f"'{name}' is empty")
        if text:
            values = entry.asstr(errors="replace")[()]
            return str(values) if isinstance(values, str) else list(values.tolist())
        if entry.size and not entry.id.get_storage_size():
            raise ValueError(f"'{name}' declares {entry.size} numbers and holds none")
        return np.asarray(entry[()])

    dtype = np.dtype(object) if text else entry.dtype
    return NetcdfVariable(
        shape=entry.shape or (),
        dtype=dtype,
        attributes=_attributes(entry),
        dimensions=lambda: _dimensions(file, name, entry),
        read=read,
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


def _attributes(owner: h5py.Dataset | h5py.File) -> dict[str, Any]:
    return {name: _plain(owner.attrs[name]) for name in owner.attrs if name not in _OF_THE_FORMAT}


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
