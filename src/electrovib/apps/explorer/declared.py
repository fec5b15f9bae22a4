"""What a page writes about a parameter, from its declaration, and the fields of parameters that have no value."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.physics.perception import Perception
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from electrovib.core.quantity import Quantity
    from electrovib.scenario import Scenario


class Declared:
    """Words of a parameter, from its declaration."""

    path: str
    meaning: str
    unit: str
    source: str
    allowed: tuple[float, float]

    @property
    def section(self) -> str:
        """Part of the scenario to which the parameter belongs."""
        return self.path.partition(".")[0]

    @property
    def name(self) -> str:
        """Path below its part, in words; a layer's material is not named."""
        inner = self.path.partition(".")[2].replace(".material.", ".")
        inner = re.sub(r"channels\.(\d+)", lambda found: f"channel {int(found[1]) + 1}", inner)
        return inner.replace("_", " ").replace(".", ", ")

    @property
    def is_detail(self) -> bool:
        """Whether the parameter comes after the others of its section: that of a channel of perception."""
        return self.path.startswith("perception.channels.")

    def written(self, value: float) -> str:
        """Write a value with its unit, as it is read again."""
        return pretty_quantity(value, self.unit, digits=4)

    @property
    def help(self) -> str:
        """Meaning, declared range and source, as shown beside the slider."""
        low, high = (pretty_quantity(bound, self.unit) for bound in self.allowed)
        source = f" Source: {self.source}." if self.source else ""
        return f"{self.meaning} ({self.path}); allowed from {low} to {high}.{source}"


@dataclass(frozen=True)
class Blank(Declared):
    """A field for a parameter, at a dotted path, that has no value; `allowed` is its declared range [SI]."""

    path: str
    meaning: str
    unit: str
    source: str
    allowed: tuple[float, float]


def parameters_of(scenario: Scenario) -> Iterator[tuple[str, float | None, Quantity]]:
    """Walk over the parameters that a page offers: dotted path, value in SI (None without one), declaration.

    They are all parameters of the scenario and, where it declares no perception, those of the default one,
    with which the tab `Felt` is computed. A change of one of them declares it.
    """
    yield from scenario.parameters()
    if scenario.perception is None:
        for name, value, quantity in Perception().parameters():
            if "." not in name:  # a channel can be changed only where the channels are declared
                yield f"perception.{name}", value, quantity


def blanks(scenario: Scenario) -> list[Blank]:
    """Return a field for each parameter that can have a value and has none, in the order of the scenario."""
    return [
        Blank(path, quantity.doc, quantity.unit, "", (quantity.low, quantity.high))
        for path, value, quantity in parameters_of(scenario)
        if value is None
    ]
