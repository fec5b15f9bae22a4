"""Layout of a text: delimiter, notation of numbers, headings, units, and where the numbers are; and its lines and fields."""

from __future__ import annotations

import csv
import dataclasses
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import MOST_COLUMNS, NotRead
from electrovib.data.unit_words import (
    MISSING,
    UNIT_NAMES,
    UNITS,
    Notation,
    as_unit,
    name_and_unit,
    unit_of_force,
)

WIDE: Final = "  "
DELIMITERS: Final = ("\t", ";", ",", "|", "", WIDE)
"""Candidates; the empty text stands for blanks, two blanks for two or more."""
_NO_TEXT: Final = 4096
"""First bytes among which a zero byte shows that a file is no text."""
BEGINNING: Final = 200
"""Lines of the beginning of a text from which its layout is found; half as many of its middle and of its end are looked at."""
_LONGEST_LINE: Final = 1_000_000
_COMMENT: Final = ("#", "%")
"""Signs that stand alone before headings."""
_SETTING: Final = re.compile(
    r"(?i)(horizontal|vertical|record|sample|probe|model|serial|firmware|software)[ _]"
)
"""Beginning of the name of a setting of an oscilloscope, which is no heading."""
STATISTICS: Final = re.compile(
    r"(?i)(mean|max(imum)?|min(imum)?|average|avg|median|std\.?( ?dev\w*\.?)?|stdev\w*|standard deviation|sum|total|count|rms|"
    r"variance|range|mittelwert|maximalwert|minimalwert|summe|standardabweichung|moyenne|p-?p|pk-?pk|n)\W*"
)
"""Words that stand before a row of statistics."""
SCALING: Final = re.compile(
    r"(?i)(scale|scaling)( ?factors?)?|factors?|multiplier|gain|slope|offset|\w*faktor"
)
"""Words that stand before a row of factors or zeros, one for each column."""
_SIGN: Final = re.compile(r"^#+\s*|^%+\s+(?=\S)")
"""Sign of a comment before the first heading."""
_STATEMENT: Final = re.compile(r"[^:=]+[:=]\s*\S.*|[^,;\t]+[,;\t]\s*[+-]?\d[\d.,]*\s?[a-zA-Zµ]{1,4}(/s)?")
_VALUE: Final = re.compile(r"[+-]?\d[\d.,]*\s?[a-zA-Zµ]{1,4}(/s)?|\w+\s?=.*")
"""Value of a setting, such as ``10.0kS/s`` or ``F=100Hz``."""
_TWO_LINES: Final = re.compile(rb'(?:\A|(?<=[,;\t\n]))"[^"\n]{0,80}\n[^"\n]{0,80}"(?=[,;\t\n])')
"""Heading in quotation marks that goes on in the next line."""
_NO_NAME: Final = re.compile(r"[+-]?[\d.]")
_NAMED_ROW: Final = re.compile(r'"\d+"[^"]*$')
"""Row of numbers behind its own in quotation marks, as R writes tables, whose headings leave that one out."""
_QUOTED: Final = re.compile(r'"([^"]*)"|([^\s"]+)')
RULE: Final = re.compile(r"[#%\s]*[-=_*+|~]{3,}[-=_*+|~\s]*|BEGIN")
"""Line that divides headings from numbers."""
_OF_ONE_COLUMN: Final = re.compile(r"(?i)[#%\s]*(?:column|col|channel|field)\s*(\d+)\s*[:=]\s*(\S.*?)\s*")
"""Heading of one of the columns, which stand one below the other."""
_WIDE_GAP: Final = re.compile(r"\s{2,}|\t")
WORD_WITH_UNIT: Final = re.compile(r"\S+(?:\s{1,9}[\[(][^\])]{0,40}[\])])?")
_FIRST_CELLS: Final = re.compile(r"x|x-axis|time|source|t|", re.IGNORECASE)
"""First field of a row of headings whose other fields may be numbers, such as ``x-axis,1,2``."""


