"""A table of texts as HTML, for a notebook."""

from __future__ import annotations

from html import escape
from typing import Final

_HEIGHT: Final = "32em"
"""Height in a notebook beyond which a table scrolls."""


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
