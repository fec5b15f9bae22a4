"""Changes that moisture makes to a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.interface import beside_interface

if TYPE_CHECKING:
    from collections.abc import Collection

    from electrovib.physics.moisture import Moisture
    from electrovib.scenario.experiment import Scenario


def moistened(scenario: Scenario, moisture: Moisture) -> dict[str, float]:
    """Return the changes that bring a scenario to a moisture, for `Scenario.replace`; only of parameters that it has."""
    layers, found = scenario.stack.layers, {}
    known = {path for path, _, _ in scenario.parameters()}
    skin, gap = _skin(scenario), scenario.stack.gap_name
    if skin is not None:
        conductivity = moisture.skin_conductivity(layers[skin].thickness)
        found[f"stack.{skin}.material.conductivity"] = conductivity
    for name in ("conductivity", "spot_conductivity") if gap else ():
        found[f"stack.{gap}.material.{name}"] = 1 / moisture.gap_resistivity()
    for where in ("friction", "friction.steady"):
        found[f"{where}.coefficient"] = moisture.coefficient()
    return {path: value for path, value in found.items() if path in known}


def _skin(scenario: Scenario) -> str | None:
    """Return the name of the layer that moisture acts on: that of the finger at the interface."""
    return beside_interface(scenario.stack.roles, "finger")


def moisture_diagnostic(scenario: Scenario) -> Diagnostic | None:
    """List the values that moisture has set, in place of those in the tables, and what has no value to set."""
    if scenario.moisture is None:
        return None
    units = {path: quantity.unit for path, _, quantity in scenario.parameters()}
    moved = moistened(scenario, scenario.moisture)
    shown = ", ".join(f"{path} = {format_quantity(value, units[path])}" for path, value in moved.items())
    text = f"moisture.level = {scenario.moisture.level:g} sets {shown or 'nothing'}"
    skin, gap = (f"stack.{name}." for name in (_skin(scenario), scenario.stack.gap_name))
    starts = {skin: "the skin", gap: "the gap", "friction": "friction"}
    idle = [name for start, name in starts.items() if not any(path.startswith(start) for path in moved)]
    if idle:
        text += f"; this scenario has no parameter of {' and '.join(idle)} that moisture sets"
    return Diagnostic("moisture", "warning" if idle else "ok", text)


def refuse_what_moisture_sets(scenario: Scenario, changes: Collection[str]) -> None:
    """Refuse changes that moisture would undo."""
    moisture = scenario.moisture
    undone = [] if moisture is None else [path for path in moistened(scenario, moisture) if path in changes]
    if undone:
        raise InputError(
            f"{path}: is set by moisture. Change moisture.level or its dry and wet values, or omit the table [moisture]"
            for path in undone
        )
