"""Text of any instrument: CSV and TSV with a preamble, a row of units, decimal commas, or a time step instead of a column."""

from __future__ import annotations

import dataclasses
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import CanRead, DataColumn, FileFormat, NotRead, Recorded, unique
from electrovib.data.text.body import Body, body_of, read_columns
from electrovib.data.text.hypotheses import find_layout
from electrovib.data.text.layout import BEGINNING, Layout, as_utf8, check_width, inspected
from electrovib.data.text.parts import one_segment, one_table, repeated_table
from electrovib.data.text.preamble import named_by_preamble, settings_of, with_clocks
from electrovib.data.text.stamps import stamp_columns, with_stamps
from electrovib.data.unit_words import Cells, Notation, numbers_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from electrovib.core.arrays import Real


_UNEVEN: Final = 2
_SETTINGS: Final = 0.1
"""Share of the rows below which the numbers of a further column are settings beside the first rows."""
_NO_TABLE_ABOVE: Final = 3
"""Most lines above the rows of numbers that cannot hold another table: headings and two rows, and headings again."""
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
    raw, about, others = one_table(path, as_utf8(path, path.read_bytes()), part)
    if about and delimiter is None:
        delimiter = "\t" if b"\t" in raw else ","
    found = read_laboratory_bytes(
        path,
        raw,
        delimiter=delimiter,
        decimal_comma=decimal_comma,
        part="" if about else part,
    )
    return dataclasses.replace(
        found, attributes={**found.attributes, **about}, not_read=(*found.not_read, *others)
    )


def read_laboratory_bytes(
    path: Path, raw: bytes, *, origin: str = "", part: str = "", **options: Any
) -> Recorded:
    """Read the text of an instrument that is in memory in UTF-8; `origin` names the sheet that it comes from."""
    about, others = dict[str, str](), tuple[NotRead, ...]()
    read = None
    with suppress(DataFileError):  # of a text with several tables, whose rows differ
        read = _rows(path, raw, **options)
    if part or read is None or not read[2].is_plain or read[0].first > _NO_TABLE_ABOVE:
        raw, about, others = repeated_table(path, raw, part)
        read = read if read and not about else _rows(path, raw, **options)
    layout, lines, body = read
    if len(body.table) < _UNEVEN:
        raise DataFileError("holds fewer than two rows of numbers.", path=path)
    stamped = stamp_columns(layout, lines)
    layout, numbers, not_read = _columns(path, layout, body, stamped)
    first = next(iter(numbers.values()))
    for place in set(body.table.columns) - {*numbers, *stamped} if (np.diff(first) == 0).any() else ():
        _refuse_turns(path, _called(layout, place), body.table[place])
    settings = settings_of(layout) | ({"sheet": origin} if origin else {}) | about
    found = _recorded(layout, numbers, settings)
    if stamped:
        one, *more = (body.table[at].fillna("").astype(str) for at in stamped)
        stamps = one.str.cat(more, sep=" ") if more else one
        found = with_stamps(found, stamps, " ".join(_heading(layout, at) for at in stamped))
    found = one_segment(path, found, "" if about else part)
    surplus = [NotRead(name=name, why="no row has a field below it") for name in layout.surplus]
    surplus += [
        NotRead(name=f"'{line}'", why="a row of statistics above the samples") for line in layout.statistics
    ]
    unread = (*found.not_read, *not_read, *surplus, *_left_out(layout), *body.left_out, *others)
    return dataclasses.replace(found, not_read=unread)


def _rows(path: Path, raw: bytes, **options: Any) -> tuple[Layout, list[str], Body]:
    """Return the layout of a text, lines from which it was found, and its rows."""
    layout, lines = _layout(path, raw, **options)
    return layout, lines, body_of(path, raw, layout)


def _layout(path: Path, raw: bytes, **options: Any) -> tuple[Layout, list[str]]:
    """Return the layout of a text, with lines of which one has its number up to the first row of numbers."""
    for many in (BEGINNING, _LONG_PREAMBLE):
        lines = inspected(raw, many)
        check_width(path, lines)
        layout = find_layout(lines, path=path, **options)
        if layout is not None and layout.first < many:
            return layout, lines
    raise DataFileError(
        "holds no rows of numbers; if it does, state delimiter and decimal_comma (--set delimiter=...).",
        path=path,
    )


def _left_out(layout: Layout) -> list[NotRead]:
    """Name the rows at the beginning that hold words in place of numbers."""
    rows = "the first row" if layout.left_out == 1 else f"the first {layout.left_out} rows"
    if not layout.left_out:
        return []
    name = f"{rows} behind the headings, from line {layout.first - layout.left_out + 1} on"
    said = next((cell for row in layout.faulty for cell in row if not layout.notation.is_number(cell)), "")
    return [NotRead(name=name, why=f"words in place of numbers, the first '{said[:40]}'")]


def _called(layout: Layout, place: int) -> str:
    return (layout.titles[place] if place < len(layout.titles) else "") or f"column {place}"


def _heading(layout: Layout, place: int) -> str:
    unit = layout.title_units[place] if place < len(layout.title_units) else ""
    return f"{_called(layout, place)} [{unit}]" if unit else _called(layout, place)


def _columns(
    path: Path, layout: Layout, body: Body, stamped: tuple[int, ...]
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
                f" {layout.stated}: decimals are written with both signs.",
                path=path,
            )
        if why:
            if why != "empty" or (place < len(layout.titles) and layout.titles[place]):
                not_read.append(NotRead(name=name, why=why))
            continue
        numbers[place] = cells.values
        units[place] = cells.unit
        if count := sum(cells.missing.values()):
            words = ", ".join(f"{many} {word}" for word, many in list(cells.missing.items())[:5])
            not_read.append(
                NotRead(name=f"{count} of {cells.values.size} samples of '{name}'", why=f"missing: {words}")
            )
    if doubted and (doubted_first or len(numbers) < _UNEVEN):
        sign = "point" if layout.decimal_comma else "comma"
        raise DataFileError(
            f"{doubted}; if another table begins there, write each into a file of its own; if decimals are written with a"
            f" {sign}, state it.",
            path=path,
        )
    if not numbers:
        raise DataFileError("holds no column of numbers.", path=path)
    layout = layout.with_columns(tuple(numbers))
    own = tuple(units[place] or unit for place, unit in zip(numbers, layout.units, strict=True))
    return dataclasses.replace(layout, units=own), numbers, not_read


def _refuse_turns(path: Path, name: str, words: Any) -> None:
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
            " of a row at one time.",
            path=path,
        )


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
