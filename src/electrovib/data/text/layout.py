"""Layout of a text file: its delimiter, decimal sign, preamble, headings and units, and the place of its numbers."""

from __future__ import annotations

import csv
import dataclasses
import io
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import MOST_COLUMNS
from electrovib.data.unit_words import UNIT_NAMES, UNITS, as_unit, name_and_unit, unit_of_force

DELIMITERS: Final = ("\t", ";", ",", "|", "")
"""Candidates; the empty text stands for blanks."""
_ALIKE: Final = 0.75
"""Smallest share of rows of numbers among the lines after the first such row; other lines are then errors."""
_SHORTEST: Final = 0.1
"""Smallest share of the rows in which a column of a shorter record holds numbers."""
_NO_TEXT: Final = 4096
"""First bytes among which a zero byte shows that a file is no text."""
INSPECTED: Final = 400
"""Lines of the beginning of a file from which the layout is found."""
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?", re.ASCII)
_DECIMAL_COMMA: Final = re.compile(r"[+-]?(\d+,\d*|,\d+|\d+)([eEdD][+-]?\d+)?", re.ASCII)
_LONGEST_NUMBER: Final = 64
"""Most characters of a number; the bound keeps the matching fast."""
MISSING: Final = frozenset({
    "", "****", "--", "---", "nan", "-nan", "n/a", "#n/a", "na", "null", "inf", "-inf", "+inf", "∞", "-∞", "+∞", "ol", "-ol",
    "1.#qnan", "-1.#ind", "1.#inf", "-1.#inf", "9.91e37", "clipping", "overflow", "overload", "ovld", "-ovld", "+ovld", "ovfl",
    "ovrflw", "overrange", "underrange", "o.l", "o.l.", "#value!", "#div/0!", "#num!", "#ref!",
})  # fmt: skip
"""Fields, in small letters, that state no number: empty, out of the range of the instrument, or no reading."""
_COMMENT: Final = ("#", "%")
"""Signs that stand alone before headings."""
_SETTING: Final = re.compile(
    r"(horizontal|vertical|record|sample|probe|model|serial|firmware|software)[ _]", re.IGNORECASE
)
"""Beginning of the name of a setting of an oscilloscope, which is no heading."""
_WIDE_GAP: Final = re.compile(r"\s{2,}|\t")
_FIRST_CELLS: Final = re.compile(r"x|x-axis|time|source|t|", re.IGNORECASE)
"""First field of a row of headings whose other fields may be numbers, such as ``x-axis,1,2``."""


def encoding_of(path: Path, raw: bytes) -> str:
    """Return the encoding of a text; bytes that are none are refused."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if b"\0" in raw[:_NO_TEXT]:
        raise DataFileError("is not a text file; it holds zero bytes.", path=path)
    try:
        raw.decode("utf-8-sig")
    except UnicodeDecodeError:  # instruments write the micro sign in Latin-1
        return "latin-1"
    return "utf-8-sig"


def check_width(path: Path, lines: Sequence[str]) -> None:
    """Refuse a text with more columns than any record of signals has; a comment may be as long as it likes."""
    for line in lines:
        widths = (len(line.split(sign or None, MOST_COLUMNS)) for sign in DELIMITERS)
        if not line.lstrip().startswith("#") and max(widths) > MOST_COLUMNS:
            raise DataFileError(
                f"has more than {MOST_COLUMNS} columns; a table has a row per sample and a column per signal.",
                path=path,
            )


def lines_of(raw: bytes, encoding: str) -> Iterator[str]:
    """Iterate over the lines of a text."""
    with io.TextIOWrapper(io.BytesIO(raw), encoding, errors="replace") as text:
        for line in text:
            yield line.rstrip("\n")


def is_number(cell: str, *, decimal_comma: bool) -> bool:
    """Return whether a field is a number."""
    if len(cell) > _LONGEST_NUMBER:
        return False
    form = _DECIMAL_COMMA if decimal_comma else _NUMBER
    return bool(form.fullmatch(cell)) or (bool(cell) and cell.lower() in MISSING)


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
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    preamble: tuple[tuple[str, ...], ...] = ()
    headings: int = 0
    left_out: int = 0


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into its fields, without blanks and quotation marks around them."""
    if not delimiter:
        return [cell[1:-1] if cell[:1] == cell[-1:] == '"' else cell for cell in line.split()]
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
    """Return whether the delimiter is rather another sign: a decimal one, as in '1,5;2,5', or one before blanks, as in '1, x'."""
    cells = (cell for at in body for cell in rows[at])
    if delimiter == ",":
        return any(";" in cell or "\t" in cell for cell in cells)
    return not delimiter and any(cell.endswith((",", ";")) for cell in cells)


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
    numbers = frozenset(columns)
    beside = [tuple(cell for at, cell in enumerate(row) if at not in numbers) for row in rows[first:]]
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
