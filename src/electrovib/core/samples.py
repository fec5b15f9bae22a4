"""Measured numbers inside a model: a read-only array that is compared and hashed by its content."""

from __future__ import annotations

import base64
import hashlib
import sys
import zlib
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from electrovib.core.budget import content_allowed, megabytes

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import ArrayLike, NDArray
    from pydantic import GetCoreSchemaHandler

_MARK = "zlib+base64:"
_DECIMALS = "decimals+zlib+base64:"
_MOST_PLACES = 12
_EXACT = 2.0**53
"""Whole numbers below it are exact, and so is the nearest number to one of them over a power of ten."""
_KINDS = ("i1", "i2", "i4", "i8")
_STRETCH = 1 << 15
"""Numbers that are processed together, so that they stay in the cache."""
_INSPECTED = 256
"""Numbers that are inspected first, before all of them are."""
_HEAD = 1 << 16
_WORTH = 0.6
"""Compressed size over size of the first bytes, above which nothing is compressed."""


def fault_of_record(
    columns: Mapping[str, NDArray[np.float64]], *, missing: str, differing: str, needing: str
) -> str:
    """Return why columns of samples by name are no record, in these words and the number of samples; empty if they are one."""
    sizes = {len(values) for values in columns.values()}
    if sizes == {0}:
        return f"holds no samples: {missing}"
    if len(sizes) > 1:
        return differing
    if sizes == {1}:
        return f"{needing} needs at least 2 samples, not 1"
    for name, values in columns.items():
        if not np.all(np.isfinite(values)):
            return f"the {name} of sample {int(np.argmin(np.isfinite(values)))} is not a finite number"
    return ""


class Samples:
    """A read-only one-dimensional array of float64, copied from the values given, and compared by its content."""

    __slots__ = ("_raw", "_sha256")
    _raw: bytes
    _sha256: str

    def __init__(self, values: ArrayLike) -> None:
        array = np.array(values, dtype=np.float64)
        if array.ndim != 1:
            msg = f"samples have one dimension, not {array.ndim}"
            raise ValueError(msg)
        object.__setattr__(self, "_raw", array.tobytes())

    @property
    def values(self) -> NDArray[np.float64]:
        """The numbers, as an array that cannot be made writeable."""
        return np.frombuffer(self._raw, np.float64)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"samples are read-only: '{name}' cannot be set")

    def __reduce__(self) -> tuple[type[Samples], tuple[NDArray[np.float64]]]:
        """Pickle and copy with the constructor, so that a copy is read-only too."""
        return type(self), (self.values,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Samples) and self._raw == other._raw

    def __hash__(self) -> int:
        return hash(self._raw)

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        return f"<{len(self)} samples>"

    def canonical_content(self) -> dict[str, Any]:
        """Return what represents the numbers in a hash: how many they are, and the SHA-256 of their bytes."""
        return {"size": len(self), "sha256": self.sha256}

    @property
    def sha256(self) -> str:
        """The SHA-256 of the bytes, computed once."""
        if not hasattr(self, "_sha256"):
            object.__setattr__(self, "_sha256", hashlib.sha256(self._little_endian()).hexdigest())
        return self._sha256

    def _little_endian(self) -> bytes:
        return self._raw if sys.byteorder == "little" else self.values.astype("<f8").tobytes()

    def packed(self) -> str:
        """Write the numbers without loss as a short text that `read` accepts."""
        return _as_decimals(self.values) or _as_bytes(self._little_endian())

    @classmethod
    def read(cls, value: object) -> Samples:
        """Read samples, an array, a list or a packed text."""
        if isinstance(value, Samples):
            return value
        try:
            if isinstance(value, str) and value.startswith(_DECIMALS):
                return cls(_from_decimals(value))
            if isinstance(value, str) and value.startswith(_MARK):
                return cls(np.frombuffer(_unpacked(value[len(_MARK) :]), dtype="<f8"))
            if isinstance(value, (list, tuple, np.ndarray)):
                return cls(np.asarray(value, dtype=np.float64))
        except (ValueError, TypeError, IndexError, OverflowError, zlib.error) as error:
            raise PydanticCustomError("samples", "{why}", {"why": f"not numbers: {error}"}) from None
        raise PydanticCustomError("samples", "{why}", {"why": "expected a list of numbers"})

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        del source, handler
        return core_schema.no_info_plain_validator_function(cls.read)