def as_utf8(raw: bytes) -> bytes:
    """Return a text in UTF-8 with line feeds, whatever its encoding; bytes that are none are refused."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raw = raw.decode("utf-16", errors="replace").encode(errors="replace")
    elif b"\0" in raw[:_NO_TEXT]:
        raise DataFileError("is not a text file; it holds zero bytes.")
    elif not raw.isascii():
        try:
            raw.decode()
        except UnicodeDecodeError:  # instruments write the micro sign in Latin-1, Windows a dash beyond it
            raw = raw.decode("cp1252", errors="replace").encode()
        raw = raw.removeprefix("\ufeff".encode())
    raw = raw.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in raw else raw
    if not _TWO_LINES.search(raw, 0, _NO_TEXT):
        return raw
    return _TWO_LINES.sub(lambda found: found[0].replace(b"\n", b" "), raw[:_NO_TEXT]) + raw[_NO_TEXT:]


def is_comment(line: str) -> bool:
    """Return whether a line is a comment; a missing reading such as ``#N/A`` is none."""
    text = line.lstrip()
    return text.startswith("#") and re.split(r"[\t;,| ]", text, maxsplit=1)[0].lower() not in MISSING


def check_width(lines: Sequence[str]) -> None:
    """Refuse a text with more columns than any record of signals has; a comment may be as long as it likes."""
    for line in lines:
        widths = (len(line.split(sign.strip(" ") or None, MOST_COLUMNS)) for sign in DELIMITERS)
        if not is_comment(line) and max(widths) > MOST_COLUMNS:
            raise DataFileError(
                f"has more than {MOST_COLUMNS} columns; a table has a row per sample and a column per signal."
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
    - `statistics`: lines of statistics above the numbers.
    - `not_read`: these, rows right above `first` that hold words in place of numbers, and headings without a field below.
    - `has_unused_headings`: whether words right above the numbers are one more or one less than the fields.
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
    statistics: tuple[str, ...] = ()
    not_read: tuple[NotRead, ...] = ()
    has_unused_headings: bool = False

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
        if line.count('"') > 2:  # headings of several words
            return [word or quoted for quoted, word in _QUOTED.findall(line)]
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


def with_headings(lines: Sequence[str], rows: Sequence[list[str]], layout: Layout) -> Layout:
    """Return a layout with the headings, units and preamble of the lines above the numbers."""
    first, columns, notation = layout.first, layout.columns, layout.notation
    width = len(rows[first])
    rows = [
        row[1:] if at < first and row and row[0] in _COMMENT and len(row) > width else row
        for at, row in enumerate(rows)
    ]
    above = [at for at in range(first) if any(rows[at]) and not RULE.fullmatch(lines[at])]
    statistics = [at for at in above if is_statistic(rows[at], notation)]
    above = [at for at in above if at not in statistics] if statistics != above else above
    for at in above[-3:]:  # headings of several words, of which blanks alone would make several headings
        rows[at] = _of_several_words(lines[at], rows[at], width, layout.delimiter)
        rows[at] = _of_all_columns(rows[at], width, named_rows=bool(_NAMED_ROW.match(lines[first])))
    left_out = _faulty(rows, above, columns, notation)
    headings = _headings(rows, above[: len(above) - left_out], layout)
    if not headings and left_out:
        left_out, headings = 0, _headings(rows, above, layout)
    names, units = _named(rows, headings, range(max(width, layout.width)))
    if not headings:
        names, units = _one_below_the_other(lines[:first], names, units)
    numbers = frozenset(columns)
    beside = [tuple(cell for at, cell in enumerate(row) if at not in numbers) for row in rows[first:]]
    above, faulty = above[: len(above) - left_out], above[len(above) - left_out :]
    preamble = [tuple(rows[at]) for at in above]
    told = [lines[at] for at in statistics] if statistics != [*above, *faulty] else []
    surplus = [cell for cell in (rows[headings[0]][max(width, layout.width) :] if headings else ()) if cell]
    not_read = [NotRead(name=name, why="no row has a field below it") for name in surplus]
    not_read += [NotRead(name=f"'{line}'", why="a row of statistics above the samples") for line in told]
    lowest = [*above, *faulty][-1:]
    return dataclasses.replace(
        layout,
        titles=tuple(names),
        title_units=tuple(units),
        preamble=(*preamble, *(row for row in beside if any(row))),
        headings=min(headings, default=first),
        statistics=tuple(told),
        not_read=(*not_read, *_left_out([rows[at] for at in faulty], first, notation)),
        has_unused_headings=not any(names)
        and bool(lowest)
        and _may_be_headings(rows[lowest[0]], width, layout),
    ).with_columns(columns)


def _left_out(faulty: Sequence[Sequence[str]], first: int, notation: Notation) -> list[NotRead]:
    """Name the rows at the beginning that hold words in place of numbers."""
    if not faulty:
        return []
    rows = "the first row" if len(faulty) == 1 else f"the first {len(faulty)} rows"
    said = next((cell for row in faulty for cell in row if not notation.is_number(cell)), "")
    why = (
        f"words in place of numbers, the first '{said[:40]}'"
        if said
        else "the number of samples of each column"
    )
    return [NotRead(name=f"{rows} behind the headings, from line {first - len(faulty) + 1} on", why=why)]


def _of_all_columns(row: list[str], width: int, *, named_rows: bool) -> list[str]:
    """Return headings of which one holds the delimiter, or which leave out that of the names of the rows, in their places."""
    named = [cell for cell in row if cell]
    if len(named) == width - 1 == len(row) and named_rows:
        return ["", *row]
    if len(named) > width and sum(bool(name_and_unit(cell)[1]) for cell in named) == width:
        joined, found = list[str](), list[str]()
        for cell in named:
            joined.append(cell)
            if name_and_unit(cell)[1]:
                found.append(", ".join(joined))
                joined = []
        return found if not joined else row
    return row


def _may_be_headings(row: Sequence[str], width: int, layout: Layout) -> bool:
    """Return whether a row of words above the numbers is rather headings that do not fit than a setting."""
    words = [cell for cell in row if cell and not layout.notation.is_number(cell)]
    is_heading = not _is_setting(row, layout.columns) or bool(
        _FIRST_CELLS.fullmatch(words[0] if words else "-")
    )
    return abs(len(words) - width) == 1 and len(words) > 1 and is_heading


def _one_below_the_other(
    lines: Sequence[str], names: list[str], units: list[str]
) -> tuple[list[str], list[str]]:
    """Return the names and units of lines such as ``# Column 1: Time (ms)``, if there is one for each column."""
    stated = [found.groups() for line in lines if (found := _OF_ONE_COLUMN.fullmatch(line))]
    numbers = [int(number) for number, _ in stated]
    if len(stated) != len(names) or numbers != list(range(numbers[0], numbers[0] + len(names))):
        return names, units
    parts = [name_and_unit(heading) for _, heading in stated]
    return [name for name, _ in parts], [unit_of_force(name, unit) for name, unit in parts]


def is_statistic(row: Sequence[str], notation: Notation) -> bool:
    """Return whether a row states a statistic of the samples, such as ``Mean,1.5,2.5``, or a factor of each column."""
    filled = [cell for cell in row if cell]
    numbers = [notation.is_number(cell) for cell in filled[1:]]
    if STATISTICS.fullmatch("".join(filled[:1])):
        return any(numbers)
    return len(numbers) > 1 and all(numbers) and bool(SCALING.fullmatch(filled[0].rstrip(": ")))


def _of_several_words(line: str, row: list[str], width: int, delimiter: str) -> list[str]:
    """Return as many headings as there are columns from a line that stands in one field, or that blanks divide."""
    text = line.strip()
    if delimiter not in ("", WIDE):
        if text[:1] in _COMMENT and '"' in text:  # a quotation mark behind the sign of a comment
            return split(text.lstrip("#% "), delimiter)
        parts = _WIDE_GAP.split(row[0].strip()) if sum(map(bool, row)) == 1 else []
        return parts if len(parts) == width > 1 else [_SIGN.sub("", row[0]), *row[1:]]
    text = re.sub(r"^WAVES\S*\s+", "", text.lstrip("#% "))  # before the names of Igor Pro
    for parts in (_WIDE_GAP.split(text), WORD_WITH_UNIT.findall(text), [text]):
        if len(parts) == width and not any(part.endswith((":", "=")) for part in parts):
            return [part.strip('"') for part in parts]
    return row


def _faulty(
    rows: Sequence[Sequence[str]], above: Sequence[int], columns: tuple[int, ...], notation: Notation
) -> int:
    """Count the rows right above the first row of numbers that hold words in place of numbers.

    Such a row begins with a number and has other words than units, or the same word everywhere; a row of
    headings has neither. The lowest may count the samples of each column in place of a first one.
    """
    count = 0
    for at in reversed(above):
        cells = [rows[at][place] for place in columns if place < len(rows[at])]
        if not count and counts_samples(cells):
            count += 1
            continue
        words = [cell for cell in cells if cell and not notation.is_number(cell)]
        begins = bool(cells) and bool(cells[0]) and cells[0] not in words
        if len(cells) < len(columns) or len(columns) < 2 or any(as_unit(word) is not None for word in words):
            break
        if not (begins and words) and not (len(words) == len(cells) and len(set(words)) == 1):
            break
        count += 1
    return count


def counts_samples(cells: Sequence[str]) -> bool:
    """Return whether a row states how many samples each column has: one whole number, and nothing below the time."""
    return len(cells) > 2 and not cells[0] and cells[1].isdigit() and len({*cells[1:]}) == 1


def _names_and_units(rows: Sequence[list[str]], above: Sequence[int], columns: tuple[int, ...]) -> list[int]:
    """Return the row of names and the row of units right above or below it; what stands below both is a comment."""
    for one, other in itertools.pairwise(above[-5:]):
        first, second = (
            [rows[at][place] for place in columns if place < len(rows[at]) and rows[at][place]]
            for at in (one, other)
        )
        for names, units, order in ((first, second, [one, other]), (second, first, [other, one])):
            if len(units) <= len(columns) / 2:
                continue
            has_no_name = as_unit(units[0]) == "s" and not any(rows[order[0]][columns[0] :][:1])
            if (
                len(units) <= len(names) + has_no_name
                and _units(units)
                and not any(as_unit(name) or _NO_NAME.match(name) for name in names)
            ):
                return order
    return []


def _headings(rows: Sequence[list[str]], above: Sequence[int], layout: Layout) -> list[int]:
    """Return the rows of headings and units, which are among the lowest of the lines above the numbers."""
    columns, notation = layout.columns, layout.notation
    if found := _names_and_units(rows, above, columns):
        return found
    headings: list[int] = []
    lower: list[str] = []
    behind_settings = False
    for at in reversed(above[-4:]):
        if layout.delimiter in ("", WIDE) and (
            len(rows[at]) != layout.width
            or any(re.search("[:=]", cell) or (cell and notation.is_number(cell)) for cell in rows[at])
        ):
            break
        cells = [rows[at][place] if place < len(rows[at]) else "" for place in columns]
        words = [cell for cell in cells if cell and not notation.is_number(cell)]
        if not headings and sum(map(bool, rows[at])) == 1 and len(columns) > 2 and not _units(words):
            continue  # such as 'End Comments' between headings and numbers
        values = rows[at][1 : max(columns[-1] + 1, 2)]  # settings may stand behind all headings
        if not headings and any(map(_VALUE.fullmatch, values)) and not _units(words):
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
        of_units = order and _units([cell for cell in rows[at] if cell])
        for place in places:
            cell = rows[at][place].lstrip("#").strip() if place < len(rows[at]) else ""
            name, unit = name_and_unit(cell)
            if (of_units or (order and names[place])) and (own := as_unit(cell.strip("[]()"))) is not None:
                units[place] = own
                names[place] = names[place] or "time" * (own == "s")
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
    if with_units == filled and len(filled) > 1:
        return False
    return 2 * len(filled) < len(columns) or (len(filled) == 2 and len(columns) > 2 and bool(row[0]))
