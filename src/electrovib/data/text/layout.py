"""Layout of a text, one hypothesis about all its rows: delimiter, notation of numbers, headings, units, where the numbers are."""

from __future__ import annotations

import csv
import dataclasses
import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import MOST_COLUMNS
from electrovib.data.text.cells import ALIKE, MISSING, THOUSANDS, Notation
from electrovib.data.unit_words import UNIT_NAMES, UNITS, as_unit, name_and_unit, unit_of_force

WIDE: Final = "  "
DELIMITERS: Final = ("\t", ";", ",", "|", "", WIDE)
"""Candidates; the empty text stands for blanks, two blanks for two or more."""
_ALIKE: Final = 0.75
"""Smallest share of rows of numbers among the lines after the first such row; other lines are then errors."""
_FEW: Final = 4
"""Rows from which on a column has more than one number."""
_NO_TEXT: Final = 4096
"""First bytes among which a zero byte shows that a file is no text."""
BEGINNING: Final = 200
"""Lines of the beginning of a text from which its layout is found; half as many of its middle and of its end are looked at."""
_LONGEST_LINE: Final = 1_000_000
_COMMENT: Final = ("#", "%")
"""Signs that stand alone before headings."""
STATISTICS: Final = re.compile(
    r"(mean|max(imum)?|min(imum)?|average|avg|median|std\.?( ?dev\w*\.?)?|stdev\w*|standard deviation|sum|total|count|rms|"
    r"variance|range|mittelwert|maximalwert|minimalwert|summe|standardabweichung|moyenne|p-?p|pk-?pk|n)\W*",
    re.IGNORECASE,
)
"""Words that stand before a row of statistics."""
_SETTING: Final = re.compile(
    r"(horizontal|vertical|record|sample|probe|model|serial|firmware|software)[ _]", re.IGNORECASE
)
"""Beginning of the name of a setting of an oscilloscope, which is no heading."""
_SIGN: Final = re.compile(r"^#+\s*|^%+\s+(?=\S)")
"""Sign of a comment before the first heading."""
_STATEMENT: Final = re.compile(r"[^:=]+[:=]\s*\S.*|[^,;\t]+[,;\t]\s*[+-]?\d[\d.,]*\s?[a-zA-Zµ]{1,4}(/s)?")
_VALUE: Final = re.compile(r"[+-]?\d[\d.,]*\s?[a-zA-Zµ]{1,4}(/s)?|\w+\s?=.*")
"""Value of a setting, such as ``10.0kS/s`` or ``F=100Hz``."""
_WIDE_GAP: Final = re.compile(r"\s{2,}|\t")
_WORD_WITH_UNIT: Final = re.compile(r"\S+(?:\s{1,9}[\[(][^\])]{0,40}[\])])?")
_FIRST_CELLS: Final = re.compile(r"x|x-axis|time|source|t|", re.IGNORECASE)
"""First field of a row of headings whose other fields may be numbers, such as ``x-axis,1,2``."""


def as_utf8(path: Path, raw: bytes) -> bytes:
    """Return a text in UTF-8 with line feeds, whatever its encoding; bytes that are none are refused."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raw = raw.decode("utf-16", errors="replace").encode(errors="replace")
    elif b"\0" in raw[:_NO_TEXT]:
        raise DataFileError("is not a text file; it holds zero bytes.", path=path)
    elif not raw.isascii():
        try:
            raw.decode()
        except UnicodeDecodeError:  # instruments write the micro sign in Latin-1
            raw = raw.decode("latin-1").encode()
        raw = raw.removeprefix("\ufeff".encode())
    return raw.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in raw else raw


def is_comment(line: str) -> bool:
    """Return whether a line is a comment; a missing reading such as ``#N/A`` is none."""
    text = line.lstrip()
    return text.startswith("#") and re.split(r"[\t;,| ]", text, maxsplit=1)[0].lower() not in MISSING


def check_width(path: Path, lines: Sequence[str]) -> None:
    """Refuse a text with more columns than any record of signals has; a comment may be as long as it likes."""
    for line in lines:
        widths = (len(line.split(sign.strip(" ") or None, MOST_COLUMNS)) for sign in DELIMITERS)
        if not is_comment(line) and max(widths) > MOST_COLUMNS:
            raise DataFileError(
                f"has more than {MOST_COLUMNS} columns; a table has a row per sample and a column per signal.",
                path=path,
            )


def lines_of(raw: bytes, start: int = 0) -> Iterator[str]:
    """Iterate over the lines of a text in UTF-8 from a place on."""
    size = len(raw)
    while start < size:
        end = raw.find(b"\n", start)
        end = size if end < 0 else end
        yield raw[start:end].decode(errors="replace")
        start = end + 1