def _as_bytes(raw: bytes) -> str:
    """Write bytes as text, compressed if that shortens their beginning enough."""
    head = raw[:_HEAD]
    worth = len(zlib.compress(head, 1)) <= _WORTH * len(head)
    packed = zlib.compress(raw, 6 if worth else 0)
    if len(raw) > content_allowed(len(packed)):  # numbers that are all alike
        packed = zlib.compress(raw, 0)
    return _MARK + base64.b64encode(packed).decode()


def _as_decimals(values: NDArray[np.float64]) -> str:
    """Write numbers with few decimals as differences of integers; empty if they have many decimals."""
    some = values[:: max(1, len(values) // _INSPECTED)]
    places = next((each for each in range(_MOST_PLACES + 1) if _whole(some, each) is not None), None)
    whole = None if places is None else _whole(values, places)
    if whole is None:
        return ""
    stretches = [slice(first, first + _STRETCH) for first in range(1, len(values), _STRETCH)]
    largest = max((int(np.max(np.abs(_steps(whole, each)))) for each in stretches), default=0)
    kind = next(kind for kind in _KINDS if largest <= np.iinfo(kind).max)
    packed = _packed(whole, stretches, kind, level=1)
    if 8 * len(values) > content_allowed(len(packed)):  # numbers that are all alike
        kind = max(kind, "i2")
        packed = _packed(whole, stretches, kind, level=0)
    minus = ",".join(str(place) for place in _minus_zeros(values))
    return f"{_DECIMALS}{places}:{kind}:{whole[0]}:{minus}:{base64.b64encode(packed).decode()}"


def _packed(whole: NDArray[np.int64], stretches: Iterable[slice], kind: str, *, level: int) -> bytes:
    """Return the differences within ranges of places as packed numbers of a kind."""
    packing = zlib.compressobj(level)
    parts = [packing.compress(_steps(whole, each).astype(f"<{kind}").tobytes()) for each in stretches]
    return b"".join([*parts, packing.flush()])


def _whole(values: NDArray[np.float64], places: int) -> NDArray[np.int64] | None:
    """Return the numbers times a power of ten as integers; None unless the division restores them exactly."""
    power, whole = 10.0**places, np.empty(len(values), np.int64)
    for first in range(0, len(values), _STRETCH):
        some = values[first : first + _STRETCH]
        with np.errstate(over="ignore", invalid="ignore"):
            raised = some * power
        if not np.max(np.abs(raised)) < _EXACT:
            return None
        whole[first : first + _STRETCH] = np.rint(raised, out=raised)
        if not np.array_equal(np.divide(raised, power, out=raised), some):
            return None
    return whole if len(whole) else None


def _steps(whole: NDArray[np.int64], stretch: slice) -> NDArray[np.int64]:
    """Return the differences of consecutive integers within a range of places."""
    return np.diff(whole[stretch.start - 1 : stretch.stop])


def _minus_zeros(values: NDArray[np.float64]) -> list[int]:
    """Return the places of -0.0, which an integer cannot distinguish from 0.0."""
    zeros = np.flatnonzero(values == 0)
    found: list[int] = zeros[np.signbit(values[zeros])].tolist()
    return found


def _from_decimals(text: str) -> NDArray[np.float64]:
    places, kind, first, minus, packed = text.removeprefix(_DECIMALS).split(":")
    if kind not in _KINDS or not 0 <= int(places) <= _MOST_PLACES:
        raise ValueError("the beginning of the packed text is not valid")
    allowed = content_allowed(len(base64.b64decode(packed, validate=True))) // 8 * int(kind[1])
    steps = np.frombuffer(_unpacked(packed, allowed), f"<{kind}")
    values = np.cumsum(np.append(int(first), steps), dtype=np.int64) / 10.0 ** int(places)
    if minus:
        values[[int(place) for place in minus.split(",")]] = -0.0
    return values


def _unpacked(text: str, allowed: int | None = None) -> bytes:
    """Unpack a text, and refuse one that unpacks to more bytes than are allowed."""
    packed = base64.b64decode(text, validate=True)
    allowed = content_allowed(len(packed)) if allowed is None else allowed
    unpacking = zlib.decompressobj()
    raw = unpacking.decompress(packed, allowed + 1)
    if len(raw) > allowed:
        msg = f"they would unpack to more than {megabytes(allowed)}"
        raise ValueError(msg)
    if not unpacking.eof:
        raise ValueError("the packed text is incomplete")
    return raw
