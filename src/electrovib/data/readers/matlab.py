"""MATLAB files: versions 4 and 5 (-v4, -v6, -v7), read by SciPy, and 7.3, which is HDF5; all in a guarded process.

A damaged file can crash the library that reads it, and a small one can unfold to any size.
"""

from __future__ import annotations

import functools
import io
import itertools
import re
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.array_columns import chosen_columns, table_of_arrays
from electrovib.data.guarded import Reader, check_file, packed, read_by_library, read_guarded
from electrovib.data.recorded import CanRead, FileFormat

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

    from electrovib.data.recorded import DataColumn, Recorded

_NUMERIC: Final = re.compile("double|single|logical|u?int(?:8|16|32|64)")
_VERSION_4: Final = re.compile(rb"[\0-\x34]\0\0\0|\0\0[\x03-\x04].", re.DOTALL)
"""First number of a file of version 4: its order of bytes, and the type of its first array, in four decimal digits."""
_CLASSES: Final = {"f8": "double", "f4": "single", "c16": "complex double", "c8": "complex single"}
"""Of whole numbers MATLAB's class is not known, since it packs doubles as such."""
_HEADER: Final = 128
_DEEPEST: Final = 6
_MOST: Final = 5000


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns of the arrays of a MATLAB file: ``"name[3]"`` is column 3, from 0, and ``"trial.force"`` a field."""
    del missing
    return chosen_columns(_arrays(path), columns)


def read_matlab_table(path: Path, *, part: str = "") -> Recorded:
    """Read the real numeric arrays of a MATLAB file that have the length with most numbers, or those of `part`."""
    return table_of_arrays(_arrays(path), part=part)


def _arrays(path: Path) -> list[tuple[str, str, NDArray[Any] | str]]:
    found = _read(path)
    if {"data", "datastart", "dataend"}.issubset(found):  # as LabChart exports
        why = "holds channels one behind the other; write each into a variable: a = data(datastart(1):dataend(1))."
        raise DataFileError(why)
    return [(name, "", value["why"] if isinstance(value, dict) else value.T) for name, value in found.items()]


def read_variables(path: Path, *, is_whole: bool = False) -> dict[str, NDArray[Any] | str]:
    """Read all arrays of real or complex numbers, and texts, of a MATLAB file, as MATLAB shows them."""
    read: dict[str, NDArray[Any] | str] = {}
    for name, value in _read(path, is_whole=is_whole, texts=True).items():
        if isinstance(value, dict):
            read[name] = value["text"]
        else:
            with np.errstate(all="ignore"):  # what a damaged file holds may be no number at all
                read[name] = np.asarray(value, np.complex128 if value.dtype.kind == "c" else np.float64).T
    return read


def _read(path: Path, *, is_whole: bool = False, **arguments: Any) -> dict[str, Any]:
    """Call `contents`, in a guarded process unless the file `is_whole`."""
    check_file(path)
    is_hdf5 = _is_hdf5(path)
    with path.open("rb") as file:
        head = file.read(_HEADER)
    is_version5 = head.startswith(b"MATLAB 5.0") and head[126:] in (b"IM", b"MI")
    if not (is_hdf5 or is_version5 or _VERSION_4.match(head)):
        raise DataFileError("is not a MATLAB file of version 4, 5 or 7.3; in MATLAB save it with -v7.")
    reader = Reader(f"{__name__}:contents", ("h5py",) if is_hdf5 else ("scipy.io",), "a MATLAB file")
    if is_whole:
        return read_by_library(lambda: dict(contents(path, **arguments)), path, reader.format_name)
    return read_guarded(reader, path, **arguments)


@dataclass(frozen=True)
class _Entry:
    """A variable, or what is in a struct or a cell: MATLAB's word for it, its shape, and how its values are read."""

    kind: str
    shape: tuple[int, ...] = ()
    read: Callable[[], Any] | None = None
    has_parts: bool = False

    def __str__(self) -> str:
        return f"{' x '.join(map(str, self.shape))} {self.kind}".strip()


