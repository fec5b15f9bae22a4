"""Text of any instrument: CSV and TSV with a preamble, decimal commas or a time step; one table of a file that holds several."""

from __future__ import annotations

import dataclasses
import itertools
import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import CanRead, DataColumn, FileFormat, NotRead, Recorded, one_part, unique
from electrovib.data.text.body import Body, body_of, cut_off, read_columns
from electrovib.data.text.hypotheses import find_layout
from electrovib.data.text.layout import BEGINNING, SCALING, Layout, as_utf8, check_width, inspected, split
from electrovib.data.text.preamble import named_by_preamble, segments_of, settings_of, with_clocks
from electrovib.data.text.stamps import stamp_columns, with_stamps
from electrovib.data.unit_words import Cells, Notation, as_unit, numbers_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from electrovib.core.arrays import Real


_UNEVEN: Final = 2
_SETTINGS: Final = 0.1
"""Share of the rows below which the numbers of a further column are settings beside the first rows."""
_MOST_IN_TURN: Final = 20
"""Most quantities of which a text has a row each in turn."""
_LONG_PREAMBLE: Final = 20_000
"""Lines of the beginning that are looked at where the first ones hold no numbers."""


def read_laboratory_text(
    path: Path,
    *,
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str = "",
) -> Recorded:
    """Read every column of numbers of a text file of an instrument, and the statements of its preamble.

    An empty `delimiter` stands for blanks. Of a file with several tables, as
    Gamry and VersaStudio write them, `part` names the table; by default it is the spectrum or the longest one.
    """
    raw = as_utf8(path.read_bytes())
    return read_laboratory_bytes(raw, delimiter=delimiter, decimal_comma=decimal_comma, part=part)


def read_laboratory_bytes(
    raw: bytes,
    *,
    origin: str = "",
    part: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
) -> Recorded:
    """Read the text of an instrument that is in memory in UTF-8; `origin` names the sheet that it comes from."""
    raw, about, others, sign = _one_table(raw, part)
    layout, lines = _layout(
        raw, delimiter=sign if delimiter is None else delimiter, decimal_comma=decimal_comma
    )
    body = body_of(raw, layout)
    _refuse_factors(layout)
    if len(body.table) < _UNEVEN:
        raise DataFileError("holds fewer than two rows of numbers.")
    stamped = stamp_columns(layout, lines)
    layout, numbers, not_read = _columns(layout, body, stamped)
    first = next(iter(numbers.values()))
    for place in set(body.table.columns) - {*numbers, *stamped} if (np.diff(first) == 0).any() else ():
        _refuse_turns(_called(layout, place), body.table[place])
    settings = settings_of(layout) | ({"sheet": origin} if origin else {})
    found = _recorded(layout, numbers, settings)
    if stamped:
        one, *more_stamps = (body.table[at].fillna("").astype(str) for at in stamped)
        stamps = one.str.cat(more_stamps, sep=" ") if more_stamps else one
        found = with_stamps(found, stamps, " ".join(_heading(layout, at) for at in stamped))
    found = _one_segment(found, "" if about else part)
    stated = {**about, **found.attributes}
    if not origin and (doubt := cut_off(raw, layout)):
        stated["unsure"] = "; ".join(filter(None, (stated.get("unsure"), doubt)))
    unread = (*found.not_read, *not_read, *layout.not_read, *body.left_out, *others)
    return dataclasses.replace(found, attributes=stated, not_read=unread)


def _layout(raw: bytes, **options: Any) -> tuple[Layout, list[str]]:
    """Return the layout of a text, with lines of which one has its number up to the first row of numbers."""
    for many in (BEGINNING, _LONG_PREAMBLE):
        lines = inspected(raw, many)
        check_width(lines)
        layout = find_layout(lines, refuse_doubt=True, **options)
        if layout is not None and layout.first < many:
            return layout, lines
    raise DataFileError(
        "holds no rows of numbers; if it does, state delimiter and decimal_comma (--set delimiter=...)."
    )


def _refuse_factors(layout: Layout) -> None:
    """Refuse rows of factors or zeros above the numbers: whether they are applied already, the file does not tell."""
    for line in layout.statistics:
        name, *cells = [cell for cell in split(line, layout.delimiter) if cell]
        factors = {layout.notation.number(cell) for cell in cells} - {0.0, 1.0}
        if factors and SCALING.fullmatch(name.rstrip(": ")):
            raise DataFileError(
                f"'{line.strip()[:60]}' stands above the numbers, and the file does not tell whether they are multiplied by it"
                " already; write the numbers in the units of the headings and remove this line."
            )


