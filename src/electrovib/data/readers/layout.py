"""Layout of a text file: its delimiter, decimal sign, preamble, headings and units, and the place of its numbers."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from electrovib.data.readers.number_cells import is_number
from electrovib.data.readers.rows_of_headings import with_headings

DELIMITERS: Final = ("\t", ";", ",", "|", "")
"""Candidates; the empty text stands for blanks."""
_ALIKE: Final = 0.75
"""Smallest share of rows of numbers among the lines after the first such row; other lines are then errors."""
_SHORTEST: Final = 0.1
"""Smallest share of the rows in which a column of a shorter record holds numbers."""
INSPECTED: Final = 400
"""Lines of the beginning of a file from which the layout is found."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Layout of a text file; lines and fields count from 0.

    - `delimiter`: one character; empty for blanks.
    - `first`, `width`: line of the first row of numbers, and fields of such a row.
    - `columns`: fields that hold numbers; `names` and `units` are theirs, empty where the file states none.
    - `preamble`: fields of the lines before the numbers, and the fields beside the numbers that hold text.
    - `headings`: line of the first row of headings; that of the first row of numbers if there is none.
    - `left_out`: number of rows right above `first` that hold words in place of numbers.
    """

    delimiter: str
    decimal_comma: bool
    first: int
    width: int
    columns: tuple[int, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    preamble: tuple[tuple[str, ...], ...]
    headings: int = 0
    left_out: int = 0


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into its fields, without blanks and quotation marks around them."""
    if not delimiter:
        return line.split()
    if '"' in line:
        try:
            return [
                cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
            ]
        except (csv.Error, StopIteration):
            pass
    return [cell.strip() for cell in line.split(delimiter)]


def find_layout(
    lines: Sequence[str], *, delimiter: str | None = None, decimal_comma: bool | None = None
) -> Layout | None:
    """Find the layout under which most lines of the beginning of a text are rows of numbers; None if no line is one.

    All rows of numbers hold numbers in the same columns, which are those of the last lines. The lines before
    the first such row, and the text in other columns, are the preamble.
    """
    best: tuple[tuple[float, int], Layout] | None = None
    for separator in DELIMITERS if delimiter is None else (delimiter,):
        for comma in (False, True) if decimal_comma is None else (decimal_comma,):
            if comma and separator == ",":
                continue
            found = _under(lines, separator, comma)
            if found is not None and (best is None or found[0] > best[0]):
                best = found
    return best[1] if best else None


def _under(lines: Sequence[str], delimiter: str, comma: bool) -> tuple[tuple[float, int], Layout] | None:
    """Return the layout with this delimiter and decimal sign, and a score of its fit to the numbers and to the preamble."""
    rows = [split(line, delimiter) for line in lines]
    numeric = [
        frozenset(at for at, cell in enumerate(row) if cell and is_number(cell, decimal_comma=comma))
        for row in rows
    ]
    filled = [at for at, row in enumerate(rows) if any(row) and not rows[at][0].startswith("#")]
    if not filled:
        return None
    body = filled[len(filled) // 2 :] if len(filled) > 3 else filled[-1:]
    columns, count = Counter(numeric[at] for at in body).most_common(1)[0]
    if not columns:
        return None
    alike = [at for at in filled if _is_alike(rows[at], columns, comma=comma)]
    if not alike:
        return None
    first = _first(rows, filled, alike, columns, comma=comma)
    kept = sum(at >= first for at in alike)
    wholes = sum(sum(bool(cell) for cell in rows[at]) for at in body)
    share = len(columns) * len(body) / max(wholes, 1)
    split_decimals = 0.5 if _splits_decimals(rows, body, delimiter) else 1.0
    if comma and len(columns) == 1:
        split_decimals = 0.5  # '1,2' is rather two columns than one
    width = Counter(len(rows[at]) for at in body).most_common(1)[0][0]
    columns |= _shorter(rows, alike, width, columns, comma=comma)
    layout = with_headings(
        rows,
        Layout(
            delimiter=delimiter,
            decimal_comma=comma,
            first=first,
            width=width,
            columns=tuple(sorted(columns)),
            names=(),
            units=(),
            preamble=(),
        ),
    )
    settings = sum(bool(delimiter) and len(row) > 1 for row in layout.preamble)
    return (round(kept * share * split_decimals * (count / len(body)), 9), settings), layout


def _first(
    rows: Sequence[Sequence[str]],
    filled: Sequence[int],
    alike: Sequence[int],
    columns: frozenset[int],
    *,
    comma: bool,
) -> int:
    """Return the line of the first row of numbers: most of the lines behind it are such rows."""
    first = alike[0]
    for place, at in enumerate(alike):
        behind = len(filled) - filled.index(at)
        if len(alike) - place >= _ALIKE * behind:
            first = at
            break

    def words(at: int, places: Sequence[int]) -> list[bool]:
        cells = [rows[at][place] for place in places if place < len(rows[at])]
        return [bool(cell) and not is_number(cell, decimal_comma=comma) for cell in cells]

    others = [place for place in range(max(columns)) if place not in columns]
    clean = [
        place
        for place in others
        if not any(words(at, [place])[:1] == [True] for at in alike[-len(alike) // 2 :])
    ]
    for at in filled:  # settings with one number each look like rows; a row of headings ends them
        heading = words(at, sorted(columns))
        if at <= first or len(heading) < len(columns) or not all(heading):
            continue
        before = [place for place in alike if first <= place < at]
        after = [place for place in alike if place > at]
        if after and all(any(words(place, clean)) for place in before):
            first = after[0]
    return first


def _shorter(
    rows: Sequence[Sequence[str]], alike: Sequence[int], width: int, columns: frozenset[int], *, comma: bool
) -> frozenset[int]:
    """Return the further columns of numbers that begin later or end earlier than the others, as two records in one sheet do."""
    found = []
    for place in set(range(width)) - columns:
        cells = [rows[at][place] if place < len(rows[at]) else None for at in alike]
        filled = [at for at, cell in enumerate(cells) if cell]
        if None in cells or len(filled) < max(2, _SHORTEST * len(cells)):
            continue
        together = filled[-1] - filled[0] + 1 == len(filled) and (
            filled[0] == 0 or filled[-1] == len(cells) - 1
        )
        if together and all(is_number(cells[at] or "", decimal_comma=comma) for at in filled):
            found.append(place)
    return frozenset(found)


def _is_alike(row: Sequence[str], columns: frozenset[int], *, comma: bool) -> bool:
    """Return whether a line is a row of numbers in these columns, of which some may be missing."""
    cells = [row[at] for at in sorted(columns) if at < len(row)]
    numbers = [is_number(cell, decimal_comma=comma) for cell in cells]
    missing = [not cell for cell in cells]
    return (
        any(numbers)
        and len(cells) == len(columns)
        and all(a or b for a, b in zip(numbers, missing, strict=True))
    )


def is_row_of_numbers(line: str, layout: Layout) -> bool:
    """Return whether a line of the text is a row of numbers, of which some may be missing."""
    return _is_alike(split(line, layout.delimiter), frozenset(layout.columns), comma=layout.decimal_comma)


def _splits_decimals(rows: Sequence[Sequence[str]], body: Sequence[int], delimiter: str) -> bool:
    """Return whether a comma taken for a delimiter is rather a decimal sign: '1,5 2,5' or '1,5;2,5'."""
    if delimiter != ",":
        return False
    return any(";" in cell or "\t" in cell for at in body for cell in rows[at])