def place_of(raw: bytes, line: int, start: int = 0) -> int:
    """Return where a line begins, counted from 0 at a place; the end of a shorter text."""
    for _ in range(line):
        start = raw.find(b"\n", start) + 1
        if not start:
            return len(raw)
    return start


def end_of(raw: bytes, lines: int) -> int:
    """Return where the last lines of a text begin."""
    place = len(raw)
    for _ in range(lines + 1):
        place = raw.rfind(b"\n", 0, max(place, 0))
    return place + 1


def inspected(raw: bytes, many: int = BEGINNING) -> list[str]:
    """Return the lines of the beginning, the middle and the end of a text."""
    found = list(itertools.islice(lines_of(raw), many))
    place = place_of(raw, many)
    for start in (raw.find(b"\n", len(raw) // 2) + 1, end_of(raw, many // 2)):
        begin = max(start, place)
        found += itertools.islice(lines_of(raw, begin), many // 2)
        place = place_of(raw, many // 2, begin)
    return [line[:_LONGEST_LINE] for line in found]


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Layout of a text file; lines and fields count from 0.

    - `delimiter`: one character; empty for blanks.
    - `decimal_comma`, `thousands`: how numbers are written.
    - `first`, `width`: line of the first row of numbers, and fields of such a row.
    - `columns`: fields that hold numbers; `names` and `units` are theirs, empty where the file states none.
    - `titles`, `title_units`: those of all fields.
    - `preamble`: fields of the lines before the numbers, and the fields beside the numbers that hold text.
    - `headings`: line of the first row of headings; that of the first row of numbers if there is none.
    - `left_out`: number of rows right above `first` that hold words in place of numbers.
    """

    delimiter: str
    decimal_comma: bool
    thousands: str = ""
    first: int
    width: int
    columns: tuple[int, ...]
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    titles: tuple[str, ...] = ()
    title_units: tuple[str, ...] = ()
    preamble: tuple[tuple[str, ...], ...] = ()
    headings: int = 0
    left_out: int = 0

    @property
    def notation(self) -> Notation:
        """How the text writes numbers."""
        return Notation(decimal="," if self.decimal_comma else ".", thousands=self.thousands)

    @property
    def stated(self) -> str:
        """The options that state this hypothesis."""
        sign = {"\t": "tab", "": "blanks", WIDE: "wide blanks"}.get(self.delimiter, f"'{self.delimiter}'")
        thousands = f", thousands '{self.thousands}'" if self.thousands else ""
        return f"delimiter {sign}, decimal {'comma' if self.decimal_comma else 'point'}{thousands}"

    def with_columns(self, columns: Sequence[int]) -> Layout:
        """Return the layout with these columns of numbers."""
        return dataclasses.replace(
            self,
            columns=tuple(columns),
            names=tuple(self.titles[at] if at < len(self.titles) else "" for at in columns),
            units=tuple(self.title_units[at] if at < len(self.titles) else "" for at in columns),
        )


def split(line: str, delimiter: str) -> list[str]:
    """Split a line into its fields, without blanks and quotation marks around them."""
    if not delimiter:
        return [cell[1:-1] if cell[:1] == cell[-1:] == '"' else cell for cell in line.split()]
    if delimiter == WIDE:
        return _WIDE_GAP.split(line.strip())
    if '"' in line:
        try:
            return [
                cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
            ]
        except (csv.Error, StopIteration):
            pass
    return [cell.strip() for cell in line.split(delimiter)]


def find_layout(
    lines: Sequence[str],
    *,
    path: Path | None = None,
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
) -> Layout | None:
    """Find the layout that explains most of the lines of a text as rows of numbers; None if no line is one.

    Of two that explain them equally well, with other numbers, none is taken: with a `path` both are shown in a
    refusal.
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
    if path is not None:
        _refuse_doubt(path, lines, best[1], others)
        _refuse_commas(path, lines, best[1])
    return best[1]


def _fit(layout: Layout, settings: int, lines: Sequence[str]) -> tuple[bool, bool, int, int]:
    """Return what decides between layouts that explain the same rows: a heading for each field, no integers such as 05."""
    heading = lines[layout.headings] if layout.headings < layout.first else ""
    single = layout.decimal_comma and len(layout.columns) == 1
    fields = sum(map(bool, split(heading, "," if single and not layout.delimiter else layout.delimiter)))
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


def _refuse_doubt(path: Path, lines: Sequence[str], best: Layout, others: Sequence[Layout]) -> None:
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
                " written with a comma (--set decimal_comma=true, or false), or the delimiter.",
                path=path,
            )


def _refuse_commas(path: Path, lines: Sequence[str], layout: Layout) -> None:
    """Refuse a text in which commas divide both the columns and the decimals, so that each column has become two."""
    above = next((line for line in reversed(lines[: layout.first]) if line.strip()), "")
    names = [name for name in split(above, ",") if name and not layout.notation.is_number(name)]
    body = "\n".join(lines[layout.first :])
    if layout.delimiter == "," and 2 * len(names) == layout.width > 2 and not re.search(r"[.\"]", body):
        raise DataFileError(
            f"has {layout.width} fields in each row below {len(names)} headings: commas divide both the columns and the decimals;"
            " write it with another delimiter.",
            path=path,
        )


def _under(
    lines: Sequence[str], rows: Sequence[list[str]], delimiter: str, notation: Notation
) -> tuple[tuple[float, int], Layout] | None:
    """Return the layout with this delimiter and notation, and a score of its fit to the numbers and to the preamble."""
    filled = [
        at
        for at, row in enumerate(rows)
        if any(row) and not is_comment(row[0]) and not _is_statistic(row, notation)
    ]
    if not filled:
        return None
    body = filled[len(filled) // 2 :] if len(filled) > 3 else filled[-1:]
    width = Counter(len(rows[at]) for at in body).most_common(1)[0][0]
    columns = _columns([rows[at] for at in body if len(rows[at]) == width], width, notation)
    if not columns:
        return None
    alike = [at for at in filled if _is_alike(rows[at], columns, notation)]
    if not alike:
        return None
    if notation.thousands and not _divides_thousands([rows[at] for at in alike], columns, notation):
        return None
    first = _first(rows, filled, alike, columns, notation)
    columns = tuple(sorted({*columns, *_columns([rows[at] for at in alike if at >= first], width, notation)}))
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


def _is_statistic(row: Sequence[str], notation: Notation) -> bool:
    """Return whether a row states a statistic of the samples, such as ``Mean,1.5,2.5``."""
    filled = [cell for cell in row if cell]
    return bool(STATISTICS.fullmatch(filled[0])) and any(map(notation.is_number, filled[1:]))


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
        are = [notation.is_number(cell) or notation.quantity(cell) is not None for cell in cells]
        enough = sum(are) > 1 or len(rows) < _FEW
        if enough and 2 * sum(are) + bool(are and are[-1]) > len(cells):  # headings stand above numbers
            found.append(place)
    return tuple(found)


def _is_alike(row: Sequence[str], columns: Sequence[int], notation: Notation) -> bool:
    """Return whether a line is a row of numbers in these columns, of which some may be missing."""
    if len(row) <= columns[-1]:
        return False
    cells = [row[at] for at in columns if row[at]]
    return bool(cells) and all(
        notation.is_number(cell) or notation.quantity(cell) is not None for cell in cells
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
    for at in filled:  # settings with one number each look like rows; a row of headings ends them
        heading = words(at, columns)
        if at <= first or len(heading) < len(columns) or not all(heading):
            continue
        before = [place for place in alike if first <= place < at]
        after = [place for place in alike if place > at]
        if after and all(any(words(place, clean)) for place in before):
            first = after[0]
    return first


def _splits_decimals(rows: Sequence[Sequence[str]], body: Sequence[int], delimiter: str) -> bool:
    """Return whether the delimiter is rather another sign: a decimal one, as in '1,5;2,5', or one before blanks, as in '1, x'."""
    cells = (cell for at in body for cell in rows[at])
    if delimiter == ",":
        return any(";" in cell or "\t" in cell for cell in cells)
    return not delimiter and any(cell.endswith((",", ";")) for cell in cells)


def with_headings(lines: Sequence[str], rows: Sequence[list[str]], layout: Layout) -> Layout:
    """Return a layout with the headings, units and preamble of the lines above the numbers."""
    first, columns, notation = layout.first, layout.columns, layout.notation
    width = len(rows[first])
    rows = [
        row[1:] if at < first and row and row[0] in _COMMENT and len(row) > width else row
        for at, row in enumerate(rows)
    ]
    above = [at for at in range(first) if any(rows[at])]
    for at in above[-3:]:  # headings of several words, of which blanks alone would make several headings
        rows[at] = _of_several_words(lines[at], rows[at], width, layout.delimiter)
    left_out = _faulty(rows, above, columns, notation)
    headings = _headings(rows, above[: len(above) - left_out], layout)
    if not headings and left_out:
        left_out, headings = 0, _headings(rows, above, layout)
    names, units = _named(rows, headings, range(max(width, layout.width)))
    numbers = frozenset(columns)
    beside = [tuple(cell for at, cell in enumerate(row) if at not in numbers) for row in rows[first:]]
    preamble = [tuple(rows[at]) for at in above[: len(above) - left_out]]
    return dataclasses.replace(
        layout,
        titles=tuple(names),
        title_units=tuple(units),
        preamble=(*preamble, *(row for row in beside if any(row))),
        headings=headings[0] if headings else first,
        left_out=left_out,
    ).with_columns(columns)


def _of_several_words(line: str, row: list[str], width: int, delimiter: str) -> list[str]:
    """Return as many headings as there are columns from a line that stands in one field, or that blanks divide."""
    text = line.strip()
    if delimiter not in ("", WIDE):
        if text[:1] in _COMMENT and '"' in text:  # a quotation mark behind the sign of a comment
            return split(text.lstrip("#% "), delimiter)
        parts = _WIDE_GAP.split(row[0].strip()) if sum(map(bool, row)) == 1 else []
        return parts if len(parts) == width > 1 else [_SIGN.sub("", row[0]), *row[1:]]
    text = text.lstrip("#% ")
    for parts in (_WIDE_GAP.split(text), _WORD_WITH_UNIT.findall(text), [text]):
        if len(parts) == width and not any(part.endswith((":", "=")) for part in parts):
            return [part.strip('"') for part in parts]
    return row


def _faulty(
    rows: Sequence[Sequence[str]], above: Sequence[int], columns: tuple[int, ...], notation: Notation
) -> int:
    """Count the rows right above the first row of numbers that hold words in place of numbers.

    Such a row begins with a number and has other words than units, or the same word everywhere; a row of
    headings has neither.
    """
    count = 0
    for at in reversed(above):
        cells = [rows[at][place] for place in columns if place < len(rows[at])]
        words = [cell for cell in cells if cell and not notation.is_number(cell)]
        begins = bool(cells) and bool(cells[0]) and cells[0] not in words
        if len(cells) < len(columns) or len(columns) < 2 or any(as_unit(word) is not None for word in words):
            break
        if not (begins and words) and not (len(words) == len(cells) and len(set(words)) == 1):
            break
        count += 1
    return count


def _headings(rows: Sequence[list[str]], above: Sequence[int], layout: Layout) -> list[int]:
    """Return the rows of headings and units, which are among the lowest of the lines above the numbers."""
    columns, notation = layout.columns, layout.notation
    headings: list[int] = []
    lower: list[str] = []
    behind_settings = False
    for at in reversed(above[-4:]):
        if layout.delimiter in ("", WIDE) and (
            len(rows[at]) != layout.width
            or any(re.search("[:=]", cell) or notation.is_number(cell) for cell in rows[at])
        ):
            break
        cells = [rows[at][place] if place < len(rows[at]) else "" for place in columns]
        words = [cell for cell in cells if cell and not notation.is_number(cell)]
        if not headings and sum(map(bool, rows[at])) == 1 and len(columns) > 2 and not _units(words):
            continue  # such as 'End Comments' between headings and numbers
        if not headings and any(map(_VALUE.fullmatch, rows[at][1:])) and not _units(words):
            behind_settings = True  # such as 'Sampling rate,10.0kS/s' between headings and numbers
            continue
        if behind_settings and not any(name_and_unit(cell)[1] for cell in words):
            break
        if headings and all(map(as_unit, lower)) and _FIRST_CELLS.fullmatch(cells[0]) and all(cells[1:]):
            headings.insert(0, at)  # such as 'x-axis,1,2' above 'second,Volt,Volt'
            break
        few = len(words) < max(1, (len(columns) + 1) // 2) and not (
            _units(words) and len(words) == sum(map(bool, cells))
        )
        if few or _is_setting(rows[at], columns):
            break
        if headings and sum(as_unit(cell) is None for cell in lower if cell) > len(columns) // 4:
            break
        headings.insert(0, at)
        lower = [cell.strip("[]()") for cell in cells]
    return headings


def _units(cells: Sequence[str]) -> bool:
    return bool(cells) and all(as_unit(cell.strip("[]()")) is not None for cell in cells)


def _named(
    rows: Sequence[Sequence[str]], headings: Sequence[int], places: Sequence[int]
) -> tuple[list[str], list[str]]:
    """Return the names and units that rows of headings state for the fields of a row."""
    names = [""] * len(places)
    units = [""] * len(places)
    for order, at in enumerate(headings):
        for place in places:
            cell = rows[at][place].lstrip("#").strip() if place < len(rows[at]) else ""
            name, unit = name_and_unit(cell)
            if order and names[place] and (own := as_unit(cell.strip("[]()"))) is not None:
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
    if filled and filled[0].endswith(("=", ":")):
        return True
    with_units = [cell for cell in filled if name_and_unit(cell)[1]]
    valued = len(filled) > 1 and re.search(r"\d", "".join(filled[1:]))
    if valued and _SETTING.match(filled[0]) and len(with_units) < len(filled):
        return True
    if len(filled) == 1 and _STATEMENT.fullmatch(filled[0]):
        return True
    if all(as_unit(cell.strip("[]()")) is not None for cell in filled):
        return False
    return 2 * len(filled) < len(columns) or (len(filled) == 2 and len(columns) > 2 and bool(row[0]))
