"""The controls of a page: one for each parameter of the scenario, made from its declaration."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError
from electrovib.physics.perception import Perception
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from electrovib.core.quantity import Quantity
    from electrovib.scenario import Scenario


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


STEPS: Final = 1000
"""Positions of a slider."""
DECADES: Final = 2.0
"""Decades below and above its first value that a slider covers, within the declared range."""
_SPANS_DECADES: Final = 100.0
"""Ratio of the ends of a range from which its slider is logarithmic."""
SECTIONS: Final = {
    "drive": "Drive",
    "stack": "Layers",
    "circuit": "Circuit and amplifier",
    "force": "Force law",
    "contact": "Contact",
    "load": "Load",
    "friction": "Friction",
    "motion": "Motion",
    "finger": "Fingertip",
    "rig": "Tribometer",
    "perception": "Perception",
    "moisture": "Moisture",
    "limits": "Limits",
    "time": "Times",
    "frequency": "Frequencies",
}
"""Heading of the parameters below each part of a scenario, in the order of the page."""


@dataclass(frozen=True)
class Control:
    """A field for one parameter, at a dotted path, with a slider if it has a value.

    `value` at the start, None without one, `low` and `high`, the range of the slider, and `allowed`, the declared
    range, which the field takes, are in SI. `source` says where the value came from, empty if nothing is stated.
    `is_logarithmic`: equal distances of the slider are equal ratios.
    """

    path: str
    meaning: str
    unit: str
    source: str
    value: float | None
    low: float
    high: float
    allowed: tuple[float, float]
    is_logarithmic: bool

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
    def label(self) -> str:
        """Section and name."""
        return f"{SECTIONS[self.section]}: {self.name}"

    @property
    def is_detail(self) -> bool:
        """Whether the parameter comes after the others of its section: that of a channel of perception."""
        return self.path.startswith("perception.channels.")

    @property
    def help(self) -> str:
        """Meaning, declared range, ends of the slider and source, as shown beside it."""
        low, high = (pretty_quantity(bound, self.unit) for bound in self.allowed)
        source = f" Source: {self.source}." if self.source else ""
        kind = ", logarithmic" if self.is_logarithmic else ""
        ends = f"; slider from {self.written(self.low)} to {self.written(self.high)}{kind}"
        slider = "" if self.value is None else ends
        return f"{self.meaning} ({self.path}); allowed from {low} to {high}{slider}.{source}"

    def written(self, value: float | None) -> str:
        """Write a value with its unit, as it is read again; nothing for none."""
        return "" if value is None else pretty_quantity(value, self.unit, digits=4)

    def at(self, position: float) -> float:
        """Return the value [SI] at a position from 0 to `STEPS`; the first value itself at its own position."""
        if self.value is not None and round(position) == self.position(self.value):
            return self.value
        part = min(max(position / STEPS, 0.0), 1.0)
        if not self.is_logarithmic:
            return self.low + part * (self.high - self.low)
        return float(min(max(self.low * (self.high / self.low) ** part, self.low), self.high))

    def position(self, value: float) -> int:
        """Return the position of the slider nearest to a value, from 0 to `STEPS`."""
        value = min(max(value, self.low), self.high)
        if self.is_logarithmic:
            return round(STEPS * math.log(value / self.low) / math.log(self.high / self.low))
        return round(STEPS * (value - self.low) / (self.high - self.low))


def controls(scenario: Scenario) -> list[Control]:
    """Return a control for each parameter, in the order of `SECTIONS`; those without a value, and details, are last there.

    Parameters that can only be 0, such as the initial charge of the layer that touches the finger, have none.
    """
    declared = [_control(scenario, *each) for each in parameters_of(scenario)]
    found = [each for each in declared if each.section in SECTIONS and _can_move(scenario, each)]
    order = list(SECTIONS)
    return sorted(found, key=lambda each: (order.index(each.section), each.is_detail, each.value is None))


def _can_move(scenario: Scenario, control: Control) -> bool:
    """Return whether a parameter can have another value: some are 0 by the nature of their place."""
    if control.value != 0:
        return control.low < control.high
    for value in {control.low, control.high} - {0.0}:
        try:
            scenario.replace({control.path: value})
        except InputError:
            continue
        return True
    return False


def _control(scenario: Scenario, path: str, value: float | None, quantity: Quantity) -> Control:
    allowed = quantity.low, quantity.high
    low, high = allowed if value is None else _ends(value, quantity)
    source = scenario.sources.get(path, "")
    is_logarithmic = low > 0 and high / low >= _SPANS_DECADES
    return Control(path, quantity.doc, quantity.unit, source, value, low, high, allowed, is_logarithmic)


def _ends(value: float, quantity: Quantity) -> tuple[float, float]:
    """Return the ends of a slider: some decades around its value where the declared range covers more."""
    low, high = quantity.low, quantity.high
    if value == 0:
        size = min(high, -low if low < 0 else high)
        shown = min(size, _UNITS.get(quantity.unit, 1.0))
        return (-shown if low < 0 else max(low, 0.0)), shown
    if low < 0:
        size = min(3 * abs(value), max(high, -low))
        return max(low, -size), min(high, size)
    if quantity.unit == "1" and high <= 1:
        return low, high
    ratio = 10.0**DECADES
    return max(low, value / ratio), min(high, value * ratio)


_UNITS: Final = {"V": 1e3, "s": 0.1, "S/m": 1e-6, "ohm": 1e6, "m": 1e-3, "C/m2": 1e-4, "A": 1e-3, "F": 1e-9}
"""Upper end of a slider that begins at 0, for the units whose declared ranges are wider than any experiment [SI]."""
