"""Files of text with several tables, of Gamry, VersaStudio or with several rows of headings, or with times that turn back."""

from __future__ import annotations

import dataclasses
import itertools
import re
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.errors import DataFileError, suggestion
from electrovib.data.recorded import NotRead, Recorded
from electrovib.data.unit_words import Notation

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real


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
_MOST_LINES: Final = 20_000
"""Lines of words from which on a text has words in its rows, and is not divided."""
_LONGEST_LABEL: Final = 4000
_FEWEST: Final = 2
"""Fewest rows of a table, and of a segment."""
_LOWEST: Final = 4
"""Lines right above the numbers among which headings are looked for."""
_NEAR: Final = 0.05
"""Difference of the beginnings of two segments over the length of the first."""
_END_OF_CELL: Final = re.compile(r"[\t;,\r\n]| {2}")
_LONGEST_CELL: Final = 64
_MOST_SIGNS: Final = 4
_BEFORE_WORDS: Final = np.isin(np.arange(256), list(b' \t"#%[(*<_'))
"""Whether a word may stand behind a byte at the beginning of a line, at most `_MOST_SIGNS` of them."""
_LETTERS: Final = np.array([chr(sign).isalpha() if sign < 128 else sign != 0xE2 for sign in range(256)])
"""Whether a byte begins a letter; dashes and other signs of UTF-8 begin with E2."""
_LINE_FEED: Final = 10
_ROW: Final = re.compile(rb"^[ \t;,\"(]*(?:[+-]|\xe2\x88\x92)? *[.,]?\d", re.MULTILINE)
"""Beginning of a row of numbers."""


Table: TypeAlias = "tuple[bytes, dict[str, str], tuple[NotRead, ...]]"
"""Text of one table, what is stated of it, and the others."""


def one_table(path: Path, raw: bytes, part: str) -> Table:
    """Return one table of a text that holds several; by default that of an impedance spectrum, else the longest one."""
    tables, about = _of_gamry(raw) if _HEAD.match(raw) else _of_versastudio(raw)
    return _chosen(path, raw, tables, part, about)


def repeated_table(path: Path, raw: bytes, part: str) -> Table:
    """Return one of the tables of a text that has several rows of headings, as tribometers write one for each step."""
    tables = _of_headings(raw)
    return _chosen(path, raw, tables if len(tables) > 1 else {}, part, {})


def _chosen(path: Path, raw: bytes, tables: Mapping[str, bytes], part: str, about: dict[str, str]) -> Table:
    """Return the table that was asked for, else that of a spectrum or the longest one; the whole text if it has none."""
    if not tables:
        return raw, {}, ()
    longest = max(tables, key=lambda name: len(tables[name]))
    chosen = part or (_SPECTRUM if _SPECTRUM in tables else longest)
    _check(path, chosen, tables)
    others = {name: len(_ROW.findall(table)) for name, table in tables.items() if name != chosen}
    return tables[chosen], about | {"table": chosen}, _named(others)


def _check(path: Path, part: str, known: Collection[str]) -> None:
    if part not in known:
        raise DataFileError(
            f"part = {part}: there is no such table.{suggestion(part, known)} It has {', '.join(list(known)[:20])}.",
            path=path,
        )


def _named(rows: Mapping[str, int]) -> tuple[NotRead, ...]:
    """Name the parts that were not chosen, with their numbers of rows."""
    why = "another part of {} rows; choose it with part (--set part=NAME)"
    return tuple(NotRead(name=name, why=why.format(count)) for name, count in rows.items())


def one_segment(path: Path, recorded: Recorded, part: str) -> Recorded:
    """Return one of the segments of a record whose times turn back to their beginning; by default the longest one."""
    times = recorded.times() if recorded.time else None
    found = segments_of(times) if times is not None else []
    if len(found) < 2:
        if part:
            raise DataFileError(
                f"part = {part}: the file does not consist of parts with names; omit it.", path=path
            )
        return recorded
    segments = {f"segment {number}": rows for number, rows in enumerate(found, 1)}
    sizes = {name: rows.stop - rows.start for name, rows in segments.items()}
    chosen = part or max(sizes, key=sizes.__getitem__)
    _check(path, chosen, segments)
    del sizes[chosen]
    return dataclasses.replace(
        recorded,
        channels=tuple(
            dataclasses.replace(each, values=each.values[segments[chosen]].copy())
            for each in recorded.channels
        ),
        attributes={**recorded.attributes, "table": chosen},
        not_read=(*recorded.not_read, *_named(sizes)),
    )