def _called(layout: Layout, place: int) -> str:
    return (layout.titles[place] if place < len(layout.titles) else "") or f"column {place}"


def _heading(layout: Layout, place: int) -> str:
    unit = layout.title_units[place] if place < len(layout.title_units) else ""
    return f"{_called(layout, place)} [{unit}]" if unit else _called(layout, place)


def _columns(
    layout: Layout, body: Body, stamped: tuple[int, ...]
) -> tuple[Layout, Mapping[int, Real], list[NotRead]]:
    """Return the layout with the columns that are numbers in all rows, their numbers, and what is not read."""
    numbers: dict[int, Real] = {}
    units: dict[int, str] = {}
    not_read: list[NotRead] = []
    doubted, doubted_first = "", False
    for place in body.table.columns:
        if place in stamped:
            continue
        cells = numbers_of(body.table[place], layout.notation)
        name = _called(layout, place)
        why = _why_not(layout, place, cells, body)
        if place in layout.columns and cells.rows.size and not doubted:
            doubted = f"line {body.line(int(cells.rows[0]))}: '{cells.word[:40]}' is not a number"
            doubted_first = place == layout.columns[0]
        if cells.rows.size and _other(layout.notation).is_number(cells.word):
            raise DataFileError(
                f"column '{name}' holds '{cells.word[:40]}' in line {body.line(int(cells.rows[0]))}, where others are read with"
                f" {layout.stated}: decimals are written with both signs."
            )
        if why:
            if why != "empty" or (place < len(layout.titles) and layout.titles[place]):
                not_read.append(NotRead(name=name, why=why))
            continue
        numbers[place] = cells.values
        units[place] = cells.unit
        if count := sum(cells.missing.values()):
            numbers[place] = np.where(np.isfinite(cells.values), cells.values, np.nan)
            words = ", ".join(f"{many} {word}" for word, many in list(cells.missing.items())[:5])
            not_read.append(
                NotRead(name=f"{count} of {cells.values.size} samples of '{name}'", why=f"missing: {words}")
            )
    if doubted and (doubted_first or len(numbers) < _UNEVEN):
        sign = "point" if layout.decimal_comma else "comma"
        raise DataFileError(
            f"{doubted}; if another table begins there, write each into a file of its own; if decimals are written with a"
            f" {sign}, state it."
        )
    if not numbers:
        raise DataFileError("holds no column of numbers.")
    layout = layout.with_columns(tuple(numbers))
    own = tuple(
        units[place] or unit or _unit_beside(layout, body, place + 1)
        for place, unit in zip(numbers, layout.units, strict=True)
    )
    return dataclasses.replace(layout, units=own), numbers, not_read


def _refuse_turns(name: str, words: Any) -> None:
    """Refuse rows that are of several quantities in turn, as a column of words tells."""
    kinds = [str(each) for each in dict.fromkeys(words[: 2 * _MOST_IN_TURN])]
    count, size = len(kinds), len(words)
    if (
        1 < count <= _MOST_IN_TURN
        and 3 * count <= size
        and (words.astype(str) == np.resize(kinds, size)).all()
    ):
        raise DataFileError(
            f"the rows are those of {', '.join(map(repr, kinds))} in turn, as column '{name}' tells; write a column for each, all"
            " of a row at one time."
        )


def _unit_beside(layout: Layout, body: Body, place: int) -> str:
    """Return the unit that a column called so states in all rows for the one before it, as Keithley writes readings."""
    is_one = place in body.table.columns and _called(layout, place).lower() in ("unit", "units", "einheit")
    words = body.table[place].unique() if is_one else []
    return (as_unit(str(words[0])) or "") if len(words) == 1 else ""


def _other(notation: Notation) -> Notation:
    """Return the notation with the other decimal sign, and the other one between thousands."""
    point = notation.decimal == ","
    return Notation(decimal="." if point else ",", thousands="," if point else ".")


