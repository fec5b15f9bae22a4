"""The rows of a text through `pandas.read_csv`, each with its line, and what is no row; columns of plain tables, strictly."""

from __future__ import annotations

import csv
import io
import itertools
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import DataColumn, NotRead, agreed_unit, called, choose
from electrovib.data.text.hypotheses import find_layout
from electrovib.data.text.layout import (
    RULE,
    STATISTICS,
    WIDE,
    WORD_WITH_UNIT,
    Layout,
    as_utf8,
    check_width,
    end_of,
    is_comment,
    lines_of,
    place_of,
    split,
)
from electrovib.data.unit_words import Notation, name_and_known_unit, numbers_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

_MOST_BEHIND: Final = 1000
"""Lines at the end of a text among which rows that are no samples are looked for."""
_SHOWN: Final = 40
_FEWEST_ALIKE: Final = 8
"""Fewest numbers of one form beside which a shorter one at the very end of a text is one that is cut off."""


@dataclass(frozen=True, kw_only=True)
class Body:
    """The rows of a text: a table of pandas with numbered columns, the line of a row from 1, and what is left out."""

    table: Any
    line: Callable[[int], int]
    left_out: tuple[NotRead, ...] = ()


def table_of(
    raw: bytes, start: int, *, delimiter: str, width: int, decimal: str = ".", **options: Any
) -> Any:
    """Read rows of text from a place on with pandas, whose numbers are the nearest floats."""
    import pandas as pd

    exact = (
        {"float_precision": "round_trip"} if tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1) else {}
    )
    content = io.BytesIO(raw)
    content.seek(start)
    with warnings.catch_warnings():
        warnings.simplefilter("error", pd.errors.ParserWarning)  # more fields than there are columns
        warnings.simplefilter("ignore", pd.errors.DtypeWarning)  # words among numbers are looked at later
        return pd.read_csv(
            content,
            header=None,
            index_col=False,
            names=range(width),
            sep=delimiter or r"\s+",
            decimal=decimal,
            encoding_errors="replace",
            **exact,
            **options,
        )


def body_of(raw: bytes, layout: Layout, *, exactly: str = "") -> Body:
    """Read the rows behind the headings; rows of statistics and words at the end are left out, and cut off rows refused.

    Of a plain table `exactly` says what has as many fields as every row has to have, and nothing is left out.
    """
    import pandas as pd

    start = place_of(raw, layout.first)
    end, behind = _behind(raw, start, layout) if not exactly else (len(raw), ())
    rows = raw if end == len(raw) else raw[:end]
    decimal = layout.notation.decimal
    try:
        sign = rows.find(b"#", start)
        simple = sign < 0 or not re.search(rb"^[ \t]*#", memoryview(rows)[sign - 1 :], re.MULTILINE)
        table = None
        if simple and layout.delimiter != WIDE:
            table = table_of(
                rows,
                start,
                delimiter=layout.delimiter,
                width=layout.width,
                decimal=decimal,
                skipinitialspace=rows.find(b'"', start) >= 0,  # which takes a quarter longer
            )
    except (pd.errors.ParserError, pd.errors.ParserWarning, pd.errors.EmptyDataError):
        table = None
    if table is not None and _is_even(rows, start, layout, table, exactly=bool(exactly)):

        def line(row: int) -> int:
            numbered = enumerate(lines_of(rows, start), layout.first + 1)
            filled = (number for number, text in numbered if text.strip())
            return next(itertools.islice(filled, row, None))

        return Body(table=table, line=line, left_out=behind)
    return _uneven(rows, start, layout, behind, exactly)


def _is_even(raw: bytes, start: int, layout: Layout, table: Any, *, exactly: bool) -> bool:
    """Return whether all rows have the same number of fields; pandas fills short ones without a word."""
    if not exactly and not table[layout.width - 1].isna().any():
        return True
    if layout.delimiter:
        return raw.count(layout.delimiter.encode(), start) == len(table) * (layout.width - 1)
    return False


def _uneven(raw: bytes, start: int, layout: Layout, behind: tuple[NotRead, ...], exactly: str) -> Body:
    """Read rows with different numbers of fields: lines of words are left out, rows that are cut off refused."""
    import pandas as pd

    rows: list[list[str]] = []
    numbers: list[int] = []
    words: list[tuple[int, str]] = []
    for number, line in enumerate(lines_of(raw, start), layout.first + 1):
        if not line.strip() or is_comment(line):
            continue
        cells = split(line, layout.delimiter)
        if exactly and len(cells) != layout.width:
            raise DataFileError(f"line {number} has {len(cells)} fields, but {exactly} {layout.width}.")
        if len(cells) <= layout.columns[-1]:
            if not any(layout.notation.is_number(cell) for cell in cells):
                words.append((number, line))
                continue
            raise DataFileError(
                f"line {number} has {len(cells)} fields, fewer than the {layout.width} of the other rows: it is cut off,"
                " or the delimiter is another one; state it."
            )
        rows.append([cell.replace("\t", " ") for cell in cells])
        numbers.append(number)
    width = max([layout.width, *map(len, rows)])
    if not rows:
        return Body(table=pd.DataFrame(columns=range(width), dtype=float), line=numbers.__getitem__)
    text = "\n".join("\t".join(row + [""] * (width - len(row))) + "\t." for row in rows)
    table = table_of(
        text.encode(),
        0,
        delimiter="\t",
        width=width + 1,
        decimal=layout.notation.decimal,
        quoting=csv.QUOTE_NONE,
    )
    return Body(
        table=table.drop(columns=width),
        line=numbers.__getitem__,
        left_out=(*_named(words, "words between the rows of numbers"), *behind),
    )


