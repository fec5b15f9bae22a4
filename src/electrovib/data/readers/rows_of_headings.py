"""Headings, units and settings above the numbers of a text."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Final

from electrovib.data.readers.number_cells import is_number
from electrovib.data.readers.unit_words import UNIT_NAMES, UNITS, as_unit, name_and_unit, unit_of_force

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.data.readers.layout import Layout

_COMMENT: Final = ("#", "%")
"""Signs that stand alone before headings."""
_SETTING: Final = re.compile(
    r"(horizontal|vertical|record|sample|probe|model|serial|firmware|software)[ _]", re.IGNORECASE
)
"""Beginning of the name of a setting of an oscilloscope, which is no heading."""
_WIDE_GAP: Final = re.compile(r"\s{2,}|\t")
_FIRST_CELLS: Final = re.compile(r"x|x-axis|time|source|t|", re.IGNORECASE)
"""First field of a row of headings whose other fields may be numbers, such as ``x-axis,1,2``."""


def with_headings(rows: Sequence[Sequence[str]], layout: Layout) -> Layout:
    """Return a layout with the headings, units and preamble of the lines above the numbers."""
    first, columns, comma = layout.first, layout.columns, layout.decimal_comma
    width = len(rows[first])
    rows = [
        row[1:] if at < first and row and row[0] in _COMMENT and len(row) > width else row
        for at, row in enumerate(rows)
    ]
    above = [at for at in range(first) if any(rows[at])]
    left_out = _faulty(rows, above, columns, comma)
    headings = _headings(rows, above[: len(above) - left_out], width, columns, comma)
    if not headings and left_out:
        left_out, headings = 0, _headings(rows, above, width, columns, comma)
    names, units = _named(rows, headings, columns)
    beside = [tuple(cell for at, cell in enumerate(row) if at not in columns) for row in rows[first:]]
    preamble = [tuple(rows[at]) for at in above[: len(above) - left_out]]
    return dataclasses.replace(
        layout,
        names=tuple(names),
        units=tuple(units),
        preamble=(*preamble, *(row for row in beside if any(row))),
        headings=headings[0] if headings else first,
        left_out=left_out,
    )


def _faulty(
    rows: Sequence[Sequence[str]], above: Sequence[int], columns: tuple[int, ...], comma: bool
) -> int:
    """Count the rows right above the first row of numbers that hold words in place of numbers.

    Such a row begins with a number and has other words than units, or the same word everywhere; a row of
    headings has neither.
    """
    count = 0
    for at in reversed(above):
        cells = [rows[at][place] for place in columns if place < len(rows[at])]
        words = [cell for cell in cells if cell and not is_number(cell, decimal_comma=comma)]
        begins = bool(cells) and bool(cells[0]) and cells[0] not in words
        if len(cells) < len(columns) or len(columns) < 2 or any(as_unit(word) is not None for word in words):
            break
        if not (begins and words) and not (len(words) == len(cells) and len(set(words)) == 1):
            break
        count += 1
    return count


def _headings(
    rows: list[Sequence[str]], above: Sequence[int], width: int, columns: tuple[int, ...], comma: bool
) -> list[int]:
    """Return the rows of headings and units, which are among the lowest of the lines above the numbers."""
    for at in above[-3:]:  # ZPlot writes all headings into one field
        parts = _WIDE_GAP.split(" ".join(rows[at]).strip()) if sum(map(bool, rows[at])) == 1 else []
        rows[at] = parts if len(parts) == width > 1 else rows[at]
    headings: list[int] = []
    lower: list[str] = []
    for at in reversed(above[-3:]):
        cells = [rows[at][place] if place < len(rows[at]) else "" for place in columns]
        words = [cell for cell in cells if cell and not is_number(cell, decimal_comma=comma)]
        if not headings and sum(map(bool, rows[at])) == 1 and len(columns) > 2:
            continue  # such as 'End Comments' between headings and numbers
        if headings and all(map(as_unit, lower)) and _FIRST_CELLS.fullmatch(cells[0]) and all(cells[1:]):
            headings.insert(0, at)  # such as 'x-axis,1,2' above 'second,Volt,Volt'
            break
        if len(words) < max(1, (len(columns) + 1) // 2) or _is_setting(rows[at], columns):
            break
        if headings and sum(as_unit(cell) is None for cell in lower if cell) > len(columns) // 4:
            break
        headings.insert(0, at)
        lower = [cell.strip("[]()") for cell in cells]
    return headings


def _named(
    rows: Sequence[Sequence[str]], headings: Sequence[int], columns: tuple[int, ...]
) -> tuple[list[str], list[str]]:
    names = [""] * len(columns)
    units = [""] * len(columns)
    for order, at in enumerate(headings):
        for place, column in enumerate(columns):
            cell = rows[at][column].lstrip("#").strip() if column < len(rows[at]) else ""
            name, unit = name_and_unit(cell)
            if order and names[place] and (own := as_unit(cell)) is not None:
                units[place] = own
            else:
                names[place] = names[place] or name
                units[place] = units[place] or unit
    for place, name in enumerate(names):
        if name.lower() in UNIT_NAMES and not units[place]:
            units[place] = UNITS[name.lower()]
            names[place] = "time" if units[place] == "s" else name
    return names, [unit_of_force(name, unit) for name, unit in zip(names, units, strict=True)]


def _is_setting(row: Sequence[str], columns: tuple[int, ...]) -> bool:
    """Return whether a line such as 'Model Number,SDS1104' is a setting: it has fewer fields than there are columns."""
    filled = [cell for cell in row if cell]
    if filled and (filled[0].endswith(("=", ":")) or _SETTING.match(filled[0])):
        return True
    if all(as_unit(cell.strip("[]()")) is not None for cell in filled):
        return False
    return 2 * len(filled) < len(columns) or (len(filled) == 2 and len(columns) > 2 and bool(row[0]))
