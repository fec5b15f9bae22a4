"""Text files that hold several tables, each behind a line with its name, as Gamry and VersaStudio write them."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import DataFileError, suggestion

if TYPE_CHECKING:
    from pathlib import Path

_BEGIN: Final = re.compile(rb"^([A-Za-z_]\w{0,60})\tTABLE\b[^\n]*\n", re.MULTILINE)
_HEAD: Final = re.compile(rb"\s*EXPLAIN\b")
_SEGMENT: Final = re.compile(rb"^<(Segment\d{1,6})>\s*$", re.MULTILINE)
_SPECTRUM: Final = "ZCURVE"
_MOST: Final = 1000
_LONGEST: Final = 200_000


def one_table(path: Path, raw: bytes, part: str) -> tuple[bytes, dict[str, str]]:
    """Return one table of a file that holds several.

    Parameters
    ----------
    path : Path
        File, for messages.
    raw : bytes
        Its text.
    part : str
        Name of the table; if empty, the table of an impedance spectrum, else the longest one.

    Returns
    -------
    text : bytes
        The table; the whole text if it does not consist of such tables.
    attributes : dict of str to str
        ``table``, the name of the table, ``omitted``, the names of the others, and the settings of the file; empty if there
        are no tables.

    Raises
    ------
    DataFileError
        If there is no table of that name.
    """
    tables, about = _of_gamry(raw) if _HEAD.match(raw) else _of_versastudio(raw)
    if not tables:
        if part:
            raise DataFileError(f"part = {part}: the file does not consist of parts with names.", path=path)
        return raw, {}
    if part and part not in tables:
        raise DataFileError(
            f"part = {part}: there is no such table.{suggestion(part, tables)} It has {', '.join(list(tables)[:20])}.",
            path=path,
        )
    longest = max(tables, key=lambda name: len(tables[name]))
    chosen = part or (_SPECTRUM if _SPECTRUM in tables else longest)
    others = ", ".join([name for name in tables if name != chosen][:20])
    return tables[chosen], about | {"table": chosen} | ({"omitted": others} if others else {})


def _of_gamry(raw: bytes) -> tuple[dict[str, bytes], dict[str, str]]:
    """Return the tables behind lines ``NAME <tab> TABLE``, and the settings ``KEY <tab> TYPE <tab> VALUE`` above them."""
    begins = list(itertools.islice(_BEGIN.finditer(raw), _MOST))
    ends = [*(each.start() for each in begins[1:]), len(raw)][: len(begins)]
    tables: dict[str, bytes] = {}
    for begin, end in zip(begins, ends, strict=True):
        body = re.match(rb"(?:[ \t][^\n]*(?:\n|$))*", raw[begin.end() : end])
        tables.setdefault(begin[1].decode("ascii"), body[0] if body else b"")
    above = raw[: begins[0].start() if begins else 0][:_LONGEST].decode("latin-1").splitlines()
    rows = (line.split("\t") for line in above[:_MOST])
    return tables, {row[0][:60]: row[2][:200] for row in rows if len(row) > 2 and row[0]}


def _of_versastudio(raw: bytes) -> tuple[dict[str, bytes], dict[str, str]]:
    """Return the tables between ``<Segment1>`` and ``</Segment1>``, and the settings ``key=value`` before the first of them."""
    tables: dict[str, bytes] = {}
    begins = list(itertools.islice(_SEGMENT.finditer(raw), _MOST)) if raw.lstrip().startswith(b"<") else []
    for number, begin in enumerate(begins):
        stop = begins[number + 1].start() if number + 1 < len(begins) else len(raw)
        end = raw.find(b"\n<", begin.end(), stop)
        body = raw[begin.end() : end if end >= 0 else stop]
        heading = body.find(b"Definition=")
        if heading >= 0:
            tables.setdefault(begin[1].decode("ascii"), body[heading + len(b"Definition=") :])
    above = raw[: begins[0].start() if begins else 0][:_LONGEST].decode("utf-8", "replace").splitlines()
    pairs = (line.partition("=") for line in above[:_MOST])
    return tables, {key[:60]: value[:200] for key, sign, value in pairs if sign}
