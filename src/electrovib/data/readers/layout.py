"""Layout of a text file: its delimiter, decimal sign, preamble, headings and units, and the place of its numbers."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

DELIMITERS: Final = ("\t", ";", ",", "|", "")
"""Candidates; the empty text stands for blanks."""
_ALIKE: Final = 0.75
"""Smallest share of rows of numbers among the lines after the first such row; other lines are then errors."""
INSPECTED: Final = 400
"""Lines of the beginning of a file from which the layout is found."""
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
_DECIMAL_COMMA: Final = re.compile(r"[+-]?(\d+,\d*|,\d+|\d+)([eEdD][+-]?\d+)?")
_LONGEST_NUMBER: Final = 64
"""Most characters of a number; the bound keeps the matching fast."""
_COMMENT: Final = ("#", "%")
"""Signs that stand alone before headings."""
_LONGEST_HEADING: Final = 200
_NOT_A_NUMBER: Final = frozenset({"nan", "inf", "-inf", "+inf", "****", "--"})
_BRACKETS: Final = re.compile(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*")
UNITS: Final = {
    "volt": "V", "volts": "V", "v": "V", "mv": "mV", "uv": "uV", "kv": "kV", "ampere": "A", "amperes": "A",
    "amp": "A", "amps": "A", "a": "A", "ma": "mA", "ua": "uA", "second": "s", "seconds": "s", "sec": "s", "s": "s",
    "ms": "ms", "us": "us", "µs": "us", "ns": "ns", "hertz": "Hz", "hz": "Hz", "khz": "kHz", "mhz": "MHz",
    "newton": "N", "newtons": "N", "n": "N", "mn": "mN", "ohm": "ohm", "ohms": "ohm", "ω": "ohm", "Ω": "ohm",
    "degree": "deg", "degrees": "deg", "deg": "deg", "°": "deg", "rad": "rad", "radians": "rad", "f": "F",
    "s/m": "S/m", "m": "m", "mm": "mm", "um": "um", "µm": "um", "m/s": "m/s", "mm/s": "mm/s", "pa": "Pa", "w": "W",
    "db": "dB", "%": "%", "unknown": "", "-": "1", "#": "",
}  # fmt: skip
"""Maps words and signs that instruments write for units, in small letters, to the units of electrovib."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Layout of a text file.

    Parameters
    ----------
    delimiter : str
        One character; empty for blanks.
    decimal_comma : bool
        Whether decimals are written with a comma.
    first : int
        Line of the first row of numbers, 0 first.
    width : int
        Fields of a row of numbers.
    columns : tuple of int
        Fields that hold numbers, 0 first.
    names, units : tuple of str
        Of these columns, empty where the file states none.
    preamble : tuple of tuple of str
        Fields of the lines before the numbers, and the fields beside the numbers that hold text.
    """

    delimiter: str
    decimal_comma: bool
    first: int
    width: int
    columns: tuple[int, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    preamble: tuple[tuple[str, ...], ...]


def is_number(cell: str, *, decimal_comma: bool) -> bool:
    """Return whether a field is a number."""
    if len(cell) > _LONGEST_NUMBER:
        return False
    form = _DECIMAL_COMMA if decimal_comma else _NUMBER
    return bool(form.fullmatch(cell)) or cell.lower() in _NOT_A_NUMBER


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
    """Find the layout of a text file from its beginning.

    Parameters
    ----------
    lines : sequence of str
        The first lines of the file, without line ends.
    delimiter : str, optional
        One character, or empty for blanks; found if not given.
    decimal_comma : bool, optional
        Whether decimals are written with a comma; found if not given.

    Returns
    -------
    Layout or None
        Layout under which most lines are rows of numbers; None if no line is one.

    Notes
    -----
    All rows of numbers hold numbers in the same columns, which are those of the last lines that were inspected. The lines
    before the first such row, and the text in other columns, are the preamble.
    """
    best: tuple[float, Layout] | None = None
    for separator in DELIMITERS if delimiter is None else (delimiter,):
        for comma in (False, True) if decimal_comma is None else (decimal_comma,):
            if comma and separator == ",":
                continue
            found = _under(lines, separator, comma)
            if found is not None and (best is None or found[0] > best[0]):
                best = found
    return best[1] if best else None


def _under(lines: Sequence[str], delimiter: str, comma: bool) -> tuple[float, Layout] | None:
    """Return the layout with this delimiter and decimal sign, and a score of its fit."""
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
    first = alike[0]
    for place, at in enumerate(alike):
        behind = len(filled) - filled.index(at)
        if len(alike) - place >= _ALIKE * behind:
            first = at
            break
    kept = sum(at >= first for at in alike)
    wholes = sum(sum(bool(cell) for cell in rows[at]) for at in body)
    share = len(columns) * len(body) / max(wholes, 1)
    split_decimals = 0.5 if _splits_decimals(rows, body, delimiter) else 1.0
    if comma and len(columns) == 1:
        split_decimals = 0.5  # '1,2' is rather two columns than one
    width = Counter(len(rows[at]) for at in body).most_common(1)[0][0]
    names, units, preamble = _above(rows, first, tuple(sorted(columns)), comma)
    layout = Layout(
        delimiter=delimiter,
        decimal_comma=comma,
        first=first,
        width=width,
        columns=tuple(sorted(columns)),
        names=names,
        units=units,
        preamble=preamble,
    )
    return kept * share * split_decimals * (count / len(body)), layout


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


def _splits_decimals(rows: Sequence[Sequence[str]], body: Sequence[int], delimiter: str) -> bool:
    """Return whether a comma taken for a delimiter is rather a decimal sign: '1,5 2,5' or '1,5;2,5'."""
    if delimiter != ",":
        return False
    return any(";" in cell or "\t" in cell for at in body for cell in rows[at])


def _above(
    rows: Sequence[Sequence[str]], first: int, columns: tuple[int, ...], comma: bool
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Read headings, units and preamble from the lines above the numbers."""
    rows = [row[1:] if at < first and row and row[0] in _COMMENT else row for at, row in enumerate(rows)]
    above = [at for at in range(first) if any(rows[at])]
    headings: list[int] = []
    lower: list[str] = []
    for at in reversed(above[-3:]):
        cells = [rows[at][place] if place < len(rows[at]) else "" for place in columns]
        words = [cell for cell in cells if cell and not is_number(cell, decimal_comma=comma)]
        if not headings and sum(map(bool, rows[at])) == 1 and len(columns) > 2:
            continue  # such as 'End Comments' between headings and numbers
        if len(words) < max(1, (len(columns) + 1) // 2) or _is_setting(rows[at], columns):
            break
        if headings and sum(_as_unit(cell) is None for cell in lower if cell) > len(columns) // 4:
            break
        headings.insert(0, at)
        lower = [cell.strip("[]()") for cell in cells]
    names = [""] * len(columns)
    units = [""] * len(columns)
    for order, at in enumerate(headings):
        for place, column in enumerate(columns):
            cell = rows[at][column].lstrip("#").strip() if column < len(rows[at]) else ""
            name, unit = name_and_unit(cell)
            if order and names[place] and not unit and _as_unit(cell) is not None:
                units[place] = _as_unit(cell) or ""
            else:
                names[place] = names[place] or name
                units[place] = units[place] or unit
    beside = [tuple(cell for at, cell in enumerate(row) if at not in columns) for row in rows[first:]]
    preamble = [tuple(rows[at]) for at in above]
    return tuple(names), tuple(units), (*preamble, *(row for row in beside if any(row)))


def _is_setting(row: Sequence[str], columns: tuple[int, ...]) -> bool:
    """Return whether a line such as 'Model Number,SDS1104' is a setting: it has fewer fields than there are columns."""
    filled = [cell for cell in row if cell]
    if all(_as_unit(cell.strip("[]()")) is not None for cell in filled):
        return False
    return 2 * len(filled) < len(columns) or (len(filled) == 2 and len(columns) > 2 and bool(row[0]))


def name_and_unit(heading: str) -> tuple[str, str]:
    """Split ``Time (s)``, ``CH1 [mV]`` or ``Volt``, ``in s``.

    Parameters
    ----------
    heading : str
        As written.

    Returns
    -------
    name : str
        Without the unit.
    unit : str
        Of electrovib where it is known, else as written; empty if there is none.
    """
    heading = heading[:_LONGEST_HEADING]
    if found := _BRACKETS.fullmatch(heading):
        name, unit = found.groups()
        known = _as_unit(unit)
        return name or heading, unit if known is None else known
    if heading.startswith("in ") and _as_unit(heading[3:]):  # as Rohde & Schwarz write the time
        return "time", _as_unit(heading[3:]) or ""
    for sign in (" in ", "/"):
        name, _, last = heading.rpartition(sign)
        if name and _as_unit(last):
            return name, _as_unit(last) or ""
    return heading, ""


def _as_unit(text: str) -> str | None:
    """Return the unit that a word stands for; None if it is no unit."""
    return UNITS.get(text.strip().lower(), UNITS.get(text.strip()))
