"""The file formats of instruments: which reader takes a file, told from its first bytes."""

from __future__ import annotations

import enum
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from electrovib.core.errors import DataFileError, nearest
from electrovib.data.columns.faults import check_file
from electrovib.data.readers import isf, laboratory_text, wave_audio
from electrovib.data.readers.recorded import Recorded

HEAD: Final = 4096
"""First bytes from which a format is recognised."""


class CanRead(enum.Enum):
    """Whether a reader takes a file."""

    NO = 0
    PERHAPS = 1
    YES = 2


@dataclass(frozen=True, kw_only=True)
class FileFormat:
    """One format of files.

    Parameters
    ----------
    name : str
        How an option names it.
    description : str
        What it is, with its suffixes.
    suffixes : tuple of str
        Usual ends of its names, in small letters.
    can_read : callable
        First bytes and suffix, to whether the reader takes the file.
    read : callable
        Path and options, to the content.
    options : tuple of str
        Options that `read` takes.
    """

    name: str
    description: str
    suffixes: tuple[str, ...]
    can_read: Callable[[bytes, str], CanRead]
    read: Callable[..., Recorded]
    options: tuple[str, ...] = ()


def _is_isf(head: bytes, suffix: str) -> CanRead:
    if re.match(rb":?(WFMP|WFMO|BYT_N|CURV)", head.lstrip(), re.IGNORECASE):
        return CanRead.YES
    return CanRead.PERHAPS if suffix == ".isf" else CanRead.NO


def _is_wave(head: bytes, suffix: str) -> CanRead:
    del suffix
    return CanRead.YES if head[:4] in (b"RIFF", b"RIFX") and head[8:12] == b"WAVE" else CanRead.NO


def _is_text(head: bytes, suffix: str) -> CanRead:
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return CanRead.PERHAPS
    if b"\0" in head:
        return CanRead.NO
    return CanRead.YES if suffix in (".csv", ".tsv", ".txt", ".dat") else CanRead.PERHAPS


FORMATS: Final = (
    FileFormat(
        name="isf",
        description=isf.DESCRIPTION,
        suffixes=(".isf",),
        can_read=_is_isf,
        read=isf.read_isf,
    ),
    FileFormat(
        name="wav",
        description=wave_audio.DESCRIPTION,
        suffixes=(".wav",),
        can_read=_is_wave,
        read=wave_audio.read_wave,
    ),
    FileFormat(
        name="text",
        description=laboratory_text.DESCRIPTION,
        suffixes=(".csv", ".tsv", ".txt", ".dat"),
        can_read=_is_text,
        read=laboratory_text.read_laboratory_text,
        options=("delimiter", "decimal_comma"),
    ),
)
"""In the order in which they are asked."""


def format_of(path: Path) -> FileFormat:
    """Find the format of a file from its first bytes and its suffix.

    Raises
    ------
    DataFileError
        If no reader takes it; the message lists the formats.
    """
    check_file(path)
    with path.open("rb") as file:
        head = file.read(HEAD)
    answers = [(each.can_read(head, path.suffix.lower()).value, each) for each in FORMATS]
    best = max(value for value, _ in answers)
    if best == CanRead.NO.value:
        listed = "; ".join(each.description for each in FORMATS)
        raise DataFileError(f"is in no format that is known. Known are {listed}.", path=path)
    return next(each for value, each in answers if value == best)


def read_recorded(path: Path, *, reader: str = "", **options: Any) -> Recorded:
    """Read a file of an instrument.

    Parameters
    ----------
    path : Path
        The file.
    reader : str
        Name of a format; found from the file if empty.
    **options
        What the format takes, ``delimiter`` and ``decimal_comma`` of text.

    Returns
    -------
    Recorded
        Its channels.

    Raises
    ------
    DataFileError
        If no reader takes it, it is damaged, or an option does not belong to its format.
    """
    by_name = {each.name: each for each in FORMATS}
    if reader and reader not in by_name:
        raise DataFileError(f"there is no reader '{reader}'.{nearest(reader, by_name)}", path=path)
    chosen = by_name[reader] if reader else format_of(path)
    given = {name: value for name, value in options.items() if value is not None}
    if foreign := [name for name in given if name not in chosen.options]:
        raise DataFileError(f"the option {foreign[0]} does not belong to {chosen.description}.", path=path)
    return chosen.read(path, **given)


def format_lines() -> list[str]:
    """List the readers: name, what it reads, and what has to be installed for it."""
    return [f"{each.name:<10} {each.description}" for each in FORMATS]
