"""The layout of a text found as the hypothesis that explains all its rows; of two with other numbers none is taken."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from electrovib.core.errors import DataFileError
from electrovib.data.text.layout import (
    DELIMITERS,
    WIDE,
    Layout,
    counts_samples,
    is_comment,
    is_statistic,
    split,
    with_headings,
)
from electrovib.data.unit_words import ALIKE, THOUSANDS, Notation

_ALIKE: Final = 0.75
"""Smallest share of rows of numbers among the lines after the first such row; other lines are then errors."""
_SHORTEST: Final = 0.1
"""Smallest share of the rows in which a column of a shorter record holds numbers."""
_SETTINGS_ABOVE: Final = 2
"""Most rows of numbers above a line such as ``data:`` that are settings."""
_FEW: Final = 4
"""Rows from which on a column has more than one number."""


def find_layout(
    lines: Sequence[str],
    *,
    refuse_doubt: bool = False,
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
) -> Layout | None:
    """Find the layout that explains most of the lines of a text as rows of numbers; None if no line is one.

    Of two that explain them equally well, with other numbers, none is taken: with `refuse_doubt` both are shown
    in a refusal.
    """
    text = "\n".join(lines)
    scored: list[tuple[tuple[float, int], Layout]] = []
    for separator in DELIMITERS if delimiter is None else (delimiter,):
        if separator.strip(" ") and separator not in text:
            continue
        rows = [split(line, separator) for line in lines]
        for comma, sign in _notations(text, separator, decimal_comma):
            found = _under(lines, rows, separator, Notation(decimal="," if comma else ".", thousands=sign))
            if found is not None:
                scored.append(found)
    if not scored:
        return None
    most = max(score for (score, _), _ in scored)
    best = max(
        (each for each in scored if each[0][0] == most), key=lambda each: _fit(each[1], each[0][1], lines)
    )
    others = [
        layout
        for (score, settings), layout in scored
        if score == most and _fit(layout, settings, lines)[:1] == _fit(best[1], best[0][1], lines)[:1]
    ]
    if refuse_doubt:
        _refuse_doubt(lines, best[1], others)
        _refuse_commas(lines, best[1])
        _refuse_other_notation(lines, best[1])
    return best[1]


def _fit(layout: Layout, settings: int, lines: Sequence[str]) -> tuple[bool, bool, int, int]:
    """Return what decides between layouts that explain the same rows: a heading for each field, no integers such as 05."""
    heading = lines[layout.headings] if layout.headings < layout.first else ""
    single = layout.decimal_comma and len(layout.columns) == 1
    fields = sum(map(bool, split(heading, "," if single and not layout.delimiter else layout.delimiter)))
    if layout.headings + 1 < layout.first and layout.names[0] == "time":
        fields += fields + 1 == len(layout.columns)  # the row below has its unit, which alone tells it
    most = layout.width + (
        layout.delimiter not in ("", WIDE)
    )  # LabVIEW has a heading 'Comment' without a field below it
    fits = not heading or len(layout.columns) <= fields <= most
    if layout.delimiter == "," and not heading:
        fits = not any(re.search(r",0\d", line) for line in lines[layout.first :])
    return fits, not single, sum(map(bool, layout.names)), settings


def _notations(text: str, delimiter: str, decimal_comma: bool | None) -> Iterator[tuple[bool, str]]:
    """Iterate over the notations of numbers of which a text shows a sign."""
    for comma in (False, True) if decimal_comma is None else (decimal_comma,):
        shown = "," in text or re.search(r"\d\.\d{3}(?!\d)", text) or decimal_comma is not None
        if comma and (not shown or (delimiter == "," and '"' not in text)):
            continue
        yield comma, ""
        for sign in THOUSANDS:
            if (sign == (delimiter or " ") and '"' not in text) or sign == (",." if comma else ".,")[0]:
                continue
            written = {" ": "[ \u00a0\u202f\u2009]", "'": "['\u2019]"}.get(sign, re.escape(sign))
            if re.search(rf"\d{written}\d{{3}}(?!\d)", text):
                yield comma, sign


def _refuse_doubt(lines: Sequence[str], best: Layout, others: Sequence[Layout]) -> None:
    """Refuse a text that two layouts explain with different numbers."""
    example = next((line.strip()[:60] for line in lines[best.first :] if line.strip()), "")

    def numbers(layout: Layout) -> list[float]:
        cells = split(lines[best.first], layout.delimiter)
        known = [cells[at] for at in layout.columns if at < len(cells)]
        return [
            (layout.notation.quantity(cell) or (layout.notation.number(cell) or 0.0,))[0] for cell in known
        ]

    own = numbers(best)
    for other in others:
        if other is not best and numbers(other) != own:
            read = " or as ".join(
                f"{', '.join(f'{each:.10g}' for each in numbers(layout))} ({layout.stated})"
                for layout in (best, other)
            )
            raise DataFileError(
                f"'{example}' can be read as {read}, and nothing in the file decides; state whether decimals are"
                " written with a comma (--set decimal_comma=true, or false), or the delimiter."
            )


def _refuse_commas(lines: Sequence[str], layout: Layout) -> None:
    """Refuse a text in which commas divide both the columns and the decimals, so that each column has become two."""
    above = next((line for line in reversed(lines[: layout.first]) if line.strip()), "")
    names = [name for name in split(above, ",") if name and not layout.notation.is_number(name)]
    body = "\n".join(lines[layout.first :])
    if layout.delimiter == "," and 2 * len(names) == layout.width > 2 and not re.search(r"[.\"]", body):
        raise DataFileError(
            f"has {layout.width} fields in each row below {len(names)} headings: commas divide both the columns and the decimals;"
            " write it with another delimiter."
        )


def _refuse_other_notation(lines: Sequence[str], layout: Layout) -> None:
    """Refuse rows of numbers right above the others that are written with the other decimal sign."""
    point = layout.decimal_comma
    other = Notation(decimal="." if point else ",")
    above = [split(line, layout.delimiter) for line in lines[max(layout.first - 3, 0) : layout.first]]
    if len(above) == 3 and all(len(row) == layout.width and all(map(other.is_number, row)) for row in above):
        raise DataFileError(
            f"the rows up to line {layout.first} are numbers with a decimal {'point' if point else 'comma'}, those below with a"
            f" decimal {'comma' if point else 'point'}; write all with one of them."
        )


def _under(
    lines: Sequence[str], rows: Sequence[list[str]], delimiter: str, notation: Notation
) -> tuple[tuple[float, int], Layout] | None:
    """Return the layout with this delimiter and notation, and a score of its fit to the numbers and to the preamble."""
    filled = [
        at
        for at, row in enumerate(rows)
        if any(row) and not is_comment(row[0]) and not is_statistic(row, notation)
    ]
    if not filled:
        return None
    body = filled[len(filled) // 2 :] if len(filled) > 3 else filled[-1:]
    width = Counter(len(rows[at]) for at in body).most_common(1)[0][0]
    columns = _columns([rows[at] for at in body if len(rows[at]) == width], width, notation)
    if not columns:
        return None
    alike = [
        at
        for at in filled
        if _is_alike(rows[at], columns, notation) or _is_stamp_alone(rows[at], columns, width)
    ]
    if not alike:
        return None
    if notation.thousands and not _divides_thousands([rows[at] for at in alike], columns, notation):
        return None
    first = _first(rows, filled, alike, columns, notation)
    numbers = [rows[at] for at in alike if at >= first]
    shorter = [
        place
        for place in _columns(numbers, width, notation)
        if sum(bool(row[place : place + 1] and row[place]) for row in numbers) >= _SHORTEST * len(numbers)
    ]  # settings beside the first rows are no column
    columns = tuple(sorted({*columns, *shorter}))
    kept = sum(at >= first for at in alike)
    letters = [
        (len(cell.replace(" ", "")), place in columns) for at in body for place, cell in enumerate(rows[at])
    ]
    share = sum(size for size, is_column in letters if is_column) / max(sum(size for size, _ in letters), 1)
    doubt = 0.5 if _splits_decimals(rows, body, delimiter) else 1.0
    fit = sum(_is_alike(rows[at], columns, notation) for at in body) / len(body)
    layout = with_headings(
        lines,
        rows,
        Layout(
            delimiter=delimiter,
            decimal_comma=notation.decimal == ",",
            thousands=notation.thousands,
            first=first,
            width=width,
            columns=columns,
        ),
    )
    apart = notation.decimal == "," != delimiter and layout.headings < first
    if apart and len(columns) == 1 and "," in lines[layout.headings]:
        doubt = 0.5  # '1,2' below 'a,b' is rather two columns than one
    settings = sum(delimiter not in ("", WIDE) and len(row) > 1 for row in layout.preamble)
    return (round(kept * share * doubt * fit, 9), settings), layout


def _divides_thousands(rows: Sequence[Sequence[str]], columns: Sequence[int], notation: Notation) -> bool:
    """Return whether a sign may stand between thousands: no number of its column has four digits without it.

    A point, which is so often that of decimals, has to be shown as such: by a decimal comma, or by integers below
    1000 beside numbers that have it.
    """
    shown = notation.thousands != "."
    for place in columns:
        cells = [row[place] for row in rows if row[place]]
        divided = [cell for cell in cells if notation.thousands in cell.translate(ALIKE)]
        bare = [cell for cell in cells if re.match(r"\D*\d{4}", cell)]
        if divided and bare:
            return False
        decimals = any(notation.decimal in cell for cell in cells)
        shown = shown or decimals or 0 < len(divided) < len(cells)
    return shown


def _columns(rows: Sequence[Sequence[str]], width: int, notation: Notation) -> tuple[int, ...]:
    """Return the places where most filled fields of rows are numbers, or numbers with their unit."""
    found = []
    for place in range(width):
        cells = [row[place] for row in rows if place < len(row) and row[place]]
        are = [notation.states(cell) for cell in cells]
        enough = sum(are) > 1 or len(rows) < _FEW
        if enough and 2 * sum(are) + bool(are and are[-1]) > len(cells):  # headings stand above numbers
            found.append(place)
    return tuple(found)


def _is_alike(row: Sequence[str], columns: Sequence[int], notation: Notation) -> bool:
    """Return whether a line is a row of numbers in these columns, of which some may be missing."""
    if len(row) <= columns[-1]:
        return False
    cells = [row[at] for at in columns if row[at]]
    return bool(cells) and all(notation.states(cell) for cell in cells)


def _is_stamp_alone(row: Sequence[str], columns: Sequence[int], width: int) -> bool:
    """Return whether a line is a row whose numbers are all missing beside its date or time."""
    others = [cell for cell in row if cell]
    return (
        len(row) == width
        and bool(others)
        and all(cell[0].isdigit() for cell in others)
        and not any(row[at] for at in columns)
    )


def _first(
    rows: Sequence[Sequence[str]],
    filled: Sequence[int],
    alike: Sequence[int],
    columns: tuple[int, ...],
    notation: Notation,
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
        return [bool(cell) and not notation.is_number(cell) for cell in cells]

    others = [place for place in range(max(columns)) if place not in columns]
    clean = [
        place
        for place in others
        if not any(words(at, [place])[:1] == [True] for at in alike[-len(alike) // 2 :])
    ]
    for at in filled:  # settings with a number for each column, such as a step below 'dt:'
        words_of_row = [cell for cell in rows[at] if cell]
        if first < at and len(words_of_row) == 1 and words_of_row[0].endswith(":"):
            before = [place for place in alike if first <= place < at]
            after = [place for place in alike if place > at]
            if after and len(before) <= _SETTINGS_ABOVE:
                first = after[0]
    for at in filled:  # settings with one number each look like rows; a row of headings ends them
        heading = words(at, columns)
        if at <= first or len(heading) < len(columns) or not all(heading):
            continue
        before = [place for place in alike if first <= place < at]
        after = [place for place in alike if place > at]
        if after and all(any(words(place, clean)) for place in before):
            first = after[0]
    return _behind_counts(rows, [at for at in alike if at >= first], columns)


def _behind_counts(rows: Sequence[Sequence[str]], alike: Sequence[int], columns: tuple[int, ...]) -> int:
    """Return the first of the rows of numbers, or the second where the first says how many samples each column has."""
    counts = counts_samples([rows[alike[0]][place] for place in columns])
    return alike[bool(counts and alike[1:] and all(rows[at][columns[0]] for at in alike[1:]))]


def _splits_decimals(rows: Sequence[Sequence[str]], body: Sequence[int], delimiter: str) -> bool:
    """Return whether the delimiter is rather another sign: a decimal one, as in '1,5;2,5', or one before blanks, as in '1, x'."""
    cells = (cell for at in body for cell in rows[at])
    if delimiter == ",":
        return any(";" in cell or "\t" in cell for cell in cells)
    return not delimiter and any(cell.endswith((",", ";")) for cell in cells)
