"""Which parameters a page shows first, and how words that a visitor types find one."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import nearest

if TYPE_CHECKING:
    from electrovib.apps.explorer.controls import Control

MOST_IMPORTANT: Final = 11
"""Parameters that a page shows first."""
_AIR: Final = 1.0
"""Relative permittivity of a layer of air, which nobody changes."""


def _of(section: str, *units: str) -> Callable[[Control], bool]:
    """Return the test for the parameters of a section in some units; in any unit where none is given."""
    return lambda each: each.section == section and (not units or each.unit in units)


def _of_materials(*units: str) -> Callable[[Control], bool]:
    return lambda each: _of("stack", *units)(each) and ".material." in each.path and each.value != _AIR


KINDS: Final[tuple[Callable[[Control], bool], ...]] = (
    _of("drive", "V", "A"),  # levels
    _of("friction"),
    _of("load"),
    lambda each: _of("stack")(each) and each.path.endswith(".thickness"),
    lambda each: each.unit == "m2",  # areas of the contact and of other electrodes
    _of("force", "m"),  # gaps of a law that has its own
    _of("motion", "m"),  # a gap that changes
    lambda each: _of_materials()(each) and each.path.endswith(".permittivity"),
    _of("drive", "1"),  # depth of a modulation
    _of("drive", "Hz"),
    _of_materials("S/m"),
    _of_materials("1"),  # how a material changes with frequency
    _of("drive", "s"),
)
"""Kinds of parameters on which the force depends most, the most important kind first.

A test compares them with the elasticities of the forces of every shipped scenario.
"""


def important(offered: Sequence[Control]) -> list[Control]:
    """Return the parameters that a page shows first, `MOST_IMPORTANT` at most, in the order of the page.

    They are those of the first of `KINDS` that have a value other than 0.
    """
    valued = [each for each in offered if each.value]
    ranked = dict.fromkeys(each.path for kind in KINDS for each in valued if kind(each))
    first = list(ranked)[:MOST_IMPORTANT]
    return [each for each in offered if each.path in first]


def words_of(typed: str) -> list[str]:
    """Return the words that were typed, in small letters; an underscore or a dot ends a word."""
    return re.sub(r"[_.,:]", " ", typed.casefold()).split()


def is_found(words: Sequence[str], texts: Sequence[str]) -> bool:
    """Return whether every word occurs in one of the texts."""
    text = " ".join(words_of(" ".join(texts)))
    return all(word in text for word in words)


_ALSO: Final = {"stratum_corneum": "skin", "insulator": "film coating", "friction": "lateral force"}
"""Other words for parts of dotted paths."""


def texts_of(control: Control) -> tuple[str, ...]:
    """Return the texts in which a parameter is searched: section, name, dotted path, meaning and other words for its parts."""
    also = (_ALSO.get(part, "") for part in control.path.split("."))
    return control.label, control.path, control.meaning, *also


def not_found(words: Sequence[str], offered: Sequence[Control]) -> str:
    """Write that no parameter has the words, with the nearest name for the first word that none has."""
    for word in words:
        if not any(is_found([word], texts_of(each)) for each in offered):
            known = {each for control in offered for each in words_of(control.label)}
            return f"No parameter is called '{word}'.{nearest(word, known)}"
    return "No parameter has all of these words; leave one out."
