"""A table as plain text, for a terminal of any width, and as HTML for a notebook."""

from __future__ import annotations

import html
import shutil
import textwrap

from electrovib.study.reproduction import Table

NARROWEST = 36
"""Least width of the last column, characters."""


def laid_out(table: Table) -> str:
    """Lay a table out in columns; the last column takes the rest of the line and is wrapped."""
    lines = [table.headings, *table.rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(table.headings))]
    room = terminal_width()
    taken = sum(widths[:-1]) + 2 * (len(widths) - 1)
    widths[-1] = max(min(widths[-1], room - taken), NARROWEST)
    shown = [table.title, "-" * len(table.title)] if table.title else []
    for line in lines:
        last = textwrap.wrap(line[-1], widths[-1]) or [""]
        first = "  ".join(cell.ljust(width) for cell, width in zip(line[:-1], widths[:-1], strict=True))
        shown.append(f"{first}  {last[0]}".rstrip())
        shown += [" " * taken + part for part in last[1:]]
    if table.caption:
        shown += ["", *textwrap.wrap(table.caption, room)]
    return "\n".join(shown) + "\n"


def as_html(table: Table) -> str:
    """Write a table as HTML, without styles of its own."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.headings)
    rows = "".join(
        f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in table.rows
    )
    title = f"<caption>{html.escape(table.title)}</caption>" if table.title else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def terminal_width() -> int:
    """Return the width of the terminal in characters, 120 where there is none and 80 at least."""
    return max(shutil.get_terminal_size((120, 24)).columns, 80)
