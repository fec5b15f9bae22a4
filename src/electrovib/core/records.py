"""Several records of one kind, which show themselves as a table."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from html import escape
from typing import Any, Final, TypeVar, cast

R = TypeVar("R")

_WIDEST: Final = 60
"""Characters of a cell in plain text."""
_MOST: Final = 60
"""Rows in plain text."""
_HEIGHT: Final = "32em"
"""Height in a notebook beyond which a table scrolls."""


class Records(tuple[R, ...]):
    """An immutable sequence of dataclass instances; its text is a table, and a notebook shows it as one.

    Notes
    -----
    The columns are the fields of the first record; a field named with an underscore first is not shown. A column in
    which every cell is empty is omitted. Slices are plain tuples.
    """

    __slots__ = ()

    def table(self) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
        """Return what is shown.

        Returns
        -------
        headings : tuple of str
            Names of the columns that hold anything.
        rows : tuple of tuple of str
            One text for each column, one row for each record.
        """
        names = (
            [field.name for field in fields(cast("Any", self[0])) if not field.name.startswith("_")]
            if self._known()
            else []
        )
        columns = {name: [_text(getattr(record, name, None)) for record in self] for name in names}
        shown = {name: cells for name, cells in columns.items() if any(cells)}
        return tuple(name.replace("_", " ") for name in shown), tuple(zip(*shown.values(), strict=True))

    def _known(self) -> bool:
        return bool(self) and is_dataclass(self[0])

    def __repr__(self) -> str:
        """Write the table in columns of plain text; long cells and long tables are cut."""
        if not self._known():
            return f"{type(self).__name__}({list(self)!r})" if self else "no records"
        headings, rows = self.table()
        lines = [headings, *([_cut(cell) for cell in row] for row in rows[:_MOST])]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        text = [
            "  ".join(f"{cell:{width}}" for cell, width in zip(line, widths, strict=True)).rstrip()
            for line in lines
        ]
        if len(rows) > _MOST:
            text.append(f"... and {len(rows) - _MOST} more of {len(rows)}")
        return "\n".join(text)

    def _repr_html_(self) -> str | None:
        """Write the table as HTML, with every text escaped."""
        return html_table(*self.table()) if self._known() else None


def html_table(headings: tuple[str, ...], rows: tuple[tuple[str, ...], ...]) -> str:
    """Write a table as HTML that needs no style sheet.

    Parameters
    ----------
    headings : tuple of str
        One for each column.
    rows : tuple of tuple of str
        Texts, escaped here.

    Returns
    -------
    str
        ``<div>`` that scrolls when the table is long.
    """
    left = 'style="text-align: left; vertical-align: top"'
    head = "".join(f"<th {left}>{escape(cell)}</th>" for cell in headings)
    body = "".join(f"<tr>{''.join(f'<td {left}>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div style="max-height: {_HEIGHT}; overflow: auto">{table}</div>'


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (tuple, list)):
        return ", ".join(_text(item) for item in value)
    return str(value)


def _cut(cell: str) -> str:
    line = " ".join(cell.split())
    return line if len(line) <= _WIDEST else f"{line[: _WIDEST - 4].rstrip()} ..."
