"""What a reader of foreign files declares: its name, the files that it takes, and how it reads them."""

from __future__ import annotations

import enum
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from electrovib.data.recorded import Column, Recorded

ColumnReader: TypeAlias = Callable[[Path, Sequence[str | int], bool], dict[str | int, Column]]
"""Of path, columns by heading or number, and whether fields may be empty."""


class CanRead(enum.Enum):
    """Whether a reader takes a file."""

    NO = 0
    PERHAPS = 1
    YES = 2


@dataclass(frozen=True, kw_only=True)
class FileFormat:
    """One format of files.

    - `name`: of the reader in options.
    - `suffixes`: in small letters; a file with one of them is perhaps of this format.
    - `can_read`: judges by the first bytes and the suffix.
    - `read`: reads whatever a file holds.
    - `columns`: reads the chosen columns and refuses what is no number in them; by default those of `read`.
    - `options`: what `read` takes besides the path.
    - `package`: has to be installed for it; empty if none has to be.
    - `is_last`: asked after all others.
    """

    name: str
    description: str
    suffixes: tuple[str, ...]
    can_read: Callable[[bytes, str], CanRead]
    read: Callable[..., Recorded]
    columns: ColumnReader | None = None
    options: tuple[str, ...] = ()
    package: str = ""
    is_last: bool = False


def begins(pattern: bytes, *suffixes: str) -> Callable[[bytes, str], CanRead]:
    """Return a function that recognises a format by a pattern of its first bytes, or perhaps by its suffix."""
    form = re.compile(pattern, re.DOTALL)

    def can_read(head: bytes, suffix: str) -> CanRead:
        if form.match(head):
            return CanRead.YES
        return CanRead.PERHAPS if suffix in suffixes else CanRead.NO

    return can_read
