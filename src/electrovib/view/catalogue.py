"""The catalogue of models and papers as a page of the documentation."""

from __future__ import annotations

from electrovib.core.discovery import papers
from electrovib.core.status import STATUSES_EXPLAINED
from electrovib.study import catalogue
from electrovib.study.reproduction import Table

INTRODUCTION = f"""# Models and papers

What there is to choose from, found in the code as `electrovib models --all` finds it; a test keeps this page as the code is. The
source status is how the source of a model was read: {STATUSES_EXPLAINED}. A paper whose equations were not read runs nothing.
"""


def as_markdown(*, own: bool = True) -> str:
    """Write the page: one table for each thing predicted, then the claims of every paper.

    Parameters
    ----------
    own : bool
        Omit what other packages contribute, as docs/models.md does.

    Returns
    -------
    str
        Markdown.
    """
    parts = [INTRODUCTION]
    parts += [
        f"## {table.title[0].upper()}{table.title[1:]}\n\n{_rows(table)}"
        for table in catalogue.tables(own=own)
    ]
    parts.append(f"## What each paper claims, what not, and what it offers\n\n{catalogue.NAMES}.\n")
    for name, module in papers().items():
        if own and not catalogue.is_own(module):
            continue
        said = catalogue.claims(module)
        lines = [f"**{name}** ({module.STATUS}). {module.CITATION}", ""]
        lines += [f"- {key}: {text}" for key, text in said.items()]
        lines += [f"- {what}: {text}" for what, text in catalogue.ready_made(module, name)]
        if getattr(module, "NOT_READ", ""):
            lines.append(f"- not read: {' '.join(module.NOT_READ.split())}")
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def _rows(table: Table) -> str:
    lines = [table.headings, tuple("---" for _ in table.headings), *table.rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines) + "\n"
