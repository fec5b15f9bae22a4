"""MATLAB files: version 5 (-v6, -v7), read by SciPy, and version 7.3, which is HDF5; both in a guarded process.

A damaged file can crash the library that reads it, and a small one can unfold to any size.
"""

from __future__ import annotations

import io
import math
import re
import struct
import warnings
import zlib
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes
from electrovib.core.errors import DataFileError, NoColumnError, suggestion
from electrovib.data.faults import check_file, damaged, packed
from electrovib.data.guarded import Reader, read_guarded
from electrovib.data.recorded import (
    CanRead,
    DataColumn,
    FileFormat,
    columns_of_array,
    real_numbers,
    recorded_of,
)
from electrovib.data.trace_csv import joined

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence
    from pathlib import Path

    import h5py
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import Recorded

_COLUMN: Final = re.compile(r"(([A-Za-z]\w*(?:\.[A-Za-z]\w*)*)(?:\[(\d{1,9})\])?)(?:\s+\[([^\[\]]+)\])?")
_NUMERIC: Final = re.compile("double|single|logical|u?int(?:8|16|32|64)")
_HEADER: Final = 128
_MATRIX, _COMPRESSED = 14, 15
_IS_COMPLEX: Final = 0x0800
_HEAD: Final = 4096
"""Bytes in which flags, sizes and name of a variable have to lie; a packed one is not unpacked further to list it."""
_DEEPEST: Final = 6
_MOST: Final = 500


def read_arrays(path: Path, names: Collection[str]) -> dict[str, Real]:
    """Read real numeric arrays of a MATLAB file, in the shape that MATLAB shows.

    A name may be the path of a field of a struct, ``"trial.force"``, or empty if the file holds only one real
    numeric array that is no single number.
    """
    return _read(path, "chosen", names=list(dict.fromkeys(names)))


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns of the arrays of a MATLAB file: ``"name[3]"`` is column 3, from 0, and ``"trial.force"`` a field."""
    del missing
    parts: dict[str | int, tuple[str, str, int | None, str]] = {}
    for column in columns:
        if isinstance(column, int):
            parts[column] = (f"[{column}]", "", column, "")
            continue
        match = _COLUMN.fullmatch(column)
        if match is None:
            raise DataFileError(
                f"'{column}' names no column; write 'name[3]' for column 3, 0 first, of the array 'name'.",
                path=path,
            )
        parts[column] = (match[1], match[2], int(match[3]) if match[3] else None, match[4] or "")
    arrays = read_arrays(path, [name for _, name, _, _ in parts.values()])
    return {
        column: real_numbers(path, f"column {label}", _column(path, name, arrays[name], number), unit)
        for column, (label, name, number, unit) in parts.items()
    }


def _column(path: Path, name: str, array: Real, number: int | None) -> Real:
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


def read_matlab_table(path: Path, *, part: str = "") -> Recorded:
    """Read the real numeric arrays of a MATLAB file that have the length with most numbers, or that of the array `part`."""
    columns: list[tuple[str, str, Real]] = []
    for name, values in _read(path, "tables").items():
        columns += columns_of_array(name, "", values)
    return recorded_of(path, columns, part=part)


def read_variables(path: Path, needed: str) -> dict[str, NDArray[Any] | str]:
    """Read all arrays of real or complex numbers, and rows of characters, of a MATLAB file that has the variable `needed`."""
    return _read(path, "variables", needed=needed)


def _read(path: Path, function: str, **arguments: Any) -> dict[str, Any]:
    """Call a function of this module in a guarded process, and convert real numbers to floats."""
    check_file(path)
    _check_elements(path)
    needs = ("h5py",) if _is_hdf5(path) else ("scipy.io",)
    found = read_guarded(Reader(f"{__name__}:{function}", needs, "a MATLAB file"), path, **arguments)
    return {name: value if isinstance(value, str) else _as_shown(value) for name, value in found.items()}


def _as_shown(values: NDArray[Any]) -> NDArray[Any]:
    """Return the transposed array that the guarded process hands over without a copy, as MATLAB shows it."""
    with np.errstate(all="ignore"):  # what a damaged file holds may be no number at all
        return np.asarray(values, dtype=np.complex128 if values.dtype.kind == "c" else np.float64).T


def chosen(path: Path, names: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield the selected real arrays."""
    with _opened(path) as file:
        for wanted in names:
            for name in _structs_on_path(wanted, file.known):
                file.look_into(name)
            yield wanted, file.array(_chosen(path, wanted, file.known))


