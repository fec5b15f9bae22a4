"""Choices that replace a whole part of a scenario: the drive, the force law, the finger's skin, the insulator."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.discovery import find_members
from electrovib.physics.drive.base import Drive
from electrovib.physics.force import ForceLaw
from electrovib.physics.material.library import materials
from electrovib.scenario.offers import skins

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
    """Alternatives for one part of a scenario.

    Parameters
    ----------
    label : str
        On the page.
    path : str
        Dotted path that is set.
    options : mapping of str to str
        Value to what is shown for it; the value `AS_GIVEN` keeps the part of the scenario.
    """

    label: str
    path: str
    options: Mapping[str, str]


def choices(scenario: Scenario) -> list[Choice]:
    """Return what can be chosen for a scenario.

    Parameters
    ----------
    scenario : Scenario
        Its layers decide which materials can be chosen.

    Returns
    -------
    choices : list of Choice
        Drive, force law, and the material of skin and insulator where the stack has these layers. An alternative that
        does not fit the rest of the scenario is refused with a sentence when it is chosen.
    """
    found = [
        Choice("Drive", "drive", {AS_GIVEN: "as in the scenario"} | _drives()),
        Choice(
            "Force law",
            "force.model",
            {AS_GIVEN: "as in the scenario"} | {name: name for name in find_members(ForceLaw)},
        ),
    ]
    layers = scenario.stack.layers
    if "stratum_corneum" in layers:
        others = {name: name for name in skins() if name not in DRY_AND_MOIST}
        options = {AS_GIVEN: "as in the scenario"} | DRY_AND_MOIST | others
        found.append(Choice("Skin", "stack.stratum_corneum.material", options))
    if "insulator" in layers:
        library = {each.name: each.name.replace("_", " ") for each in materials()}
        found.append(
            Choice("Insulator", "stack.insulator.material", {AS_GIVEN: "as in the scenario"} | library)
        )
    return found


def _drives() -> dict[str, str]:
    """Return each drive with its example as an inline table; drives that hold samples or other drives are left out."""
    return {
        inline(name, kind.example): name
        for name, kind in find_members(Drive).items()  # type: ignore[type-abstract]  # a family is abstract
        if kind.example and all(isinstance(value, (int, float)) for value in kind.example.values())
    }


def inline(name: str, parameters: Mapping[str, Any]) -> str:
    """Write a model as the inline table that a change takes: ``{ model = "Sine", amplitude = 100 }``."""
    items = [f'model = "{name}"', *(f"{key} = {json.dumps(value)}" for key, value in parameters.items())]
    return "{ " + ", ".join(items) + " }"