def _why_not(layout: Layout, place: int, cells: Cells, body: Body) -> str:
    """Return why a column is not read; empty if it is one of numbers."""
    known, size = int(np.isfinite(cells.values).sum()), cells.values.size
    if cells.rows.size:
        where = f"the first '{cells.word[:40]}' in line {body.line(int(cells.rows[0]))}"
        return f"words in {cells.rows.size} of {size} rows, {where}"
    if not known and place not in layout.columns:
        return "empty"
    return (
        f"a number in {known} of {size} rows"
        if known < max(_UNEVEN, _SETTINGS * size) and place not in layout.columns
        else ""
    )


def _recorded(layout: Layout, numbers: Mapping[int, Real], settings: dict[str, str]) -> Recorded:
    layout = named_by_preamble(layout, settings)
    channels: list[DataColumn] = []
    for place, column in enumerate(layout.columns):
        name = unique(layout.names[place] or f"column {column}", channels)
        channels.append(DataColumn(name=name, unit=layout.units[place], values=numbers[column]))
    return with_clocks(layout, channels, settings)


_BEGIN: Final = re.compile(rb"^([A-Za-z_]\w{0,60})\tTABLE\b[^\n]*\n", re.MULTILINE)
_HEAD: Final = re.compile(rb"\s*EXPLAIN\b")
_SEGMENT: Final = re.compile(rb"^<(Segment\d{1,6})>\s*$", re.MULTILINE)
_SPECTRUM: Final = "ZCURVE"
_LABEL: Final = re.compile(
    r"(?i)(step|segment|cycle|sweep|block|run|test|measurement)\W{0,3}(?:no|nr|number)?\W{0,3}(\d{1,6})\b"
)
"""Line above a table that numbers it, such as ``Step No. 2``."""
_MOST: Final = 1000
_LONGEST: Final = 200_000
_MOST_LINES: Final = 20_000
"""Lines of words from which on a text has words in its rows, and is not divided."""
_LONGEST_LABEL: Final = 4000
_FEWEST: Final = 2
"""Fewest rows of a table."""
_LOWEST: Final = 4
"""Lines right above the numbers among which headings are looked for."""
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


def _one_table(raw: bytes, part: str) -> tuple[bytes, dict[str, str], tuple[NotRead, ...], str | None]:
    """Return one table of a text, what is stated of it, the others, and its delimiter where the format prescribes one.

    It is the one that was asked for, else that of a spectrum or the longest one; the whole text if it has no several.
    """
    tables, about = _of_gamry(raw) if _HEAD.match(raw) else _of_versastudio(raw)
    marked = bool(tables)
    tables = tables or _of_headings(raw)
    if not marked and len(tables) < 2:
        return raw, {}, (), None
    longest = max(tables, key=lambda name: len(tables[name]))
    rows = {name: len(_ROW.findall(table)) for name, table in tables.items()}
    chosen, others = one_part(rows, part, _SPECTRUM if _SPECTRUM in tables else longest)
    sign = ("\t" if b"\t" in tables[chosen] else ",") if marked else None
    return tables[chosen], about | {"table": chosen}, others, sign


def _one_segment(recorded: Recorded, part: str) -> Recorded:
    """Return one of the segments of a record whose times turn back to their beginning; by default the longest one."""
    times = recorded.times() if recorded.time else None
    found = segments_of(times) if times is not None else []
    if len(found) < 2:
        if part:
            raise DataFileError(f"part = {part}: the file does not consist of parts with names; omit it.")
        return recorded
    segments = {f"segment {number}": rows for number, rows in enumerate(found, 1)}
    sizes = {name: rows.stop - rows.start for name, rows in segments.items()}
    chosen, others = one_part(sizes, part, max(sizes, key=sizes.__getitem__))
    return dataclasses.replace(
        recorded,
        channels=tuple(
            dataclasses.replace(each, values=each.values[segments[chosen]].copy())
            for each in recorded.channels
        ),
        attributes={**recorded.attributes, "table": chosen},
        not_read=(*recorded.not_read, *others),
    )


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
    return any(each and notation.states(each) for each in fields for notation in notations)


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


def _can_read(head: bytes, suffix: str) -> CanRead:
    is_text = head.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" not in head
    return CanRead.PERHAPS if is_text or suffix in (".csv", ".tsv", ".txt") else CanRead.NO


FORMAT: Final = FileFormat(
    name="text",
    description="delimited text of any instrument (.csv, .tsv, .txt, .dat, .lvm, .dta, .mpt, .par)",
    can_read=_can_read,
    read=read_laboratory_text,
    columns=read_columns,
    options=("delimiter", "decimal_comma", "part"),
    is_last=True,
)
