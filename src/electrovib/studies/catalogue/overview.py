"""The catalogue on one screen: what a scenario is made of, and the names to choose from."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from electrovib.core.answer import terminal_width
from electrovib.core.discovery import find_members
from electrovib.core.status import UNVERIFIED, status_text
from electrovib.studies.catalogue.families import families, kind_of, places
from electrovib.studies.catalogue.items import LIBRARY, PAPERS, SCENARIOS, Item

_MORE = (
    "'electrovib list NAME' shows one in full, 'electrovib list WORD' searches names, meanings, parameters, materials,"
    " papers and scenarios, --all lists every entry with its source status, --bibtex the citations."
)


def overview(items: Iterable[Item]) -> str:
    """Write the names of everything by its place in a scenario, and how to find out more."""
    found = list(items)
    held = places()
    rows = {path: sorted(find_members(family)) for family, path in held.items()}
    outside = {kind_of(family): sorted(find_members(family)) for family in families() if family not in held}
    labels = (LIBRARY, "materials", "skins", "stacks", PAPERS)
    offered = {label: [item.record.name for item in found if item.record.group == label] for label in labels}
    count = sum(item.record.group == SCENARIOS for item in found)
    unverified = [
        item.record.name
        for item in found
        if item.record.status == UNVERIFIED and item.record.group != SCENARIOS
    ]
    width = max(map(len, [*rows, *offered, *outside])) + 2
    lines = ["Key of a scenario file, and the models to choose from:", ""]
    lines += [line for label, names in rows.items() for line in _row(label, names, width)]
    lines += ["", "Outside a scenario:", ""] if outside else []
    lines += [line for label, names in outside.items() for line in _row(label, names, width)]
    lines += ["", "Ready-made, used by name:", ""]
    lines += [line for label, names in offered.items() if names for line in _row(label, names, width)]
    lines += _row(SCENARIOS, [f"{count}, listed by 'electrovib list scenarios'"], width)
    lines += [
        "",
        *textwrap.wrap(f"{status_text(UNVERIFIED).capitalize()}: {', '.join(unverified)}.", terminal_width()),
    ]
    return "\n".join([*lines, *textwrap.wrap(_MORE, terminal_width())]) + "\n"


def _row(label: str, names: list[str], width: int) -> list[str]:
    parts = textwrap.wrap(", ".join(names), terminal_width() - width, break_on_hyphens=False)
    return [f"{label if place == 0 else '':<{width}}{part}" for place, part in enumerate(parts)]
