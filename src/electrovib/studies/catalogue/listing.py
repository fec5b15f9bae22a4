"""Tables of models, papers and scenarios, with the status of each source."""

from __future__ import annotations

from collections.abc import Iterable

from electrovib.core.answer import Table
from electrovib.studies.catalogue.items import Item
from electrovib.studies.catalogue.listed import Listed


def found_table(records: Iterable[Listed], title: str = "") -> Table:
    """Write the result of a search: what was found, what it is, and why it was found."""
    rows = [(record.name, record.kind, f"{record.meaning} [{record.reason}]") for record in records]
    return Table(title, ("name", "kind", "what it is [why it was found]"), tuple(rows))


def all_table(records: Iterable[Listed], title: str = "") -> Table:
    """Write every record on one line."""
    rows = [(record.name, record.kind, record.status or "definition", record.meaning) for record in records]
    return Table(title, ("name", "kind", "source status", "what it is"), tuple(rows))


def scenario_table(items: Iterable[Item], title: str = "") -> Table:
    """Write ready-made scenarios with what each reproduces; of a search also the stack, and why it was found."""
    rows = []
    for item in items:
        record = item.record
        why = f"; stack: {item.texts['stack']} [{record.reason}]" if record.reason else ""
        rows.append((record.name, record.reproduces or "-", f"{_without_paper(record)}{why}"))
    why = " [why it was found]" if rows and rows[0][-1].endswith("]") else ""
    return Table(title, ("scenario", "figure or statement", f"what it is{why}"), tuple(rows))


def _without_paper(record: Listed) -> str:
    """Omit from a title the author, year and figure that stand in the other columns."""
    author, _, year = record.paper.partition("_")
    start, colon, rest = record.meaning.partition(": ")
    return rest if colon and start.casefold().startswith(f"{author} {year}") else record.meaning
