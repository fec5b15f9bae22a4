"""Files of text that hold several tables: of Gamry and VersaStudio, and those whose row of headings is repeated."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import DataFileError, suggestion
from electrovib.data.text.layout import is_row_of_numbers, place_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from electrovib.data.text.layout import Layout


_BEGIN: Final = re.compile(rb"^([A-Za-z_]\w{0,60})\tTABLE\b[^\n]*\n", re.MULTILINE)
_HEAD: Final = re.compile(rb"\s*EXPLAIN\b")
_SEGMENT: Final = re.compile(rb"^<(Segment\d{1,6})>\s*$", re.MULTILINE)
_SPECTRUM: Final = "ZCURVE"
_LABEL: Final = re.compile(
    r"(step|segment|cycle|sweep|block|run|test|measurement)\W{0,3}(?:no|nr|number)?\W{0,3}(\d{1,6})\b",
    re.IGNORECASE,
)
"""Line above a table that numbers it, such as ``Step No. 2``."""
_MOST: Final = 1000
_LONGEST: Final = 200_000
_MOST_ABOVE: Final = 200
"""Lines above a row of headings among which the end of the table before it is looked for."""
_LONGEST_LABEL: Final = 4000
_SHORTEST: Final = 3
"""Fewest bytes of a row of headings that divides a text."""


def one_table(path: Path, raw: bytes, part: str) -> tuple[bytes, dict[str, str]]:
    """Return one table of a text that holds several; by default that of an impedance spectrum, else the longest one."""
    tables, about = _of_gamry(raw) if _HEAD.match(raw) else _of_versastudio(raw)
    if not tables:
        return raw, {}
    chosen, others = _chosen(path, tables, part)
    return tables[chosen], about | {"table": chosen} | ({"omitted": others} if others else {})


def repeated_table(path: Path, raw: bytes, layout: Layout, part: str) -> tuple[bytes, dict[str, str]]:
    """Return one of the tables of a text whose row of headings occurs several times, as tribometers write one for each step."""
    tables = _of_headings(raw, layout)
    if not tables:
        return raw, {}
    chosen, others = _chosen(path, tables, part)
    return tables[chosen], {"table": chosen, "omitted": others}


def _chosen(path: Path, tables: Mapping[str, bytes], part: str) -> tuple[str, str]:
    """Return the name of the table that was asked for, else that of a spectrum or of the longest one, and those of the others."""
    if part and part not in tables:
        raise DataFileError(
            f"part = {part}: there is no such table.{suggestion(part, tables)} It has {', '.join(list(tables)[:20])}.",
            path=path,
        )
    longest = max(tables, key=lambda name: len(tables[name]))
    chosen = part or (_SPECTRUM if _SPECTRUM in tables else longest)
    return chosen, ", ".join([name for name in tables if name != chosen][:20])


def _of_headings(raw: bytes, layout: Layout) -> dict[str, bytes]:
    """Return the tables that begin with the same row of headings, each with the lines above it; none if there is one."""
    lines = raw[: place_of(raw, layout.first)].split(b"\n")[: layout.first]
    if layout.headings >= len(lines) or len(heading := lines[layout.headings].strip(b"\r")) < _SHORTEST:
        return {}
    form = re.compile(rb"^" + re.escape(heading) + rb"\r?$", re.MULTILINE)
    begins = [found.start() for found in itertools.islice(form.finditer(raw), _MOST)]
    ends = [_end_of_numbers(raw, begin, layout) for begin in begins[1:]]
    spans = list(zip([0, *ends], [*ends, len(raw)], strict=True))
    if len(begins) < 2 or any(end <= begin for begin, (_, end) in zip(begins, spans, strict=True)):
        return {}
    labels = [
        _LABEL.findall(raw[start:begin][-_LONGEST_LABEL:].decode("latin-1"))
        for (start, _), begin in zip(spans, begins, strict=True)
    ]
    names = [f"{each[-1][0].lower()} {each[-1][1]}" if each else "" for each in labels]
    if len(set(names)) < len(names) or "" in names:
        names = [f"table {number}" for number in range(1, len(begins) + 1)]
    return {name: raw[start:end] for name, (start, end) in zip(names, spans, strict=True)}


def _end_of_numbers(raw: bytes, begin: int, layout: Layout) -> int:
    """Return where the last row of numbers above a place ends."""
    end = begin
    for _ in range(_MOST_ABOVE):
        start = raw.rfind(b"\n", 0, max(end - 1, 0)) + 1
        if start >= end or is_row_of_numbers(raw[start:end].decode("latin-1").rstrip("\r\n"), layout):
            return end
        end = start
    return end


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
