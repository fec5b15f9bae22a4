"""File formats of instruments: the reader of a file is found from its first bytes, else from its suffix."""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import DataFileError, nearest
from electrovib.data import readers
from electrovib.data.faults import check_file
from electrovib.data.file_format import CanRead, FileFormat
from electrovib.data.recorded import EXTRA, Recorded

if TYPE_CHECKING:
    from pathlib import Path

HEAD: Final = 4096
"""First bytes from which a format is recognised."""


def _formats() -> tuple[FileFormat, ...]:
    """Collect the ``FORMAT`` of every module of `electrovib.data.readers`."""
    names = (f"{readers.__name__}.{info.name}" for info in pkgutil.iter_modules(readers.__path__))
    found: list[FileFormat] = [importlib.import_module(name).FORMAT for name in names]
    return tuple(sorted(found, key=lambda each: (each.is_last, each.name)))


FORMATS: Final = _formats()
"""All formats; of several that take a file with the same certainty the first is used."""


def format_of(path: Path) -> FileFormat:
    """Find the format of a file from its first bytes and its suffix."""
    check_file(path)
    with path.open("rb") as file:
        head = file.read(HEAD)
    best = max(FORMATS, key=lambda each: each.can_read(head, path.suffix.lower()).value)
    if best.can_read(head, path.suffix.lower()) is CanRead.NO:
        listed = "; ".join(each.description for each in FORMATS)
        raise DataFileError(f"is in no format that is known. Known are {listed}.", path=path)
    return best


def read_recorded(path: Path, *, reader: str = "", **options: Any) -> Recorded:
    """Read a file of an instrument; an option that does not belong to its format is refused."""
    by_name = {each.name: each for each in FORMATS}
    if reader and reader not in by_name:
        raise DataFileError(f"there is no reader '{reader}'.{nearest(reader, by_name)}", path=path)
    chosen = by_name[reader] if reader else format_of(path)
    check_file(path)
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