def _behind(raw: bytes, start: int, layout: Layout) -> tuple[int, tuple[NotRead, ...]]:
    """Return where the rows of numbers end, and what stands behind them: words, or rows of statistics."""
    begin = max(start, end_of(raw, _MOST_BEHIND))
    lines = list(lines_of(raw, begin))
    usual = {cell for line in lines[: len(lines) // 2] for cell in split(line, layout.delimiter)}
    kept = len(lines)
    while kept and not _is_sample(lines[kept - 1], layout, usual):
        kept -= 1
    words = [(at, line) for at, line in enumerate(lines[kept:], kept) if line.strip()]
    if not words or not kept:
        return len(raw), ()
    before = raw.count(b"\n", 0, begin) + 1
    return place_of(raw, kept, begin), _named(
        [(before + at, line) for at, line in words], "no samples: words, or statistics of them"
    )


def _is_sample(line: str, layout: Layout, usual: set[str]) -> bool:
    """Return whether a line is a row of numbers, or one that is cut off."""
    if not line.strip() or is_comment(line) or (RULE.fullmatch(line) and line.strip() not in usual):
        return False
    cells = split(line, layout.delimiter)
    if any(STATISTICS.fullmatch(cell) and cell not in usual for cell in cells):
        return False
    numbers = [cells[at] for at in layout.columns if at < len(cells) and cells[at]]
    notation = layout.notation
    are = [notation.states(cell) for cell in numbers]
    return all(are) and (any(are) or len(cells) >= layout.width)


def cut_off(raw: bytes, layout: Layout) -> str:
    """Say that the last number may be cut off: no line ends behind it, and all above are written in one longer form."""
    if raw.endswith(b"\n"):
        return ""
    begin = max(place_of(raw, layout.first), end_of(raw, _MOST_BEHIND))
    rows = [split(line, layout.delimiter) for line in lines_of(raw, begin) if line.strip()]
    place, decimal = layout.columns[-1], layout.notation.decimal
    *above, last = ([row[place] for row in rows if len(row) == place + 1]) or [""]
    forms = {_form(cell, decimal) for cell in above}
    is_fixed = any(
        decimal in cell and cell.lower().partition("e")[0].endswith("0") for cell in above
    )  # else zeros are left out
    if len(above) < _FEWEST_ALIKE or len(forms) > 1 or not is_fixed or len(rows[-1]) != place + 1:
        return ""
    decimals, exponent = forms.pop()
    own = _form(last, decimal)
    if own[0] >= decimals and own[1] >= exponent:
        return ""
    return (
        f"the last number '{last}': it is shorter than the {len(above)} above, and no line ends behind it: the file may be cut"
        " off there"
    )


def _form(cell: str, decimal: str) -> tuple[int, int]:
    """Return the number of decimals of a number, and of the signs of its exponent."""
    mantissa, _, exponent = cell.lower().partition("e")
    return len(mantissa.partition(decimal)[2]), len(exponent)


def _named(words: list[tuple[int, str]], why: str) -> tuple[NotRead, ...]:
    if not words:
        return ()
    (first, text), (last, _) = words[0], words[-1]
    name = f"line {first}" if len(words) == 1 else f"{len(words)} lines, {first} to {last}"
    return (NotRead(name=name, why=f"{why}, the first '{text.strip()[:_SHOWN]}'"),)


_LONGEST_ROW: Final = 1_000_000
_INSPECTED: Final = 12
"""Rows of a plain table from which its layout follows."""
_WITH_COMMA: Final = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_NAN: Final = re.compile(r"[+-]?(nan|inf(inity)?)", re.IGNORECASE)
_POINT: Final = Notation()
"""How a plain table writes numbers."""


def read_columns(path: Path, columns: Sequence[str | int], missing: bool) -> dict[str | int, DataColumn]:
    """Read columns of a plain table: rows of one length below headings and units alone, and nothing but numbers in them."""
    raw = as_utf8(path.read_bytes())
    layout = _plain_layout(raw, [column for column in columns if isinstance(column, str)])
    headings = layout.titles
    named = [name_and_known_unit(heading) for heading in headings]
    named = named or [(f"column {at}", "") for at in range(layout.width)]
    names = [name for name, _ in named]
    places = [choose(names, column, range(layout.width), headings) for column in columns]
    body = body_of(raw, layout, exactly="the headings have" if headings else "the first row has")
    line = body.line  # alone, because the table is larger
    found: dict[str | int, DataColumn] = {}
    for column, (place, asked) in zip(columns, places, strict=True):
        name = headings[place] if headings else names[place]
        cells = numbers_of(body.table[place], layout.notation)
        bad = cells.rows if cells.rows.size or missing else np.flatnonzero(np.isnan(cells.values))
        if bad.size:
            _refuse_word(raw, layout, line(int(bad[0])), place, name)
        own = cells.unit or named[place][1] or "".join(layout.title_units[place : place + 1])
        found[column] = DataColumn(
            name=name,
            unit=agreed_unit(name, own, asked),
            values=cells.values,
            place=lambda row: f"line {line(row)}",
        )
    return found


def _refuse_word(raw: bytes, layout: Layout, number: int, place: int, name: str) -> None:
    """Refuse a field of a plain table that states no number; what is not finite is refused with the column."""
    cell = split(next(lines_of(raw, place_of(raw, number - 1))), layout.delimiter)[place]
    if not _NAN.fullmatch(cell):
        hint = "; write decimals with a point" if _WITH_COMMA.fullmatch(cell) else ""
        why = f"'{cell[:40]}' is not a number{hint}" if cell else "the number is missing"
        raise DataFileError(f"line {number}, {called(name)}: {why}.")


def _plain_layout(raw: bytes, names: Sequence[str]) -> Layout:
    """Return the layout of a plain table; there are no headings if the first row has numbers that are none of the `names`."""
    rows = ((at, row) for at, row in enumerate(lines_of(raw)) if row.strip() and not is_comment(row))
    inspected = dict(itertools.islice(rows, _INSPECTED))
    places, first = list(inspected), list(inspected.values())
    if not first:
        raise DataFileError("holds no rows, only comments or blank lines.")
    for at, row in inspected.items():
        if len(row) > _LONGEST_ROW:
            raise DataFileError(f"line {at + 1} has {len(row)} characters; a table has a row per sample.")
    check_width(first)
    delimiter = _delimiter(first)
    second = split(first[1], delimiter) if len(first) > 1 else []
    top = split(first[0], delimiter)
    if not delimiter:
        words = [first[0].strip()] if len(second) == 1 else WORD_WITH_UNIT.findall(first[0])
        top = [word.strip('"') for word in words]
    units = list[str]()
    are_headings = not any(
        itertools.starmap(_is_number, itertools.zip_longest(top, second[: len(top)], fillvalue=""))
    ) or not {name for cell in top for name in (cell, name_and_known_unit(cell)[0])}.isdisjoint(names)
    if are_headings:
        while not top[-1] and len(top) > max(1, len(second)):
            top = top[:-1]  # a delimiter after the last heading
        if any(second) and all(not cell or re.fullmatch(r"[\[(].*[\])]", cell) for cell in second):
            units = [cell[1:-1].strip() for cell in second]
    else:
        _refuse_mixture(top, second)
        top = split(first[0], delimiter)
    begin = are_headings + bool(units)
    return Layout(
        delimiter=delimiter,
        decimal_comma=False,
        first=places[begin] if begin < len(first) else raw.count(b"\n") + 1,
        width=len(top),
        columns=tuple(range(len(top))),
        titles=tuple(top) if are_headings else (),
        title_units=tuple(units),
    )


def _delimiter(lines: Sequence[str]) -> str:
    """Return the delimiter under which most rows hold numbers, or which headings without numbers contain; empty for blanks."""
    layout = find_layout(lines, decimal_comma=False)
    if layout is not None:  # of one column any is found
        return layout.delimiter if any(layout.delimiter in line for line in lines) else ""
    return next((sign for sign in "\t;," if sign in lines[0]), "")


def _refuse_mixture(top: Sequence[str], second: Sequence[str]) -> None:
    """Refuse a first row that holds words above numbers, and numbers."""
    for above, below in zip(top, second, strict=False):
        if above and not _is_number(above) and _is_number(below):
            raise DataFileError(
                f"the first row has '{above[:40]}' above a number and is neither headings nor data; mend it or begin it"
                " with '#'."
            )


def _is_number(cell: str, below: str = "") -> bool:
    """Return whether a field states a number, or one with its unit as the field below it does; one in brackets may be a name."""
    number = _POINT.number(cell)
    if _NAN.fullmatch(cell) or (number is not None and not np.isnan(number) and not cell.startswith("(")):
        return True
    return bool(below) and _POINT.quantity(cell) is not None and _POINT.quantity(below) is not None
