"""Marks of the files that this package writes, each a checksum of its content; tables as CSV and JSON that carry one."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import re
from collections.abc import Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from electrovib.core.diagnostics import Diagnostic, comment_lines
from electrovib.core.errors import DataFileError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    import xarray


class Form(StrEnum):
    """Form of a file that this package writes."""

    NETCDF = "Trace as netCDF"
    MATLAB = "Trace as MATLAB file"
    PAGE = "HTML page"
    NETLIST = "netlist"
    SCENARIO = "scenario"
    TABLE = "table as CSV"
    SPACE = "space of parameters"
    CHECK = "check of limits as JSON"
    DESIGN = "design as JSON"
    WAVEFORM = "waveform"
    STUDY = "study"
    MEASUREMENT = "measurement"
    FIGURE = "figure"
    LATEX = "tables in LaTeX"
    TEXT = "text"


WRITTEN_BY: Final = "written_by"
"""Name of the mark in formats with named attributes."""

VERIFIED: Final = "checksum"
"""Name of the diagnostic of a Trace that could not be verified."""

_EMPTY: Final = "0" * 32
_HEAD: Final = 1 << 16  # every format has its mark in its first or last 64 kB
_BLOCK: Final = 1 << 20


def unsigned(form: Form) -> str:
    """Return the mark that a writer puts once near the beginning or the end of its content and that `sign` completes."""
    return f"electrovib {form}, checksum {_EMPTY}"


def plain(value: Any) -> Any:
    """Return numbers and tables as JSON has them: lists, and None for a number that is not finite."""
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    value = value.tolist() if hasattr(value, "tolist") else value  # an array of numpy
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(form: Form, content: Mapping[str, object]) -> str:
    """Write nested tables as JSON with the mark of their form."""
    marked = {WRITTEN_BY: unsigned(form)} | dict(content)
    return json.dumps(marked, indent=1, ensure_ascii=False) + "\n"


def sign(path: Path, form: Form) -> None:
    """Write the checksum of a complete file into its mark; a file without a mark remains unchanged."""
    with path.open("r+b") as file:
        if place := _place(file, unsigned(form).encode()):
            checksum = _checksum(file, place)
            file.seek(place)
            file.write(checksum)


def is_ours(path: Path, form: Form) -> bool:
    """Return whether this package wrote a file in this form and it has not been changed since."""
    try:
        return bool(_is_unchanged(path, form))
    except OSError:
        return False


def _is_unchanged(path: Path, form: Form) -> bool | None:
    """Return whether a file has the content of the checksum in its mark; None without a mark of this form."""
    with path.open("rb") as file:
        if not (place := _place(file, _any_checksum(form))):
            return None
        file.seek(place)
        return file.read(len(_EMPTY)) == _checksum(file, place)


def has_checksum(path: Path, form: Form) -> bool:
    """Return whether a file has the content of its checksum, False without one; a file that was changed is refused."""
    unchanged = _is_unchanged(path, form)
    if unchanged is False:
        raise DataFileError(
            "is damaged, or was edited: its content is not that of its checksum. Make it again; a file that was edited on"
            f" purpose is read, not verified, without its attribute {WRITTEN_BY}",
            path=path,
        )
    return bool(unchanged)


def not_verified(trace: xarray.Dataset, path: Path) -> xarray.Dataset:
    """Return a Trace that was read from a file without a checksum, which says so."""
    why = f"not verified: {path.name} states no checksum, so that damage of its numbers would not be noticed"
    judged = json.loads(trace.attrs.get("validity", "[]"))
    judged.append(Diagnostic(VERIFIED, "warning", why).to_dict())
    trace.attrs["validity"] = json.dumps(judged)
    return trace


def _any_checksum(form: Form) -> bytes:
    return re.escape(unsigned(form).removesuffix(_EMPTY).encode()) + b"[0-9a-f]{%d}" % len(_EMPTY)


def _place(file: BinaryIO, mark: bytes) -> int:
    """Find where the checksum of a mark begins, near the beginning or the end of a file; 0 without one."""
    size = file.seek(0, io.SEEK_END)
    for start in (0, max(size - _HEAD, 0)):
        file.seek(start)
        if found := re.search(mark, file.read(_HEAD)):
            return start + found.end() - len(_EMPTY)
    return 0


def _checksum(file: BinaryIO, place: int) -> bytes:
    """Hash a file with zeros in place of its checksum."""
    hashed = hashlib.sha256()
    file.seek(0)
    hashed.update(file.read(place))
    hashed.update(_EMPTY.encode())
    file.seek(place + len(_EMPTY))
    while block := file.read(_BLOCK):
        hashed.update(block)
    return hashed.hexdigest()[: len(_EMPTY)].encode()


def csv_text(
    headings: Sequence[object],
    rows: Iterable[Iterable[object]],
    *,
    remarks: Iterable[str] = (),
    diagnostics: Iterable[Diagnostic] = (),
    marked: bool = True,
) -> str:
    """Write a table, `marked` as one that a later run may replace; a cell None stays empty."""
    text = io.StringIO()
    text.write(csv_head(remarks, diagnostics, marked=marked))
    table = csv.writer(text, lineterminator="\n")
    table.writerow(headings)
    table.writerows([_cell(each) for each in row] for row in rows)
    return text.getvalue()


def csv_head(
    remarks: Iterable[str] = (), diagnostics: Iterable[Diagnostic] = (), *, marked: bool = True
) -> str:
    """Write the comments before a table: its mark, the remarks that are not empty, and the diagnostics."""
    said = [" ".join(each.split()) for each in remarks if each]
    lines = [unsigned(Form.TABLE)] * marked + said
    return "".join(f"# {line}\n" for line in lines) + comment_lines(diagnostics)


def _cell(value: object) -> object:
    return "" if value is None else repr(float(value)) if isinstance(value, float) else value
