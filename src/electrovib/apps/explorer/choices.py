"""Choices that replace a whole part of a scenario: drive, force law, skin, insulator, compliance of the skin."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.apps.explorer.carried import carried, carried_drive
from electrovib.apps.explorer.state import PageState, scenario_of
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.material.library import materials
from electrovib.physics.perception import SkinCompliance
from electrovib.scenario.offers import skins, with_offers

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

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
    found = [
        Choice("Drive", "drive", _as_given(scenario.drive) | {name: name for name in _drives()}),
        Choice(
            "Force law", "force", _as_given(scenario.force) | {name: name for name in find_members(ForceLaw)}
        ),
    ]
    layers = scenario.stack.layers
    if "stratum_corneum" in layers:
        others = {name: name for name in skins() if name not in DRY_AND_MOIST}
        options = _as_given(layers["stratum_corneum"].material) | DRY_AND_MOIST | others
        found.append(Choice("Skin", "stack.stratum_corneum.material", options))
    if "insulator" in layers:
        library = {each.name: each.name.replace("_", " ") for each in materials()}
        given = _as_given(layers["insulator"].material)
        found.append(Choice("Insulator", "stack.insulator.material", given | library))
    found.append(Choice("Compliance of the skin (perception)", _COMPLIANCE, _compliances(scenario)))
    return found


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
    stated = with_offers({path: name})[1]
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


def _compliances(scenario: Scenario) -> dict[str, str]:
    """Return the models of the lateral compliance of the skin."""
    present = _part(scenario, _COMPLIANCE)
    if present is not None:
        given = _as_given(present)
    else:
        given = {AS_GIVEN: "none" if scenario.finger is None else "that of the finger of the scenario"}
    return given | {
        name: f"{name}, begins with example values" for name in find_members(_FAMILIES[_COMPLIANCE])
    }


def _as_given(part: Any) -> dict[str, str]:
    return {AS_GIVEN: f"{type(part).__name__}, as in the scenario"}


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
    return (
        f"{value:.12g}" if isinstance(value, float) and float(f"{value:.12g}") == value else json.dumps(value)
    )
