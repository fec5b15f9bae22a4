"""Scenarios that differ in the material of one layer of the plate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import InputError, Problem, nearest
from electrovib.physics.material import Material
from electrovib.physics.material.library import find_substance

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.scenario import Scenario


def layer_of(scenario: Scenario, layer: str) -> str:
    """Find the layer whose material is varied: the only one of the plate if no name is given."""
    known = scenario.stack.layers
    plate = [name for name, role in scenario.stack.roles.items() if role == "plate"]
    if layer and layer not in known:
        raise InputError(f"layer '{layer}': the stack has none of this name.{nearest(layer, known)}")
    if not layer and len(plate) != 1:
        raise InputError(
            f"layer: the plate has {len(plate)} layers; name the one whose material is varied, of {', '.join(known)}"
        )
    return layer or plate[0]


def members_of(scenario: Scenario, layer: str, materials: Sequence[str]) -> dict[str, Scenario]:
    """Return the scenario with each material in a layer, without the breakdown field that belongs to its own material."""
    problems: list[str | Problem] = []
    found: dict[str, Scenario] = {}
    for text in materials:
        name = " ".join(text.split())
        try:
            Material.offer(name)
        except InputError as error:
            problems += error.problems
            continue
        shown = getattr(find_substance(name), "name", name)
        if shown in found:
            problems.append(f"materials: '{name}' is named twice")
            continue
        changes: dict[str, str | None] = {f"stack.{layer}.material": name}
        if scenario.stack.layers[layer].breakdown_field is not None:
            changes |= {f"stack.{layer}.breakdown_field": None}
        found[shown] = scenario.replace(changes)
    if problems:
        raise InputError(problems)
    return found
