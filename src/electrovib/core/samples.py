"""Measured numbers inside a model: a read-only array whose content counts for equality and hash."""

from __future__ import annotations

import base64
import hashlib
import zlib
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

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
        """Write the numbers without loss as short text."""
        raw = self.values.astype("<f8").tobytes()
        return _MARK + base64.b64encode(zlib.compress(raw, 6)).decode()

    @classmethod
    def read(cls, value: object) -> Samples:
        """Accept samples, an array, a list or packed text."""
        if isinstance(value, Samples):
            return value
        try:
            if isinstance(value, str) and value.startswith(_MARK):
                raw = zlib.decompress(base64.b64decode(value[len(_MARK) :], validate=True))
                return cls(np.frombuffer(raw, dtype="<f8"))
            if isinstance(value, (list, tuple, np.ndarray)):
                return cls(np.asarray(value, dtype=np.float64))
        except (ValueError, TypeError, zlib.error) as error:
            raise PydanticCustomError("samples", "{why}", {"why": f"not numbers: {error}"}) from None
        raise PydanticCustomError("samples", "{why}", {"why": "expected a list of numbers"})

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate through `read`."""
        del source, handler
        return core_schema.no_info_plain_validator_function(cls.read)