def segments_of(times: Real) -> list[slice]:
    """Return the rows of each segment of times that turn back to near their beginning; one if they do not."""
    turns = np.flatnonzero(np.diff(times) < 0) + 1
    ends = [0, *turns.tolist(), times.size]
    spans = [slice(start, stop) for start, stop in itertools.pairwise(ends)]
    first = times[spans[0]]
    near = _NEAR * np.ptp(first) if first.size else 0.0
    whole = len(spans) <= _MOST and all(
        each.stop - each.start >= _FEWEST and abs(times[each.start] - times[0]) <= near for each in spans
    )
    return spans if whole else [slice(0, times.size)]


def _of_headings(raw: bytes) -> dict[str, bytes]:
    """Return the tables of a text that has rows of headings between rows of numbers, each with the lines above it."""
    lines = _lines_of_words(raw)
    blocks: list[tuple[int, int]] = []
    for start in lines:
        if _has_number(
            _END_OF_CELL.split(raw[start : start + _LONGEST_CELL].decode("latin-1"), maxsplit=1)[:1]
        ):
            continue  # a reading that is missing, such as nan
        end = raw.find(b"\n", start) + 1 or len(raw)
        if blocks and len(_ROW.findall(raw, blocks[-1][1], min(start, blocks[-1][1] + _LONGEST))) < _FEWEST:
            blocks[-1] = (blocks[-1][0], end)
        else:
            blocks.append((start, end))
    blocks = [block for block in blocks if _has_headings(raw, *block)][:_MOST]
    spans = itertools.pairwise([0, *(start for start, _ in blocks[1:]), len(raw)])
    labels = [_LABEL.findall(raw[start:end][-_LONGEST_LABEL:].decode("latin-1")) for start, end in blocks]
    names = [f"{each[-1][0].lower()} {each[-1][1]}" if each else "" for each in labels]
    if len(set(names)) < len(names) or "" in names:
        names = [f"table {number}" for number in range(1, len(blocks) + 1)]
    return {name: raw[start:stop] for name, (start, stop) in zip(names, spans, strict=False)}


def _lines_of_words(raw: bytes) -> list[int]:
    """Return where lines begin that are no rows of numbers; none if words begin so many lines that they belong to the rows."""
    signs = np.frombuffer(raw, dtype=np.uint8)
    begins = np.concatenate([[0], np.flatnonzero(signs == _LINE_FEED) + 1])
    begins = begins[begins < signs.size]
    begins = begins[(_BEFORE_WORDS | _LETTERS)[signs[begins]]]
    place = begins.copy()
    for _ in range(_MOST_SIGNS):
        place += _BEFORE_WORDS[signs[place]] & (place < signs.size - 1)
    found = begins[_LETTERS[signs[place]]]
    return found.tolist() if found.size < _MOST_LINES else []


def _has_headings(raw: bytes, start: int, end: int) -> bool:
    """Return whether a block of lines of words ends with headings of the rows of numbers behind it."""
    rows = [line for line in raw[end : end + _LONGEST].split(b"\n", 9)[:9] if _ROW.match(line)][:_FEWEST]
    above = [line for line in raw[start:end].split(b"\n") if line.strip()][-_LOWEST:]
    sign = next((sign for sign in (b"\t", b";", b",") if rows and sign in rows[0]), None)
    below = [_fields(line, sign) for line in rows]
    width = len(below[0]) if below else 0
    if len(below) < _FEWEST or width < 2 or any(len(row) != width or not _has_number(row) for row in below):
        return False
    return any(len(row) >= width and not _has_number(row) for row in (_fields(line, sign) for line in above))


def _fields(line: bytes, sign: bytes | None) -> list[str]:
    """Return the fields of a line without empty ones at its end."""
    fields = [each.strip(b' "\r').decode("latin-1") for each in line.split(sign)]
    while fields and not fields[-1]:
        fields.pop()
    return fields


def _has_number(fields: Sequence[str]) -> bool:
    """Return whether one of the fields is a number, or stands for a reading that is missing."""
    notations = [Notation(decimal=sign) for sign in ".,"]
    return any(
        each and (notation.is_number(each) or notation.quantity(each) is not None)
        for each in fields
        for notation in notations
    )


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