def contents(path: Path, texts: bool = False) -> Iterator[tuple[str, Any]]:
    """Yield every real array, or why something is not read; or also complex numbers and `texts`."""
    with _entries(path) as found:
        for name, entry in itertools.islice(found, _MOST):
            is_real = not entry.kind.startswith(("complex ", "char"))
            if entry.read is not None and (is_real or texts):
                value = entry.read()
                yield name, {"text": value} if isinstance(value, str) else value
            elif not entry.has_parts and not texts:
                yield name, {"why": f"is no array of real numbers, but {entry}"}


@contextmanager
def _entries(path: Path) -> Iterator[Iterator[tuple[str, _Entry]]]:
    """Open a file, and iterate over what is in it."""
    if not _is_hdf5(path):
        yield _of_version5(path)
        return
    import h5py

    with h5py.File(path, "r") as file:
        yield _in_group(path, file, "")


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        begin = file.read(516)
    return b"MATLAB 7.3" in begin[:116] or b"\x89HDF" in (begin[:4], begin[512:])


# ----------------------------------------------------------------------------------------------- version 5


def _of_version5(path: Path) -> Iterator[tuple[str, _Entry]]:
    """Iterate over the variables, and what is in them; each is unpacked when its turn comes."""
    import scipy.io

    raw = path.read_bytes()
    if _VERSION_4.match(raw):
        for name, value in scipy.io.loadmat(io.BytesIO(raw)).items():
            if not name.startswith("__"):
                yield from _in_value(name, value)
        return
    for name, file in scipy.io.matlab.varmats_from_mat(io.BytesIO(raw)):
        if name:
            value = scipy.io.loadmat(file)[name]
            of_object = isinstance(value, scipy.io.matlab.MatlabOpaque)
            yield from _in_value(value["s0"].item().decode("latin-1") if of_object else name, value)


