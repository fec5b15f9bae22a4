"""One file for each publication, found automatically: its laws, values, scenarios and checks.

What was measured is data: `measured/author_year.toml`, without Python, found by its name and read as a measurement of your own.

Its docstring says what the paper claims and what it does not. `CITATIONS`, `CITATION`, `STATUS` and a check are required;
ours take from `publications.toml` what they cite, what was not read, what is at odds and what scenarios show;
laws are subclasses of a family, and `skins()`, `materials()`, `stacks()`, `scenarios()`, `quantities()` and `reproduce()`
are there if they have something to give. `PRESETS` states for each scenario what it shows. A scenario is a base and changes:
a pair is a value and its source, a table's source is that of the values in it without one, and what is not changed keeps the
source of the base.
"""

from __future__ import annotations

import functools
from importlib import resources
from typing import TYPE_CHECKING, Any

from electrovib.core.citation import Citation, cited
from electrovib.core.parsing import read_toml

if TYPE_CHECKING:
    from electrovib.scenario.sources import PresetNote


@functools.cache
def publications() -> dict[str, Any]:
    """Return what each paper is cited as, and what was not read of it."""
    return read_toml((resources.files(__name__) / "publications.toml").read_text(encoding="utf-8"))


def _publication(module: str) -> dict[str, Any]:
    found: dict[str, Any] = publications()[module.removeprefix(f"{__name__}.").partition(".")[0]]
    return found


def cited_as(module: str) -> tuple[tuple[Citation, ...], str]:
    """Return the citations of the paper that a module belongs to, and all of them as one text."""
    given = _publication(module)["citations"]
    found = tuple(Citation(**each | {"authors": tuple(each.get("authors", ()))}) for each in given)
    return found, cited(found)


def not_read(module: str) -> str:
    """Return what was not read of the paper that a module belongs to."""
    text: str = _publication(module)["not_read"]
    return text


def defects(module: str) -> tuple[str, ...]:
    """Return where the paper that a module belongs to is at odds with others or with itself."""
    return tuple(_publication(module)["defects"])


def preset_notes(module: str) -> dict[str, PresetNote]:
    """Return what the ready-made scenarios of the paper that a module belongs to show."""
    from electrovib.scenario.sources import PresetNote

    return {name: PresetNote(**each) for name, each in _publication(module)["presets"].items()}
