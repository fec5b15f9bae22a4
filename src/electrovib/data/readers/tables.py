"""Text files that hold several tables, each behind a line with its name, as Gamry writes them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import DataFileError, suggestion

if TYPE_CHECKING:
    from pathlib import Path

_BEGIN: Final = re.compile(rb"^([A-Za-z_]\w{0,60})\tTABLE\b[^\n]*\n", re.MULTILINE)
_HEAD: Final = re.compile(rb"\s*EXPLAIN\b")
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
    begins = list(_BEGIN.finditer(raw))[:_MOST] if _HEAD.match(raw) else []
    if not begins:
        if part:
            raise DataFileError(f"part = {part}: the file does not consist of parts with names.", path=path)
        return raw, {}
    ends = [each.start() for each in begins[1:]] + [len(raw)]
    tables: dict[str, bytes] = {}
    for begin, end in zip(begins, ends, strict=True):
        body = re.match(rb"(?:[ \t][^\n]*(?:\n|$))*", raw[begin.end() : end])
        tables.setdefault(begin[1].decode("ascii"), body[0] if body else b"")
    if part and part not in tables:
        raise DataFileError(
            f"part = {part}: there is no such table.{suggestion(part, tables)} It has {', '.join(list(tables)[:20])}.",
            path=path,
        )
    longest = max(tables, key=lambda name: len(tables[name]))
    chosen = part or (_SPECTRUM if _SPECTRUM in tables else longest)
    others = ", ".join([name for name in tables if name != chosen][:20])
    about = {"table": chosen} | ({"omitted": others} if others else {})
    return tables[chosen], _settings(raw[: begins[0].start()]) | about


def _settings(raw: bytes) -> dict[str, str]:
    """Return the settings ``KEY <tab> TYPE <tab> VALUE`` above the tables."""
    rows = (line.split("\t") for line in raw[:_LONGEST].decode("latin-1").splitlines()[:_MOST])
    return {row[0][:60]: row[2][:200] for row in rows if len(row) > 2 and row[0]}
