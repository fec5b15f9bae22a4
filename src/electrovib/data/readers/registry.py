"""File formats of instruments: the reader of a file is found from its first bytes."""

from __future__ import annotations

import enum
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from electrovib.core.errors import DataFileError, nearest
from electrovib.data.columns.faults import check_file
from electrovib.data.readers import (
    hdf5_table,
    impedance_file,
    isf,
    laboratory_text,
    matlab_table,
    numpy_array,
    oscilloscope_binary,
    spreadsheet,
    tdms,
    touchstone,
    wave_audio,
)
from electrovib.data.readers.foreign import EXTRA
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

    `name` is that of the reader in options; `suffixes` are in small letters; `can_read` judges by the first
    bytes and the suffix; `package` has to be installed for it and is empty if none has to be.
    """

    name: str
    description: str
    suffixes: tuple[str, ...]
    can_read: Callable[[bytes, str], CanRead]
    read: Callable[..., Recorded]
    options: tuple[str, ...] = ()
    package: str = ""


def _is_isf(head: bytes, suffix: str) -> CanRead:
    if re.match(rb":?(WFMP|WFMO|BYT_N|CURV)", head.lstrip(), re.IGNORECASE):
        return CanRead.YES
    return CanRead.PERHAPS if suffix == ".isf" else CanRead.NO


def _is_wave(head: bytes, suffix: str) -> CanRead:
    del suffix
    return CanRead.YES if head[:4] in (b"RIFF", b"RIFX") and head[8:12] == b"WAVE" else CanRead.NO


def _begins(*starts: bytes, suffixes: tuple[str, ...] = ()) -> Callable[[bytes, str], CanRead]:
    """Return a function that recognises a format by its first bytes, or perhaps by its suffix."""

    def can_read(head: bytes, suffix: str) -> CanRead:
        if head.startswith(starts):
            return CanRead.YES
        return CanRead.PERHAPS if suffix in suffixes else CanRead.NO

    return can_read


def _is_hdf5(head: bytes, suffix: str) -> CanRead:
    if _is_matlab(head, suffix) is CanRead.YES:
        return CanRead.NO
    hdf = head.startswith((b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02")) or head[512:516] == b"\x89HDF"
    return CanRead.YES if hdf else CanRead.NO


def _is_matlab(head: bytes, suffix: str) -> CanRead:
    if head.startswith((b"MATLAB 5.0", b"MATLAB 7.3")):
        return CanRead.YES
    if head.startswith(b"\x89HDF") and suffix == ".mat":
        return CanRead.YES
    return CanRead.PERHAPS if suffix == ".mat" and b"\0" in head else CanRead.NO


def _is_spreadsheet(head: bytes, suffix: str) -> CanRead:
    if not head.startswith(b"PK\x03\x04"):
        return CanRead.NO
    known = suffix in (".xlsx", ".xlsm") or b"xl/" in head or b"[Content_Types]" in head
    return CanRead.YES if known else CanRead.NO


def _is_oscilloscope(head: bytes, suffix: str) -> CanRead:
    if oscilloscope_binary.is_oscilloscope_binary(head):
        return CanRead.YES
    return CanRead.PERHAPS if suffix in (".wfm", ".trc", ".bin") and b"\0" in head else CanRead.NO


def _is_impedance(head: bytes, suffix: str) -> CanRead:
    del suffix
    instrument = "" if b"\0" in head else impedance_file.instrument_of(head)
    return CanRead.YES if instrument and instrument not in impedance_file.TABLES else CanRead.NO


def _is_touchstone(head: bytes, suffix: str) -> CanRead:
    if b"\0" in head or suffix != ".s1p":
        return CanRead.NO
    return CanRead.YES


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
        name="numpy",
        description=numpy_array.DESCRIPTION,
        suffixes=(".npy",),
        can_read=_begins(b"\x93NUMPY"),
        read=numpy_array.read_numpy,
    ),
    FileFormat(
        name="matlab",
        description=matlab_table.DESCRIPTION,
        suffixes=(".mat",),
        can_read=_is_matlab,
        read=matlab_table.read_matlab_table,
        options=("part",),
    ),
    FileFormat(
        name="hdf5",
        description=hdf5_table.DESCRIPTION,
        suffixes=(".nc", ".h5", ".hdf5"),
        can_read=_is_hdf5,
        read=hdf5_table.read_hdf5,
        options=("part",),
    ),
    FileFormat(
        name="tdms",
        description=tdms.DESCRIPTION,
        suffixes=(".tdms",),
        can_read=_begins(b"TDSm"),
        read=tdms.read_tdms,
        options=("part",),
        package=tdms.PACKAGE,
    ),
    FileFormat(
        name="xlsx",
        description=spreadsheet.DESCRIPTION,
        suffixes=(".xlsx", ".xlsm"),
        can_read=_is_spreadsheet,
        read=spreadsheet.read_spreadsheet,
        options=("part",),
        package=spreadsheet.PACKAGE,
    ),
    FileFormat(
        name="scope",
        description=oscilloscope_binary.DESCRIPTION,
        suffixes=(".wfm", ".bin", ".trc"),
        can_read=_is_oscilloscope,
        read=oscilloscope_binary.read_oscilloscope_binary,
        package=oscilloscope_binary.PACKAGE,
    ),
    FileFormat(
        name="impedance",
        description=impedance_file.DESCRIPTION,
        suffixes=(".dta", ".z", ".mpt", ".par"),
        can_read=_is_impedance,
        read=impedance_file.read_impedance_file,
        package=impedance_file.PACKAGE,
    ),
    FileFormat(
        name="touchstone",
        description=touchstone.DESCRIPTION,
        suffixes=(".s1p",),
        can_read=_is_touchstone,
        read=touchstone.read_touchstone,
    ),
    FileFormat(
        name="text",
        description=laboratory_text.DESCRIPTION,
        suffixes=(".csv", ".tsv", ".txt", ".dat"),
        can_read=_is_text,
        read=laboratory_text.read_laboratory_text,
        options=("delimiter", "decimal_comma", "part"),
    ),
)
"""All formats; of several that take a file with the same certainty the first is used."""


def format_of(path: Path) -> FileFormat:
    """Find the format of a file from its first bytes and its suffix."""
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
    """Read a file of an instrument; an option that does not belong to its format is refused."""
    by_name = {each.name: each for each in FORMATS}
    if reader and reader not in by_name:
        raise DataFileError(f"there is no reader '{reader}'.{nearest(reader, by_name)}", path=path)
    chosen = by_name[reader] if reader else format_of(path)
    given = {name: value for name, value in options.items() if value is not None}
    if foreign := [name for name in given if name not in chosen.options]:
        raise DataFileError(f"the option {foreign[0]} does not belong to {chosen.description}.", path=path)
    return chosen.read(path, **given)


def format_lines() -> list[str]:
    """List the readers: name, what it reads, and the package it needs."""
    lines = [
        f"{each.name:<10} {each.description}" + (f"; needs {each.package}" if each.package else "")
        for each in FORMATS
    ]
    return [*lines, f"The packages are installed with: pip install 'electrovib[{EXTRA}]'"]


def format_table() -> str:
    """Write the readers as a table in Markdown, which is part of ``docs/importing.md``."""
    rows = [("name", "reads", "package"), ("---", "---", "---")]
    rows += [(f"`{each.name}`", each.description, each.package or "none") for each in FORMATS]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
