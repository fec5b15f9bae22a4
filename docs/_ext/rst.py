"""Parts of reStructuredText: titles, tables, lists, plain text; and tables of Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

from electrovib.core.answer import Table


def plain(text: str) -> str:
    """Return a text that reStructuredText shows as it is, apart from names between backticks."""
    parts = re.split(r"(`[^`]+`)", " ".join(text.split()))
    escaped = "".join(
        part if part.startswith("`") else re.sub(r"([\\*|`_])", r"\\\1", part) for part in parts
    )
    escaped = re.sub(r"\b(?!https?:)([a-z]+):(?=//)", r"\1\\:", escaped)  # tcp://host is no link
    # initials and signs at the beginning are no lists
    return re.sub(r"^(\w+[.)]|[-+])(?= )", r"\\\1", escaped)


def linked(text: str) -> str:
    """Return a citation, with the numbers of DOI and arXiv in it as links; of a text that `plain` has returned."""
    text = re.sub(
        r"\bdoi:(10\.\S+?)(?=[,;)]*(?:\s|$))",
        lambda match: f"`doi:{match[1]} <https://doi.org/{match[1].replace(chr(92), '')}>`__",
        text,
    )
    return re.sub(r"\barXiv:(\d{4}\.\d{4,5})", r"`arXiv:\1 <https://arxiv.org/abs/\1>`__", text)


def title(text: str, line: str = "=") -> str:
    """Return a title, underlined."""
    return f"{plain(text)}\n{line * max(len(plain(text)), 4)}\n"


def literal(text: str, language: str = "text") -> str:
    """Return a block that is shown as it is."""
    return f".. code-block:: {language}\n\n" + "\n".join(f"   {line}".rstrip() for line in text.splitlines())


def fields(pairs: Iterable[tuple[str, str]]) -> str:
    """Return a list of labels and texts in reStructuredText; a label without a text is omitted."""
    return "\n".join(f":{label}: {text}" for label, text in pairs if text)


def items(texts: Iterable[str]) -> str:
    """Return a list, one line each."""
    return "\n".join(f"- {text}" for text in texts)


def grid(headings: Sequence[str], rows: Iterable[Sequence[str]], widths: str = "auto") -> str:
    """Return a table of cells in reStructuredText."""
    lines = [".. list-table::", "   :header-rows: 1", f"   :widths: {widths}", "   :class: wide", ""]
    for row in (headings, *rows):
        lines += [f"   {'* -' if place == 0 else '  -'} {cell}".rstrip() for place, cell in enumerate(row)]
    return "\n".join(lines)


def markdown(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of Markdown, for the pages that are also read in the repository."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines) + "\n"


def shown(table: Table) -> str:
    """Return a table of plain texts."""
    return grid(table.headings, [[plain(cell) for cell in row] for row in table.rows])


def folded(summary: str, *parts: str) -> str:
    """Return parts that are opened by a click; nothing without parts."""
    opened, closed = (
        f".. raw:: html\n\n   {tag}"
        for tag in (f"<details><summary>{escape(summary)}</summary>", "</details>")
    )
    return joined([opened, *parts, closed]) if parts else ""


def hidden_contents(names: Iterable[str]) -> str:
    """Return a table of contents for the side bar."""
    return ".. toctree::\n   :hidden:\n\n" + "\n".join(f"   {name}" for name in names)


def joined(parts: Iterable[str]) -> str:
    """Return the parts that are not empty, with a line between them."""
    return "\n\n".join(part.rstrip() for part in parts if part.strip()) + "\n"
