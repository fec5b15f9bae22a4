"""Faults of files, each stated in one sentence."""

from __future__ import annotations

import struct
import tokenize
import warnings
import zlib
from typing import TYPE_CHECKING, Final, TypeVar

from electrovib.core.errors import DataFileError, InputError, closest_file
from electrovib.core.file_kinds import foreign, is_address

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

T = TypeVar("T")
DAMAGE: Final = (
    OSError, RuntimeError, ValueError, LookupError, TypeError, AttributeError, EOFError, MemoryError,
    ArithmeticError, SyntaxError, AssertionError, struct.error, tokenize.TokenError, zlib.error,
)  # fmt: skip
"""Exceptions that the NumPy, SciPy and HDF5 libraries raise for damaged files."""


def check_file(path: Path) -> None:
    """Refuse anything but an ordinary file that is not empty."""
    try:
        if path.is_dir():
            raise DataFileError("is a folder; give the name of a file in it.", path=path)
        if is_address(path):
            raise DataFileError(f"{foreign(path)}.", path=path)
        if not path.exists():
            siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            raise DataFileError(f"there is no such file.{closest_file(path.name, siblings)}", path=path)
        if not path.is_file():
            raise DataFileError("is not an ordinary file.", path=path)
        with path.open("rb") as file:
            if not file.read(1):
                raise DataFileError("the file is empty.", path=path)
    except (OSError, ValueError) as error:
        raise DataFileError(f"cannot be read: {error}.", path=path) from None


def packed(
    path: Path, what: str, advice: str = "If it is whole, save it without compression."
) -> DataFileError:
    """Return the error for a file that states, or unfolds to, more than one of its size may hold."""
    return DataFileError(f"is damaged, or packed too tightly: {what}. {advice}".rstrip(), path=path)


def damaged(path: Path, what: str, error: BaseException) -> DataFileError:
    """Return the error for a damaged file, with the first line of the message of the library."""
    said = (str(error).splitlines() or [""])[0][:160] or type(error).__name__
    return DataFileError(f"is damaged or not {what} ({said}).", path=path)


def read_by_library(read: Callable[[], T], path: Path, what: str) -> T:
    """Return what a library reads from a file; whatever it raises is a fault of the file."""
    check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read()
    except InputError:
        raise
    except MemoryError:
        raise packed(path, "its content does not fit into memory") from None
    except Exception as error:  # noqa: BLE001  # packages have many kinds, of which none derives from a common one
        raise damaged(path, what, error) from None
