"""The materials that electrovibration displays are built of, each value with its source and status."""

from __future__ import annotations

import difflib
import functools

from electrovib.physics.material.library import inorganic, polymers
from electrovib.physics.material.library.record import (
    UNVERIFIED,
    BreakdownStrength,
    Dispersion,
    SourcedValue,
    Substance,
)

__all__ = [
    "UNVERIFIED",
    "BreakdownStrength",
    "Dispersion",
    "SourcedValue",
    "Substance",
    "find_substance",
    "materials",
    "nearest_substances",
]


@functools.cache
def materials() -> tuple[Substance, ...]:
    """List the materials of the library in the order of their names."""
    return tuple(sorted((*inorganic.SUBSTANCES, *polymers.SUBSTANCES), key=lambda each: each.name))


def find_substance(name: str) -> Substance | None:
    """Find a material by its name or an alias, whatever its capitals, blanks and hyphens; None if there is none."""
    return _by_name().get(_plain(name))


def nearest_substances(name: str, *, most: int = 3) -> list[str]:
    """Find at most `most` names of materials that a word is like, most alike first."""
    close = difflib.get_close_matches(_plain(name[:60]), _by_name(), n=3 * most, cutoff=0.5)
    return list(dict.fromkeys(_by_name()[word].name for word in close))[:most]


@functools.cache
def _by_name() -> dict[str, Substance]:
    return {_plain(word): each for each in materials() for word in (each.name, *each.aliases)}


def _plain(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())
