"""The controls of a page, made from declarations: one for each parameter, and choices that replace a whole part."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.state import PageState, scenario_of
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.quantity import quantity_of
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.levels import LEVELS, SWING, LevelledDrive
from electrovib.physics.force import ForceLaw
from electrovib.physics.material import Material
from electrovib.physics.material.library import materials
from electrovib.physics.perception import Perception, SkinCompliance
from electrovib.scenario.files import skins, sources_of_offer
from electrovib.view.style import pretty_quantity

if TYPE_CHECKING:
    from electrovib.core.model import Model
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


AS_GIVEN: Final = ""
"""The option that keeps the part of the scenario."""
DRY_AND_MOIST: Final = {
    "gabriel_1996/dry": "dry finger (gabriel_1996/dry)",
    "gabriel_1996/wet": "moist finger (gabriel_1996/wet)",
}
"""The same finger, dry and moist, as one source publishes both."""


@dataclass(frozen=True)
class Choice:
    """Alternatives for one part of a scenario, at a dotted path.

    `options` is the name of a model or material to what is shown for it; `AS_GIVEN` keeps the part of the
    scenario.
    """

    label: str
    path: str
    options: Mapping[str, str]

    def present(self, state: PageState, scenario: Scenario) -> str:
        """Return the name of what a page shows for this part; `AS_GIVEN` where the part was not replaced.

        A link may give the name of a model that is none of `options`.
        """
        owner = self.path.rpartition(".")[0]
        if not {self.path, f"{self.path}.model", owner} & set(state.changes):
            return AS_GIVEN
        if self.path in _FAMILIES:
            part = _part(scenario, self.path)
            return AS_GIVEN if part is None else type(part).__name__
        return state.changes.get(self.path, AS_GIVEN)


def choices(scenario: Scenario) -> list[Choice]:
    """Return what can be chosen for a scenario, as it is without any change.

    Drive, force law, the material of skin and insulator where the stack has these layers, and the lateral
    compliance of the skin, with which perception computes displacements. An alternative that does not fit the
    rest of the scenario is refused with a sentence when it is chosen.
    """

    def given(part: Any, options: Mapping[str, str]) -> dict[str, str]:
        return {AS_GIVEN: f"{type(part).__name__}, as in the scenario", **options}

    found = [
        Choice("Drive", "drive", given(scenario.drive, {name: name for name in _drives()})),
        Choice("Force law", "force", given(scenario.force, {name: name for name in find_members(ForceLaw)})),
    ]
    layers = scenario.stack.layers
    if "stratum_corneum" in layers:
        others = {name: name for name in skins() if name not in DRY_AND_MOIST}
        options = given(layers["stratum_corneum"].material, DRY_AND_MOIST | others)
        found.append(Choice("Skin", "stack.stratum_corneum.material", options))
    if "insulator" in layers:
        library = {each.name: each.name.replace("_", " ") for each in materials()}
        options = given(layers["insulator"].material, library)
        found.append(Choice("Insulator", "stack.insulator.material", options))
    models: Any = find_members(_FAMILIES[_COMPLIANCE])
    options = given(
        present := _part(scenario, _COMPLIANCE),
        {each: f"{each}, begins with example values" for each in models},
    )
    if present is None:
        options[AS_GIVEN] = "none" if scenario.finger is None else "that of the finger of the scenario"
    return [*found, Choice("Compliance of the skin (perception)", _COMPLIANCE, options)]


def chosen(state: PageState, choice: Choice, name: str, own: Mapping[str, Scenario]) -> PageState:
    """Return the state in which a part is replaced, with the parameters that still apply.

    A drive keeps highest and lowest voltage, frequency and what else both drives have; a force law the
    parameters that both laws have; a compliance begins with example values; a material or skin keeps what was
    changed and what its source does not state.
    """
    if name == AS_GIVEN:
        return state.reset(choice.path)
    if choice.path not in _FAMILIES:
        return _with_material(state, choice.path, name, own)
    try:
        scenario = scenario_of(state, own=own)
    except InputError:  # of another choice, which this one may mend
        scenario = scenario_of(state.reset(), own=own)
    present = _part(scenario, choice.path)
    kind: Any = find_members(_FAMILIES[choice.path])[name]
    if choice.path == "drive":
        limit = getattr(scenario.limits, kind.quantity, None)
        return state.changed("drive", inline(name, carried_drive(kind, present, limit=limit)))
    plain = {key: value for key, value in kind.example.items() if isinstance(value, (int, float))}
    return state.changed(choice.path, inline(name, plain | (carried(kind, present) if present else {})))


def _with_material(state: PageState, path: str, name: str, own: Mapping[str, Scenario]) -> PageState:
    """Replace a material; changes of parameters that its source does not state are kept where the new material has them."""
    found = state.changed(path, name)
    stated = sources_of_offer(path, Material, name)
    for inner, text in state.changes.items():
        if not inner.startswith(f"{path}.") or inner in stated:
            continue
        trial = found.changed(inner, text)
        try:
            scenario_of(trial, own=own)
        except InputError:
            continue
        found = trial
    return found


_COMPLIANCE: Final = "perception.compliance"
_FAMILIES: Final[Mapping[str, Any]] = {"drive": Drive, "force": ForceLaw, _COMPLIANCE: SkinCompliance}
"""Paths whose alternatives are the models of a family."""


def _part(scenario: Scenario, path: str) -> Any:
    """Return the model at a path; None where the scenario declares none."""
    found: Any = scenario
    for name in path.split("."):
        found = getattr(found, name, None)
    return found


def _drives() -> list[str]:
    """Return the names of the drives whose example has numbers alone; drives of samples or other drives are left out."""
    return [
        name
        for name, kind in find_members(Drive).items()  # type: ignore[type-abstract]  # a family is abstract
        if kind.example and all(isinstance(value, (int, float)) for value in kind.example.values())
    ]


def inline(name: str, parameters: Mapping[str, Any]) -> str:
    """Write a model as the inline table that a change takes: ``{ model = "Sine", amplitude = 100 }``."""
    items = [f'model = "{name}"', *(f"{key} = {_number(value)}" for key, value in parameters.items())]
    return "{ " + ", ".join(items) + " }"


def _number(value: Any) -> str:
    """Write a number as short as it is read again without a difference; anything else as TOML."""
    is_short = isinstance(value, float) and float(f"{value:.12g}") == value
    return f"{value:.12g}" if is_short else json.dumps(value)


_PRESCRIBED: Final = {"voltage": "V", "current": "A"}
"""Unit of what a drive prescribes."""


def carried(kind: type[Model], present: Model) -> dict[str, float]:
    """Return the values of a model that another model takes: those of the same name and unit, within its ranges.

    Parameters of parts of `present` count where no other parameter has their name.
    """
    known: dict[str, tuple[float, str]] = {}
    for path, value, quantity in sorted(present.parameters(), key=lambda each: each[0].count(".")):
        if value is not None:
            known.setdefault(path.rpartition(".")[2], (value, quantity.unit))
    found = {}
    for name in kind.model_fields:
        declared = quantity_of(kind, name)
        if declared is None or name not in known:
            continue
        value, unit = known[name]
        if unit == declared.unit and declared.low <= value <= declared.high:
            found[name] = value
    return found


def carried_drive(kind: type[Drive], present: Drive, *, limit: float | None = None) -> dict[str, Any]:
    """Return the parameters with which a drive of a kind replaces another one.

    They are the example of `kind`, with the highest and lowest voltage (or current), the frequency and every
    other parameter that both drives have. What does not fit the rest is left at the example. A drive that
    would exceed the `limit`, the largest magnitude that the set-up allows for what `kind` prescribes [V or
    A], and the present one, is reduced to the limit.
    """
    table, largest = dict(kind.example), 0.0
    if kind.quantity == present.quantity:
        largest = present.largest()
        table = _if_valid(kind, _with_levels(kind, table, *_levels(present)), table)
    table = _if_valid(kind, table | _others(kind, present), table)
    drive = read_model(kind, table)
    if limit is not None and drive.largest() > (allowed := max(limit, largest)):
        part = allowed / drive.largest()
        drive = read_model(kind, _with_levels(kind, table, *(part * each for each in _levels(drive))))
    stored = drive.to_dict()
    return {name: stored[name] for name in kind.model_fields if stored.get(name) is not None}


def _levels(drive: Drive) -> tuple[float, float]:
    """Return the high and the low level of a drive; those of a step are its level and 0."""
    if isinstance(drive, LevelledDrive):
        return drive.high, drive.low
    low, high = drive.extremes()
    return (high, low) if low < high else (max(high, 0.0), min(low, 0.0))


def _level_names(kind: type[Drive]) -> tuple[str, ...]:
    """Return the parameters of a drive by which its levels are given: as two of two pairs, as one, or none of these."""
    if issubclass(kind, LevelledDrive):
        return (*SWING, *LEVELS)
    unit = _PRESCRIBED[kind.quantity]
    found = [name for name in kind.model_fields if (each := quantity_of(kind, name)) and each.unit == unit]
    return tuple(found) if len(found) == 1 else ()


def _with_levels(kind: type[Drive], table: Mapping[str, Any], high: float, low: float) -> dict[str, Any]:
    """Return a table with other levels; the table itself where the drive has no levels."""
    names = _level_names(kind)
    rest = {name: value for name, value in table.items() if name not in names}
    if len(names) < len(LEVELS):
        return rest | dict.fromkeys(names, max(high, low, key=abs))
    if SWING[0] in kind.model_fields:  # its amplitude is positive
        high, low = max(high, low), min(high, low)
    return rest | dict(zip(LEVELS, (high, low), strict=True))


def _others(kind: type[Drive], present: Drive) -> dict[str, float]:
    """Return the parameters of the present drive that are not levels, and its frequency where only its period is known."""
    levels = _level_names(kind)
    found = {name: value for name, value in carried(kind, present).items() if name not in levels}
    if "frequency" in kind.model_fields and quantity_of(kind, "frequency") and present.period:
        found.setdefault("frequency", 1 / present.period)
    return found


def _if_valid(kind: type[Drive], wanted: dict[str, Any], otherwise: dict[str, Any]) -> dict[str, Any]:
    try:
        read_model(kind, dict(wanted))
    except InputError:
        return otherwise
    return wanted
