"""Measured numbers inside a model: a read-only array whose content counts for equality and hash."""

from __future__ import annotations

import base64
import hashlib
import zlib
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from electrovib.core.allowance import content_allowed, megabytes

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from pydantic import GetCoreSchemaHandler

_MARK = "zlib+base64:"


class Samples:
    """A read-only one-dimensional float64 array, a value: its content counts, and nothing changes it.

    Parameters
    ----------
    values : array_like
        Copied; one dimension.
    """

    __slots__ = ("_raw",)
    _raw: bytes

    def __init__(self, values: ArrayLike) -> None:
        array = np.array(values, dtype=np.float64)
        if array.ndim != 1:
            msg = f"samples have one dimension, not {array.ndim}"
            raise ValueError(msg)
        object.__setattr__(self, "_raw", array.tobytes())

    @property
    def values(self) -> NDArray[np.float64]:
        """The numbers; an array on bytes, which cannot be made writeable."""
        return np.frombuffer(self._raw, np.float64)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse: samples stay what they are."""
        raise AttributeError(f"samples are read-only: '{name}' cannot be set")

    def __reduce__(self) -> tuple[type[Samples], tuple[NDArray[np.float64]]]:
        """Pickle and copy through the constructor, so that a copy is read-only too."""
        return type(self), (self.values,)

    def __eq__(self, other: object) -> bool:
        """Compare every bit."""
        return isinstance(other, Samples) and self._raw == other._raw

    def __hash__(self) -> int:
        """Hash the content."""
        return hash(self._raw)

    def __len__(self) -> int:
        """Count the samples."""
        return len(self.values)

    def __repr__(self) -> str:
        """Show the size only."""
        return f"<{len(self)} samples>"

    def canonical_content(self) -> dict[str, Any]:
        """Give what stands for the numbers in a hash."""
        little_endian = self.values.astype("<f8").tobytes()
        return {"size": len(self), "sha256": hashlib.sha256(little_endian).hexdigest()}

    def packed(self) -> str:
        """Write the numbers without loss as short text that `read` accepts."""
        raw = self.values.astype("<f8").tobytes()
        packed = zlib.compress(raw, 6)
        if len(raw) > content_allowed(len(packed)):  # numbers that are all alike
            packed = zlib.compress(raw, 0)
        return _MARK + base64.b64encode(packed).decode()

    @classmethod
    def read(cls, value: object) -> Samples:
        """Accept samples, an array, a list or packed text."""
        if isinstance(value, Samples):
            return value
        try:
            if isinstance(value, str) and value.startswith(_MARK):
                return cls(np.frombuffer(_unpacked(value[len(_MARK) :]), dtype="<f8"))
            if isinstance(value, (list, tuple, np.ndarray)):
                return cls(np.asarray(value, dtype=np.float64))
        except (ValueError, TypeError, OverflowError, zlib.error) as error:
            raise PydanticCustomError("samples", "{why}", {"why": f"not numbers: {error}"}) from None
        raise PydanticCustomError("samples", "{why}", {"why": "expected a list of numbers"})

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate through `read`."""
        del source, handler
        return core_schema.no_info_plain_validator_function(cls.read)


def _unpacked(text: str) -> bytes:
    """Unpack no more than so much text may unfold to."""
    packed = base64.b64decode(text, validate=True)
    allowed = content_allowed(len(packed))
    unpacking = zlib.decompressobj()
    raw = unpacking.decompress(packed, allowed + 1)
    if len(raw) > allowed:
        msg = f"they would unfold to more than {megabytes(allowed)}"
        raise ValueError(msg)
    if not unpacking.eof:
        raise ValueError("they are cut short")
    return raw
