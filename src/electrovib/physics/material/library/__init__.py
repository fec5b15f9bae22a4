"""The materials that electrovibration displays are built of, each value with its source and status."""

from __future__ import annotations

import difflib
import functools
from importlib import resources
from typing import TYPE_CHECKING, Any

from electrovib.core.parsing import read_toml
from electrovib.core.units import parse_quantity
from electrovib.physics.material.library.record import UNVERIFIED as UNVERIFIED
from electrovib.physics.material.library.record import BreakdownStrength as BreakdownStrength
from electrovib.physics.material.library.record import Dispersion as Dispersion
from electrovib.physics.material.library.record import SourcedValue as SourcedValue
from electrovib.physics.material.library.record import Substance as Substance

if TYPE_CHECKING:
    from collections.abc import Mapping


@functools.cache
def materials() -> tuple[Substance, ...]:
    """List the materials of the library in the order of their names."""
    content = read_toml((resources.files(__name__) / "materials.toml").read_text(encoding="utf-8"))
    sources = content.pop("sources")
    return tuple(_substance(name, content[name], sources) for name in sorted(content))


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


def _substance(name: str, table: dict[str, Any], sources: Mapping[str, str]) -> Substance:
    """Return a material as the file declares it."""

    def sourced(entry: dict[str, Any], unit: str) -> dict[str, Any]:
        if "resistivity" in entry:
            entry["value"] = 1 / parse_quantity(entry.pop("resistivity"), "ohm m")
        value = entry["value"]
        source, conditions = entry["source"], entry.get("conditions", "")
        number = parse_quantity(value, unit) if isinstance(value, str) else value
        known = {"value": number, "unit": unit, "source": sources.get(source, source)}
        return entry | known | {"conditions": conditions}

    def strength(entry: dict[str, Any]) -> BreakdownStrength:
        edges = entry.pop("thickness", None)
        low, high = edges if isinstance(edges, list) else (edges, edges)
        thickness = edges and (parse_quantity(low, "m"), parse_quantity(high, "m"))
        return BreakdownStrength(**sourced(entry, "V/m"), thickness=thickness)

    for key in table.keys() & {"conductivity", "conductivity_bound"}:
        table[key] = SourcedValue(**sourced(table[key], "S/m"))
    if "dispersion" in table:
        table["dispersion"] = Dispersion(**table["dispersion"])
    permittivity = tuple(SourcedValue(**sourced(entry, "1")) for entry in table.pop("permittivity"))
    strengths = tuple(strength(entry) for entry in table.pop("strengths"))
    aliases = tuple(table.pop("aliases"))
    return Substance(name=name, aliases=aliases, permittivity=permittivity, strengths=strengths, **table)