def tables(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the real arrays of two dimensions, also those in structs."""
    with _opened(path) as file:
        waiting = list(file.known)
        for name in waiting:
            kind, shape, numeric = file.known[name]
            if numeric and len(shape) == 2 and max(shape) > 1:
                yield name, file.array(name)
            elif kind == "struct" and name.count(".") < _DEEPEST and len(waiting) < _MOST:
                waiting += file.look_into(name)


def variables(path: Path, needed: str) -> Iterator[tuple[str, Any]]:
    """Yield variables of real and complex numbers, and of characters; none of a file without the one that is needed."""
    with _opened(path) as file:
        for name, (kind, _, numeric) in file.known.items() if needed in file.known else ():
            if numeric or kind.startswith("complex "):
                yield name, file.array(name)
            elif kind == "char":
                yield name, file.text(name)


Known = dict[str, tuple[str, tuple[int, ...], bool]]
"""Maps the name of a variable, or the path of a field, to its kind, its shape and whether it is a real numeric array."""


@contextmanager
def _opened(path: Path) -> Iterator[_Version5 | _Version73]:
    if not _is_hdf5(path):
        yield _Version5(path)
        return
    import h5py

    with h5py.File(path, "r") as file:
        yield _Version73(path, file)


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        begin = file.read(516)
    return b"MATLAB 7.3" in begin[:116] or b"\x89HDF" in (begin[:4], begin[512:])


# ----------------------------------------------------------------------------------------------- version 5


@dataclass(frozen=True)
class _Element:
    """One variable of a file of version 5: where it stands, its unpacked beginning, and the bytes it unfolds to."""

    start: int
    end: int
    head: bytes
    unfolded: int
    is_complex: bool


def _check_elements(path: Path) -> None:
    """Refuse a file of version 5 that is cut short, before a process is started for it."""
    if not _is_hdf5(path):
        list(_elements(path, path.read_bytes()))


def _elements(path: Path, raw: bytes) -> Iterator[_Element]:
    """Iterate over the variables, whose sizes have to fill the file."""
    order = {b"IM": "<", b"MI": ">"}.get(raw[126:_HEADER])
    if len(raw) < _HEADER or not raw.startswith(b"MATLAB 5.0") or order is None:
        raise DataFileError(
            "is not a MATLAB file of version 5 or 7.3; in MATLAB save it with -v7.", path=path
        )
    place = _HEADER
    while place < len(raw):
        start, fault = place + 8, ""
        kind, size = struct.unpack(f"{order}II", raw[place:start].ljust(8, b"\0"))
        missing = start + (size if start <= len(raw) else 0) - len(raw)
        if start <= len(raw) and kind not in (_MATRIX, _COMPRESSED):
            fault = f"an element of type {kind} at byte {place} where a variable is due"
        elif missing > 0:
            fault = f"cut short: {missing} bytes of an element are missing"
        if fault:
            raise damaged(path, "a MATLAB file", ValueError(fault))
        head = raw[place : min(place + _HEAD, start + size)]
        if kind == _COMPRESSED:
            try:
                head = zlib.decompressobj().decompress(memoryview(raw)[start : start + size], _HEAD)
            except zlib.error as error:
                raise damaged(path, "a MATLAB file", error) from None
        _, unfolded, _, _, flags = struct.unpack(f"{order}5I", head[:20].ljust(20, b"\0"))
        place = start + size + (0 if kind == _COMPRESSED else -size % 8)
        yield _Element(start - 8, place, head, unfolded, bool(flags & _IS_COMPLEX))


class _Version5:
    """A file of version 5, each variable of which is given to SciPy as a file of its own when it is needed.

    `known` grows by the fields of the structs that were looked into.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.raw, self.known = path, path.read_bytes(), Known()
        self._elements: dict[str, _Element] = {}
        self._fields: dict[str, Any] = {}
        self._unfolded = 0
        for element in _elements(path, self.raw):
            name, entry = self._listed(element)
            if name != "__function_workspace__":
                self.known[name], self._elements[name] = entry, element

    def _listed(self, element: _Element) -> tuple[str, tuple[str, tuple[int, ...], bool]]:
        """Return the name of a variable, and its kind, shape and whether it is a real numeric array."""
        import scipy.io

        try:
            ((name, shape, kind),) = scipy.io.whosmat(
                io.BytesIO(self.raw[:_HEADER] + element.head), chars_as_strings=False
            )
        except TypeError:  # SciPy lists no objects
            found = next(
                each
                for each in self._loaded(element).values()
                if isinstance(each, scipy.io.matlab.MatlabOpaque)
            )
            name, kind = (found[part].item().decode("latin-1") for part in ("s0", "s2"))
            return name, (f"object of class {kind}", (), False)
        numeric = _NUMERIC.fullmatch(kind) is not None and not element.is_complex
        kind = {"function": "function handle"}.get(kind, kind)
        return name, (f"complex {kind}" if element.is_complex else kind, shape, numeric)

    def _file(self, element: _Element) -> io.BytesIO:
        return io.BytesIO(self.raw[:_HEADER] + self.raw[element.start : element.end])

    def _loaded(self, element: _Element, *, as_strings: bool = False) -> dict[str, Any]:
        import scipy.io

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what it finds in a damaged file
            return dict(scipy.io.loadmat(self._file(element), chars_as_strings=as_strings))

    def _value(self, name: str, *, as_strings: bool = False) -> Any:
        """Load a variable, or return a field of a struct that was looked into."""
        if name in self._fields:
            return self._fields[name]
        element = self._elements[name]
        self._unfolded += element.unfolded
        if self._unfolded > content_allowed(len(self.raw)):
            size = f"{megabytes(self._unfolded)} from a file of {megabytes(len(self.raw))}"
            what = f"with '{name}' it would unfold to {size}"
            raise packed(self.path, what, "If it is whole, save it with -v6.")
        return self._loaded(element, as_strings=as_strings)[name]

    def look_into(self, name: str) -> list[str]:
        """Return the paths of the fields of a struct; none if it is no single struct."""
        kind, shape, _ = self.known[name]
        if kind != "struct" or math.prod(shape) != 1:
            return []
        record = self._value(name).reshape(-1)[0]
        fields = {f"{name}.{field}": record[field] for field in record.dtype.names or ()}
        self._fields |= fields
        self.known |= {path: _kind_of(value) for path, value in fields.items()}
        return list(fields)

    def array(self, name: str) -> NDArray[Any]:
        """Read an array of numbers, transposed: MATLAB counts along columns."""
        values = self._value(name)
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiubc":
            raise ValueError(f"'{name}' holds no numbers")
        return values.T

    def text(self, name: str) -> str:
        return "".join(map(str, np.ravel(self._value(name, as_strings=True))))


def _kind_of(value: Any) -> tuple[str, tuple[int, ...], bool]:
    """Return kind and shape of a loaded field; of whole numbers MATLAB's class is not known, since it packs doubles as such."""
    import scipy.io.matlab as classes

    if isinstance(value, classes.MatlabOpaque):
        return f"object of class {value['s2'].item().decode('latin-1')}", (), False
    if isinstance(value, classes.MatlabFunction):
        return "function handle", value.shape, False
    if not isinstance(value, np.ndarray) or isinstance(value, classes.MatlabObject):
        return "object", (), False
    form = value.dtype.kind
    named = {"float64": "double", "float32": "single", "bool": "logical"}.get(
        value.dtype.name, "whole numbers"
    )
    kind = {"c": "complex double", "U": "char", "V": "struct", "O": "cell"}.get(form, named)
    return kind, value.shape, form in "fiub"


# --------------------------------------------------------------------------------------------- version 7.3


class _Version73:
    """A file of version 7.3."""

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path, self.file, self.known = path, file, Known()
        self._list(file, "")

    def _list(self, group: h5py.Group, prefix: str) -> list[str]:
        """List the members of the file or of a struct in it; links to other files are not followed."""
        import h5py

        found = {
            f"{prefix}{name}": _member(group[name])
            for name in group
            if not name.startswith("#") and isinstance(group.get(name, getlink=True), h5py.HardLink)
        }
        self.known |= found
        return list(found)

    def _dataset(self, name: str, each: int) -> h5py.Dataset:
        entry, size = self.file[name.replace(".", "/")], self.path.stat().st_size
        if (count := math.prod(entry.shape)) * each > content_allowed(size):
            what = f"{megabytes(size)} are too small for the {count} numbers of '{name}'"
            raise packed(self.path, what, "If it is whole, save it with -v6 or -nocompression.")
        return entry

    def look_into(self, name: str) -> list[str]:
        # a sparse matrix or an object is a group too, but its parts are no fields
        is_struct = self.known[name][0] == "struct"
        return self._list(self.file[name.replace(".", "/")], f"{name}.") if is_struct else []

    def array(self, name: str) -> NDArray[Any]:
        is_complex = self.known[name][0].startswith("complex ")
        values = np.asarray(self._dataset(name, 16 if is_complex else 8)[()])
        if not is_complex:
            return values
        return joined(real=values["real"], imaginary=values["imag"])

    def text(self, name: str) -> str:
        return np.asarray(self._dataset(name, 2)[()], dtype="<u2").tobytes().decode("utf-16-le")


def _member(entry: h5py.Dataset | h5py.Group) -> tuple[str, tuple[int, ...], bool]:
    """Return kind and shape of a member, and whether it is an array of real numbers in this file."""
    import h5py

    kind = entry.attrs.get("MATLAB_class", b"")
    kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
    if "MATLAB_object_decode" in entry.attrs and kind not in ("", "function_handle"):
        kind = f"object of class {kind}"
    if not isinstance(entry, h5py.Dataset):
        return kind or "struct", (), False
    if h5py.check_ref_dtype(entry.dtype) is not None and not kind:
        kind = "field of an array of structs"
    kind = kind or "double"
    if entry.is_virtual or entry.external:
        kind = "array in another file"
    elif _NUMERIC.fullmatch(kind) and entry.dtype.names == ("real", "imag"):
        kind = f"complex {kind}"
    numeric = bool(_NUMERIC.fullmatch(kind)) and kind != "logical" and entry.dtype.kind in "fiu"
    return kind, tuple(reversed(entry.shape)), numeric and "MATLAB_empty" not in entry.attrs


# ------------------------------------------------------------------------------------ choice of a variable


def _structs_on_path(wanted: str, known: Mapping[str, object]) -> Iterator[str]:
    """Iterate over the known structs on the path to a field, including the last, whose fields a message may list."""
    parts = wanted.split(".")
    for depth in range(1, len(parts) + 1):
        if (name := ".".join(parts[:depth])) in known:
            yield name


def _chosen(path: Path, wanted: str, known: Known) -> str:
    """Return the name of the selected variable, or refuse with a list of what there is."""

    def listed(names: Sequence[str]) -> str:
        shown = [_described(name, *known[name][:2]) for name in names[:20]]
        return ", ".join(shown) + (", ..." if len(names) > 20 else "")

    if not known:
        raise DataFileError("holds no variables.", path=path)
    outside = [name for name in known if "." not in name]
    if wanted:
        if wanted not in known:
            above = next((name for name in reversed(list(_structs_on_path(wanted, known)))), "")
            if above and not (inside := _fields(known, above)):
                raise DataFileError(
                    f"'{wanted}' cannot be reached, {_unreachable(above, *known[above][:2])}", path=path
                )
            names = inside if above else outside
            near = suggestion(wanted, names)
            what = "field" if above else "variable"
            has = f"'{above}'" if above else "It"
            why = f"there is no {what} '{wanted}'.{near} {has} has: {listed(names)}."
            raise NoColumnError(why, path=path, column=wanted)
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
    depth = name.count(".") + 1
    return [path for path in known if path.startswith(f"{name}.") and path.count(".") == depth]


def _unreachable(name: str, kind: str, shape: tuple[int, ...]) -> str:
    """Return why an entry on the path to a field has no fields."""
    if kind.startswith("object of class"):
        return f"because '{name}' is an {kind}: only MATLAB reads it; save its numbers there as arrays."
    if kind == "struct" and any(size != 1 for size in shape):
        of = " x ".join(map(str, shape))
        return f"because '{name}' is an array of {of} structs: save the one that is meant on its own."
    return f"because {_described(name, kind, shape)} is no struct with fields."


def _can_read(head: bytes, suffix: str) -> CanRead:
    if head.startswith((b"MATLAB 5.0", b"MATLAB 7.3")):
        return CanRead.YES
    if head.startswith(b"\x89HDF") and suffix == ".mat":
        return CanRead.YES
    return CanRead.PERHAPS if suffix == ".mat" and b"\0" in head else CanRead.NO  # -ascii is text


FORMAT: Final = FileFormat(
    name="matlab",
    description="MATLAB (.mat, -v6, -v7 and -v7.3): arrays, and fields of structs by dotted path",
    can_read=_can_read,
    read=read_matlab_table,
    columns=read_columns,
    options=("part",),
)
