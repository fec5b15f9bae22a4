"""The materials that electrovibration displays are built of, each value with its source and status."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from typing import Any, Final

from electrovib.core.citation import STATUSES
from electrovib.core.parsing import read_toml
from electrovib.core.units import format_quantity, parse_quantity

UNVERIFIED: Final = STATUSES[-1]
SAME_THICKNESS: Final = 2.0
"""Factor up to which a strength measured on a thinner layer counts as measured at the thickness of a layer; a choice."""


@dataclass(frozen=True, kw_only=True)
class SourcedValue:
    """One number that a source gives.

    `value` in the SI `unit`; `conditions` are frequency, temperature and kind of the value, as far as the
    source states them; `status` says how far the source was read: one of `electrovib.core.citation.STATUSES`.
    """

    value: float
    unit: str
    conditions: str
    source: str
    status: str

    def __post_init__(self) -> None:
        """Refuse a value without a source, or with an unknown status."""
        if not self.source or self.status not in STATUSES:
            msg = f"{self.value:g} {self.unit}: needs a source and a status, one of {', '.join(STATUSES)}"
            raise TypeError(msg)

    @property
    def origin(self) -> str:
        """Source, status and conditions as one text."""
        return f"{self.source} ({'; '.join(filter(None, (self.status, self.conditions)))})"


@dataclass(frozen=True, kw_only=True)
class BreakdownStrength(SourcedValue):
    """One breakdown strength.

    `thickness` is that of the thinnest and the thickest layer on which it was measured [m]; None if the
    source does not state it.
    """

    thickness: tuple[float, float] | None

    @property
    def thickest(self) -> float:
        """Thickest layer on which it was measured [m]; 0 if the source does not state it."""
        return self.thickness[1] if self.thickness else 0.0

    @property
    def measured_at(self) -> str:
        """The thickness at which it was measured, as a text."""
        if self.thickness is None:
            return "measured at a thickness that its source does not state"
        low, high = (format_quantity(edge, "m", digits=3) for edge in self.thickness)
        return f"measured at {low}" if low == high else f"measured at {low} to {high}"

    def compared_with(self, thickness: float) -> str:
        """Say whether a layer of a thickness [m] is ``"same"``, ``"thinner"`` or ``"thicker"`` than those that were measured.

        ``"same"`` is within a factor of `SAME_THICKNESS`; ``"unknown"`` without a thickness of the
        measurement.
        """
        if self.thickness is None:
            return "unknown"
        if thickness > SAME_THICKNESS * self.thickness[1]:
            return "thicker"
        return "thinner" if SAME_THICKNESS * thickness < self.thickness[0] else "same"


@dataclass(frozen=True, kw_only=True)
class Dispersion:
    """A material model that follows the permittivity over frequency.

    `parameters` are those of the material model of the name `model`, without the conductivity; `status` says
    how far the source was read.
    """

    model: str
    parameters: Mapping[str, Any]
    source: str
    status: str


@dataclass(frozen=True, kw_only=True)
class Substance:
    """One material of the library.

    A scenario writes its `name`, ``material = "silica"``, and finds it under its `aliases` too. `kind` is
    ``"glass"``, ``"oxide"``, ``"polymer film"``, ``"coating"`` or ``"ferroelectric polymer"``. The first
    `permittivity` is taken at all frequencies where there is no `dispersion`; the `conductivity` at zero
    frequency [S/m] is taken as 0 without a value. Where a source gives a lower bound of the resistivity
    alone, `conductivity_bound` is the upper bound of the conductivity [S/m].
    """

    name: str
    aliases: tuple[str, ...]
    meaning: str
    kind: str
    permittivity: tuple[SourcedValue, ...]
    dispersion: Dispersion | None = None
    conductivity: SourcedValue | None = None
    conductivity_bound: SourcedValue | None = None
    strengths: tuple[BreakdownStrength, ...] = ()

    @property
    def material(self) -> dict[str, Any]:
        """Table of the material model that a scenario takes."""
        conductivity = (
            {"conductivity": self.conductivity.value} if self.conductivity else {"conductivity": 0.0}
        )
        name = {"substance": self.name}
        if self.dispersion is not None:
            return {"model": self.dispersion.model, **name, **self.dispersion.parameters, **conductivity}
        return {"model": "Constant", **name, "permittivity": self.permittivity[0].value, **conductivity}

    def origin(self, parameter: str) -> tuple[str, str]:
        """Find where a parameter of its material model is from: source, status and conditions in words, and the status alone.

        Of a list `parameter` is the path in it. The status is ``"unknown"`` for a conductivity that was not
        found.
        """
        if parameter == "conductivity":
            return self._origin_of_conductivity
        if self.dispersion is not None:
            return f"{self.dispersion.source} ({self.dispersion.status})", self.dispersion.status
        return self.permittivity[0].origin, self.permittivity[0].status

    def taken_by(self, table: Mapping[str, Any]) -> dict[str, str]:
        """Find which parameters the table of a material takes from the library, with the status of their source.

        A value that differs from that of the library is the table's own.
        """
        return {
            name: self.origin(name)[1]
            for name, value in self.material.items()
            if name not in {"model", "substance"} and table.get(name) == value
        }

    @property
    def _origin_of_conductivity(self) -> tuple[str, str]:
        if self.conductivity is not None:
            return self.conductivity.origin, self.conductivity.status
        if (bound := self.conductivity_bound) is not None:
            return (
                f"below {format_quantity(bound.value, 'S/m', digits=3)}, taken as 0: {bound.origin}",
                bound.status,
            )
        return "not found; taken as 0", "unknown"

    def strength_of(self, thickness: float) -> BreakdownStrength | None:
        """Choose the strength that a layer of a thickness [m] is compared with; None if no strength is declared.

        It is that of the thinnest measured layer which is at least as thick, because strength usually falls
        with thickness; if none is, the lowest of all, of equal ones that of the thickest layer.
        """
        thick = [each for each in self.strengths if each.thickest >= thickness]
        if thick:
            return min(thick, key=lambda each: each.thickest)
        return min(self.strengths, key=lambda each: (each.value, -each.thickest), default=None)

    @property
    def strength_words(self) -> str:
        """All breakdown strengths, each with its thickness, source and status, as one text."""
        return "; ".join(
            f"breakdown strength {format_quantity(each.value, each.unit, digits=3)} {each.measured_at}, {each.origin}"
            for each in self.strengths
        )


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
