"""TOML files of the user: the one place where they are opened."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from electrovib.core.budget import megabytes
from electrovib.core.errors import InputError
from electrovib.core.files import note_input
from electrovib.core.parsing import read_toml

if TYPE_CHECKING:
    from pathlib import Path

_LARGEST: Final = 64_000_000
"""Bytes of a file, at most: a scenario with a million samples of a drive takes half of them."""


def read_toml_file(path: Path, *, kind: str, advice: str) -> dict[str, Any]:
    """Read the tables of an ordinary file; what else a name may stand for is not opened."""
    note_input(path)
    try:
        if path.exists() and not path.is_file():
            raise InputError(
                f"is {'a folder' if path.is_dir() else 'not an ordinary file'}. {advice}", path=path
            )
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
    except OSError as error:
        raise InputError(f"{error.strerror or error}. {advice}", path=path) from None
    if len(content) > _LARGEST:
        raise InputError(f"is larger than {megabytes(_LARGEST)}, the most that {kind} may take", path=path)
    try:
        return read_toml(content.decode("utf-8-sig"))  # editors of Windows begin with a byte-order mark
    except UnicodeDecodeError:
        raise InputError(f"not a text in UTF-8; {kind} is TOML, saved as UTF-8", path=path) from None
    except ValueError as error:
        raise InputError(f"not valid TOML: {error}", path=path) from None
