"""Spreadsheets (.xlsx), read with openpyxl."""

from __future__ import annotations

import dataclasses
import zipfile
from typing import TYPE_CHECKING, Final

from electrovib.core.budget import megabytes
from electrovib.core.errors import DataFileError
from electrovib.data.guarded import DAMAGE, damaged, packed, read_by_library
from electrovib.data.readers.text import read_laboratory_bytes
from electrovib.data.recorded import FileFormat, begins, one_part

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from electrovib.data.recorded import Recorded

_PACKAGE: Final = "openpyxl"
_UNPACKED: Final = 40
"""Largest ratio of the unpacked size to the size of the file; that of plain tables is about 10."""
_BASE: Final = 16 * 1024**2
_MOST_ENTRIES: Final = 2000
_MOST_SHEETS: Final = 20
_MOST_FILLED: Final = 64
"""Columns up to which shorter rows are filled with empty cells."""


def read_spreadsheet(path: Path, *, part: str = "") -> Recorded:
    """Read a sheet of a spreadsheet that holds rows of numbers; formulas count as the values that were saved with them."""
    size = path.stat().st_size
    unpacked = _declared_size(path)
    if unpacked > _UNPACKED * size + _BASE:
        raise packed(path, f"{megabytes(size)} would unpack to {megabytes(unpacked)}", "Save it as .csv.")
    found = read_by_library(lambda: dict(_sheets(path)), path, "a spreadsheet")
    sizes = {name: content.count(b"\n") + 1 for name, content in found.items()}
    problem: DataFileError | None = None
    for wanted in (part,) if part else found:
        name, others = one_part(sizes, wanted, "", "sheet with content")
        try:
            read = read_laboratory_bytes(found[name], delimiter="\t", decimal_comma=False, origin=name)
        except DataFileError as error:
            problem = problem or error
            continue
        return dataclasses.replace(read, not_read=(*read.not_read, *others))
    raise problem or DataFileError("holds no rows of numbers.")


def _declared_size(path: Path) -> int:
    """Return the size of the unpacked content that the directory of the archive declares [bytes]."""
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except (*DAMAGE, zipfile.BadZipFile) as error:
        raise damaged(path, "a spreadsheet", error) from None
    if len(entries) > _MOST_ENTRIES:
        raise DataFileError(f"holds {len(entries)} parts; a spreadsheet has at most {_MOST_ENTRIES}.")
    return sum(entry.file_size for entry in entries)


def _sheets(path: Path) -> Iterator[tuple[str, bytes]]:
    """Yield each sheet as bytes of text with tabs."""
    import openpyxl

    book = openpyxl.load_workbook(path, read_only=True, data_only=True, keep_links=False)
    for sheet in book.worksheets[:_MOST_SHEETS]:
        sheet.reset_dimensions()  # the declared size of a sheet may be false
        lines = ["\t".join(map(_cell, row)).rstrip() for row in sheet.iter_rows(values_only=True)]
        if any(lines):
            width = min(max(line.count("\t") for line in lines), _MOST_FILLED)
            lines = [line and line + "\t" * (width - line.count("\t")) for line in lines]
            yield sheet.title, "\n".join(lines).encode("utf-8", "replace")


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, (bool, int, float)):
        return repr(float(value))
    return str(value).replace("\t", " ").replace("\n", " ")


FORMAT: Final = FileFormat(
    name="xlsx",
    description="spreadsheets (.xlsx): the first sheet with numbers, or the one chosen",
    can_read=begins(rb"PK\x03\x04.*(xl/|\[Content_Types\])", ".xlsx", ".xlsm"),
    read=read_spreadsheet,
    options=("part",),
    package=_PACKAGE,
    otherwise=", or save it as .csv",
)