def _in_value(place: str, value: Any) -> Iterator[tuple[str, _Entry]]:
    """Iterate over a loaded value, and the fields of a struct and the elements of an array of structs or a cell."""
    import scipy.io.matlab as classes

    if isinstance(value, classes.MatlabOpaque):
        yield place, _Entry(f"object of class {value['s2'].item().decode('latin-1')}")
    elif isinstance(value, classes.MatlabFunction):
        yield place, _Entry("function handle", value.shape)
    elif not isinstance(value, np.ndarray) or isinstance(value, classes.MatlabObject):
        yield place, _Entry("sparse matrix" if hasattr(value, "tocsc") else "object")
    elif value.dtype.kind in {"V", "O"}:
        inside = dict(_elements(place, value)) if place.count(".") < _DEEPEST else {}
        kind = "cell" if value.dtype.kind == "O" else "struct"
        yield place, _Entry(kind, value.shape, has_parts=bool(inside))
        for name, each in inside.items():
            yield from _in_value(name, each)
    elif value.dtype.kind == "U":
        shape = (*value.shape, value.itemsize // 4)
        yield place, _Entry("char", shape, lambda: "".join(value.ravel().tolist()))
    else:
        yield place, _Entry(_CLASSES.get(value.dtype.str[1:], "whole numbers"), value.shape, lambda: value.T)


def _elements(place: str, value: NDArray[Any]) -> Iterator[tuple[str, Any]]:
    flat = value.reshape(-1, order="F")
    if value.dtype.kind == "O":
        yield from ((f"{place}{{{at}}}", each) for at, each in enumerate(flat, 1))
    elif value.size == 1:
        yield from ((f"{place}.{field}", flat[0][field]) for field in value.dtype.names or ())
    else:
        yield from ((f"{place}[{at}]", flat[at : at + 1, None]) for at in range(value.size))


# --------------------------------------------------------------------------------------------- version 7.3


def _in_group(path: Path, group: h5py.Group, prefix: str) -> Iterator[tuple[str, _Entry]]:
    """Iterate over the members of the file or of a struct in it; links to other files are not followed."""
    import h5py

    for name in group:
        if not name.startswith("#") and isinstance(group.get(name, getlink=True), h5py.HardLink):
            yield from _in_member(path, group[name], f"{prefix}{name}")


def _in_member(path: Path, entry: h5py.Dataset | h5py.Group, place: str) -> Iterator[tuple[str, _Entry]]:
    """Iterate over a member, and what is in it if it is a struct, an array of structs or a cell."""
    import h5py

    kind = entry.attrs.get("MATLAB_class", b"")
    kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
    if "MATLAB_object_decode" in entry.attrs and kind not in ("", "function_handle"):
        kind = f"object of class {kind}"
    if not isinstance(entry, h5py.Dataset):
        # a sparse matrix or an object is a group too, but its parts are no fields
        is_struct = kind in ("", "struct") and place.count(".") < _DEEPEST
        yield place, _Entry(kind or "struct", has_parts=is_struct and len(entry) > 0)
        if is_struct:
            yield from _in_group(path, entry, f"{place}.")
        return
    shape, read = tuple(reversed(entry.shape or ())), functools.partial(_whole, path, entry, place)
    is_elsewhere = entry.is_virtual or entry.external
    of_references = not is_elsewhere and h5py.check_ref_dtype(entry.dtype) is not None
    if is_elsewhere:
        found = _Entry("array in another file", shape)
    elif of_references:
        found = _Entry(kind or "field of an array of structs", shape, has_parts=True)
    elif kind == "char":
        found = _Entry(kind, shape, lambda: read().astype("<u2").tobytes().decode("utf-16-le"))
    elif "MATLAB_empty" in entry.attrs or not _NUMERIC.fullmatch(kind or "double"):
        found = _Entry(kind or "double", shape)
    elif entry.dtype.names == ("real", "imag"):
        found = _Entry(f"complex {kind}", shape, lambda: _complex(read()))
    else:
        found = _Entry(kind or "double", shape, read if entry.dtype.kind in "fiu" else None)
    yield place, found
    struct, _, field = place.rpartition(".")
    is_shallow = of_references and place.count("{") < _DEEPEST
    for at, reference in enumerate(entry[()].ravel()[:_MOST] if is_shallow else ()):
        name = f"{place}{{{at + 1}}}" if kind else f"{struct}[{at}].{field}"
        yield from _in_member(path, entry.file[reference], name)


def _whole(path: Path, entry: h5py.Dataset, name: str) -> NDArray[Any]:
    """Read a dataset after its declared size has been checked."""
    size = path.stat().st_size
    if entry.size * max(8, entry.dtype.itemsize) > content_allowed(size):
        what = f"{megabytes(size)} are too small for the {entry.size} numbers of '{name}'"
        raise packed(path, what, "If it is whole, save it with -v6 or -nocompression.")
    return np.asarray(entry[()])


def _complex(values: NDArray[Any]) -> NDArray[np.complex128]:
    """Combine real and imaginary parts; adding ``1j`` times a part would spread NaN and lose -0."""
    whole = np.empty(values.shape, np.complex128)
    whole.real, whole.imag = values["real"], values["imag"]
    return whole


def _can_read(head: bytes, suffix: str) -> CanRead:
    if head.startswith((b"MATLAB 5.0", b"MATLAB 7.3")):
        return CanRead.YES
    if head.startswith(b"\x89HDF") and suffix == ".mat":
        return CanRead.YES
    return CanRead.PERHAPS if suffix == ".mat" and b"\0" in head else CanRead.NO  # -ascii is text


FORMAT: Final = FileFormat(
    name="matlab",
    description="MATLAB (.mat, -v4 to -v7.3): arrays, and fields of structs by dotted path",
    can_read=_can_read,
    read=read_matlab_table,
    columns=read_columns,
    options=("part",),
)
