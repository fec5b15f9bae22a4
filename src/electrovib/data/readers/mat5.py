"""Numbers and texts of a MATLAB file of version 5 (saved with -v6 or -v7), with every length checked.

Written after the published description of the format, because the usual reader can crash the interpreter with a damaged
file; here every offset and size is compared with the number of bytes before it is used.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.budget import content_allowed, megabytes, memory_allowed
from electrovib.core.errors import DataFileError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

_HEADER: Final = 128
_MATRIX, _COMPRESSED = 14, 15
_NUMBERS: Final = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
}  # fmt: skip
"""Element types that hold numbers."""
_CLASSES: Final = {
    1: "cell", 2: "struct", 3: "object", 4: "char", 5: "sparse", 6: "double", 7: "single", 8: "int8", 9: "uint8",
    10: "int16", 11: "uint16", 12: "int32", 13: "uint32", 14: "int64", 15: "uint64", 16: "function handle", 17: "object",
}  # fmt: skip
_STRUCT, _CHAR, _OPAQUE = 2, 4, 17
_FIRST_NUMERIC, _LAST_NUMERIC = 6, 15
_COMPLEX: Final = 0x0800
_PEEK: Final = 4096
"""Bytes in which flags, sizes and name of a variable must lie."""
_LONGEST_NAME: Final = 4096
"""Largest declared length of the name of a field [bytes]."""
_MOST_FIELDS: Final = 100_000
_TEXTS: Final = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
"""Element types that hold characters, and their encodings."""


@dataclass(frozen=True, kw_only=True)
class Mat5Variable:
    """A variable of the file or a field of one, not yet read, with name, or path of a field, and class as in MATLAB.

    `shape` is empty for an object, for which the file states none. `start` and `size` are those of its
    element in the file, or of a field in the unpacked variable `within` [bytes]. `compressed` is what was
    saved with -v7.
    """

    name: str
    kind: str
    shape: tuple[int, ...]
    numeric: bool
    start: int
    size: int
    compressed: bool
    within: memoryview | None = None


class Mat5:
    """A MATLAB file of version 5 in memory; bytes that do not begin as such a file does are refused."""

    def __init__(self, path: Path, raw: bytes) -> None:
        order = {b"IM": "<", b"MI": ">"}.get(raw[126:128])
        if len(raw) < _HEADER or not raw.startswith(b"MATLAB 5.0") or order is None:
            raise DataFileError(
                "is not a MATLAB file of version 5 or 7.3; in MATLAB save it with -v7.", path=path
            )
        self.path, self.raw, self.order = path, memoryview(raw), order
        self.unfolded = 0

    def variables(self) -> list[Mat5Variable]:
        """List the variables of the file."""
        found, place = [], _HEADER
        while place < len(self.raw):
            kind, start, size, place = self._tag(self.raw, place)
            if kind == _MATRIX:
                found.append(self._peek(self.raw[start : start + size], start, size, compressed=False))
            elif kind == _COMPRESSED:
                head = memoryview(self._inflated(start, size, _PEEK))
                found.append(self._peek(head[8:], start, size, compressed=True))
            else:
                raise self._damaged(f"an element of type {kind} at byte {start - 8} where a variable is due")
        return [variable for variable in found if variable.name]

    def fields(self, variable: Mat5Variable) -> list[Mat5Variable]:
        """List the fields of a struct by their path, ``"name.field"``; empty for an array of structs."""
        if variable.kind != _CLASSES[_STRUCT] or _product(variable.shape) != 1:
            return []
        body = self._body(variable)
        parts = self._places(body)
        for _ in range(3):
            next(parts)
        _, start, size = next(parts)
        lengths = np.frombuffer(body[start : start + size - size % 4], f"{self.order}i4")
        kind, start, size = next(parts)
        length = int(lengths[0]) if len(lengths) == 1 else 0
        if kind != 1 or not 0 < length <= _LONGEST_NAME or size % length or size > length * _MOST_FIELDS:
            raise self._damaged(f"the names of the fields of '{variable.name}' are not where they belong")
        names = bytes(body[start : start + size])
        found = []
        for number in range(size // length):
            kind, start, extent = next(parts)
            if kind != _MATRIX:
                raise self._damaged(f"field {number} of '{variable.name}' is an element of type {kind}")
            name = names[number * length : (number + 1) * length].partition(b"\0")[0].decode("latin-1")
            path = f"{variable.name}.{name}"
            if extent:
                found.append(self._peek(body[start : start + extent], start, extent, within=body, path=path))
            else:
                found.append(
                    Mat5Variable(
                        name=path,
                        kind="empty",
                        shape=(0, 0),
                        numeric=False,
                        start=start,
                        size=0,
                        compressed=False,
                        within=body,
                    )
                )
        return found

    def values(self, variable: Mat5Variable) -> NDArray[np.float64]:
        """Read a numeric variable or field, in the shape that MATLAB shows."""
        return self._numbers(variable, self._content(variable))

    def complex_values(self, variable: Mat5Variable) -> NDArray[np.complex128]:
        """Read a complex variable, in the shape that MATLAB shows."""
        content = self._content(variable)
        whole = np.empty(variable.shape, np.complex128, order="F")
        whole.real, whole.imag = self._numbers(variable, content), self._numbers(variable, content)
        return whole

    def text(self, variable: Mat5Variable) -> str:
        """Read a row of characters."""
        kind, data = next(self._content(variable))
        encoding = _TEXTS.get(kind)
        if variable.kind != _CLASSES[_CHAR] or encoding is None:
            raise self._damaged(f"'{variable.name}' holds no text")
        order = {"<": "-le", ">": "-be"}[self.order] if encoding in ("utf-16", "utf-32") else ""
        return bytes(data).decode(encoding + order)

    def _content(self, variable: Mat5Variable) -> Iterator[tuple[int, memoryview]]:
        """Iterate over the parts of a variable after its flags, sizes and name."""
        parts = self._parts(self._body(variable))
        for _ in range(3):
            next(parts)
        return parts

    def _numbers(
        self, variable: Mat5Variable, content: Iterator[tuple[int, memoryview]]
    ) -> NDArray[np.float64]:
        kind, data = next(content)
        if kind not in _NUMBERS:
            raise self._damaged(f"the numbers of '{variable.name}' are of the unknown type {kind}")
        values = np.frombuffer(
            data[: len(data) - len(data) % np.dtype(_NUMBERS[kind]).itemsize], f"{self.order}{_NUMBERS[kind]}"
        )
        if values.size != (count := _product(variable.shape)):
            raise self._damaged(f"'{variable.name}' should hold {count} numbers and holds {values.size}")
        # small whole numbers take a byte each in the file and eight as floats
        self._check_size(variable, 8 * count, memory_allowed(len(self.raw)))
        return values.astype(np.float64).reshape(variable.shape, order="F")

    def _body(self, variable: Mat5Variable) -> memoryview:
        place = slice(variable.start, variable.start + variable.size)
        if variable.within is not None:
            return variable.within[place]
        if not variable.compressed:
            return self.raw[place]
        kind, size = struct.unpack(
            f"{self.order}II", self._inflated(variable.start, variable.size, 8).ljust(8)
        )
        if kind != _MATRIX:
            raise self._damaged(f"'{variable.name}' unpacks to an element of type {kind}")
        self.unfolded += size
        self._check_size(variable, self.unfolded, content_allowed(len(self.raw)))
        return memoryview(self._inflated(variable.start, variable.size, size + 8, whole=True))[8:]

    def _check_size(self, variable: Mat5Variable, size: int, allowed: int) -> None:
        if size > allowed:
            raise DataFileError(
                f"{self.path}: is damaged, or packed too tightly: with '{variable.name}' it would unfold to"
                f" {megabytes(size)} from a file of {megabytes(len(self.raw))}. If it is whole, save it with -v6."
            )

    def _peek(
        self,
        body: memoryview,
        start: int,
        size: int,
        *,
        compressed: bool = False,
        within: memoryview | None = None,
        path: str = "",
    ) -> Mat5Variable:
        parts = self._parts(body, whole=False)
        flags_kind, flags = next(parts)
        if flags_kind != 6 or len(flags) < 8:
            raise self._damaged(f"the variable at byte {start} has no flags or no sizes")
        word = struct.unpack_from(f"{self.order}I", flags)[0]
        number = word & 0xFF
        if number == _OPAQUE:  # an object: no sizes, but its name, the system and the class it is of
            name, _, kind = (_text(next(parts)[1]) for _ in range(3))
            return Mat5Variable(
                name=path or name,
                kind=f"object of class {kind}",
                shape=(),
                numeric=False,
                start=start,
                size=size,
                compressed=compressed,
                within=within,
            )
        sizes_kind, sizes = next(parts)
        name = _text(next(parts)[1])
        if sizes_kind != 5 or len(sizes) % 4 or not sizes:
            raise self._damaged(f"the variable at byte {start} has no flags or no sizes")
        shape = struct.unpack(f"{self.order}{len(sizes) // 4}i", sizes)
        if min(shape) < 0:
            raise self._damaged(f"the variable at byte {start} has sizes {shape}")
        numeric = _FIRST_NUMERIC <= number <= _LAST_NUMERIC and not word & _COMPLEX
        kind = ("complex " if word & _COMPLEX else "") + _CLASSES.get(number, f"class {number}")
        return Mat5Variable(
            name=path or name,
            kind=kind,
            shape=shape,
            numeric=numeric,
            start=start,
            size=size,
            compressed=compressed,
            within=within,
        )

    def _parts(self, body: memoryview, *, whole: bool = True) -> Iterator[tuple[int, memoryview]]:
        """Iterate over the parts of a variable; the last may be incomplete if only its beginning was read."""
        for kind, start, size in self._places(body, whole=whole):
            yield kind, body[start : start + size]

    def _places(self, body: memoryview, *, whole: bool = True) -> Iterator[tuple[int, int, int]]:
        """Iterate over type, start and size of the parts of a variable."""
        place = 0
        while True:
            kind, start, size, place = self._tag(body, place, whole=whole)
            yield kind, start, size

    def _tag(self, body: memoryview, place: int, *, whole: bool = True) -> tuple[int, int, int, int]:
        """Return type, start and size of an element, and the start of the next one."""
        if place + 8 > len(body):
            raise self._damaged(f"cut short: {place + 8 - len(body)} bytes of an element are missing")
        kind, size = struct.unpack_from(f"{self.order}II", body, place)
        if kind >> 16:  # a small element: type and size share four bytes, the content has the other four
            kind, size = kind & 0xFFFF, kind >> 16
            if size > 4:
                raise self._damaged(f"a small element of {size} bytes")
            return kind, place + 4, size, place + 8
        start = place + 8
        if whole and start + size > len(body):
            raise self._damaged(f"cut short: {start + size - len(body)} bytes of an element are missing")
        padding = 0 if kind == _COMPRESSED else -size % 8
        return kind, start, size, start + size + padding

    def _inflated(self, start: int, size: int, count: int, *, whole: bool = False) -> bytes:
        """Decompress the first bytes of an element, or all of it with its checksum if `whole` is set."""
        packed = zlib.decompressobj()
        try:
            content = packed.decompress(self.raw[start : start + size], count)
            if whole:
                packed.decompress(packed.unconsumed_tail, 1)
        except zlib.error as error:
            raise self._damaged(str(error)) from None
        if whole and (len(content) < count or not packed.eof):
            raise self._damaged(f"a variable of {count} bytes unpacks to another size")
        return content

    def _damaged(self, why: str) -> DataFileError:
        return DataFileError(f"{self.path}: is damaged or not a MATLAB file ({why}).")


def _text(raw: memoryview) -> str:
    return bytes(raw).rstrip(b"\0").decode("latin-1")


def _product(shape: tuple[int, ...]) -> int:
    count = 1
    for size in shape:
        count *= size
    return count
