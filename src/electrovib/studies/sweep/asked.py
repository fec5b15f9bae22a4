"""Quantities that are requested of every case of a sweep."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError, gathered
from electrovib.solve.quantities import Named, read_name
from electrovib.studies.sweep.felt import FELT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.scenario import Scenario


@dataclass(frozen=True)
class Asked:
    """Quantities of the solution and of perception, and unit and meaning of each in the given order."""

    solved: tuple[Named, ...]
    felt: tuple[str, ...]
    units: dict[str, tuple[str, str]]


def read_quantities(scenario: Scenario, names: Sequence[str]) -> Asked:
    """Read the names of quantities."""
    solved: list[Named] = []
    units: dict[str, tuple[str, str]] = {}
    problems: list[str] = []
    layers = tuple(scenario.stack.layers)
    for text in [names] if isinstance(names, str) else names:
        plain = " ".join(text.split())
        if plain in FELT:
            units[plain] = FELT[plain]
            continue
        with gathered(problems):
            named = read_name(plain, layers, others=FELT)
            units[named.name] = named.unit, named.meaning
            solved.append(named)
    if problems:
        raise InputError(problems)
    return Asked(tuple(dict.fromkeys(solved)), tuple(each for each in units if each in FELT), units)
