"""The rows of a text through `pandas.read_csv`, each with its line, and the lines among and behind them that are none."""

from __future__ import annotations

import csv
import dataclasses
import io
import itertools
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import DataFileError
from electrovib.data.recorded import NotRead
from electrovib.data.text.layout import STATISTICS, WIDE, end_of, is_comment, lines_of, place_of, split

if TYPE_CHECKING:
    from pathlib import Path

    from electrovib.data.text.layout import Layout

_MOST_BEHIND: Final = 1000
"""Lines at the end of a text among which rows that are no samples are looked for."""
_SHOWN: Final = 40


@dataclass(frozen=True, kw_only=True)
class Body:
    """The rows of a text: a table of pandas with numbered columns, the line of a row from 1, and what is left out.

    `commented` rows have comments among them.
    """

    table: Any
    line: Callable[[int], int]
    left_out: tuple[NotRead, ...] = ()
    commented: bool = False

    @property
    def is_plain(self) -> bool:
        """Whether there are numbers in all fields of all lines, so that no line divides the text into tables."""
        return (
            not self.left_out and not self.commented and all(each.kind in "fiu" for each in self.table.dtypes)
        )


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


def body_of(path: Path, raw: bytes, layout: Layout) -> Body:
    """Read the rows behind the headings; rows of statistics and words at the end are left out, and cut off rows refused."""
    import pandas as pd

    start = place_of(raw, layout.first)
    end, behind = _behind(raw, start, layout)
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
    if table is not None and _is_even(rows, start, layout, table):

        def line(row: int) -> int:
            numbered = enumerate(lines_of(rows, start), layout.first + 1)
            filled = (number for number, text in numbered if text.strip())
            return next(itertools.islice(filled, row, None))

        return Body(table=table, line=line, left_out=behind)
    return dataclasses.replace(_uneven(path, rows, start, layout, behind), commented=not simple)


def _is_even(raw: bytes, start: int, layout: Layout, table: Any) -> bool:
    """Return whether all rows have the same number of fields; pandas fills short ones without a word."""
    if not table[layout.width - 1].isna().any():
        return True
    if layout.delimiter:
        return raw.count(layout.delimiter.encode(), start) == len(table) * (layout.width - 1)
    return False


def _uneven(path: Path, raw: bytes, start: int, layout: Layout, behind: tuple[NotRead, ...]) -> Body:
    """Read rows with different numbers of fields: lines of words are left out, rows that are cut off refused."""
    rows: list[list[str]] = []
    numbers: list[int] = []
    words: list[tuple[int, str]] = []
    for number, line in enumerate(lines_of(raw, start), layout.first + 1):
        if not line.strip() or is_comment(line):
            continue
        cells = split(line, layout.delimiter)
        if len(cells) <= layout.columns[-1]:
            if not any(layout.notation.is_number(cell) for cell in cells):
                words.append((number, line))
                continue
            raise DataFileError(
                f"line {number} has {len(cells)} fields, fewer than the {layout.width} of the other rows: it is cut off,"
                " or the delimiter is another one; state it.",
                path=path,
            )
        rows.append([cell.replace("\t", " ") for cell in cells])
        numbers.append(number)
    width = max(layout.width, *map(len, rows)) if rows else layout.width
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
    if not line.strip() or is_comment(line):
        return False
    cells = split(line, layout.delimiter)
    if any(STATISTICS.fullmatch(cell) and cell not in usual for cell in cells):
        return False
    numbers = [cells[at] for at in layout.columns if at < len(cells) and cells[at]]
    notation = layout.notation
    are = [notation.is_number(cell) or notation.quantity(cell) is not None for cell in numbers]
    return all(are) and (any(are) or len(cells) >= layout.width)


def _named(words: list[tuple[int, str]], why: str) -> tuple[NotRead, ...]:
    if not words:
        return ()
    (first, text), (last, _) = words[0], words[-1]
    name = f"line {first}" if len(words) == 1 else f"{len(words)} lines, {first} to {last}"
    return (NotRead(name=name, why=f"{why}, the first '{text.strip()[:_SHOWN]}'"),)
