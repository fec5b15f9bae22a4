"""A Scenario in a notebook: its stack, its models, and its parameters with their sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.view import tables
from electrovib.view.pages import filled
from electrovib.view.plots.layers import values
from electrovib.view.style import layer_colours
from electrovib.view.units import pretty_quantity, typeset

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario

UNVERIFIED: Final = "unverified"
"""Word by which the source of a value, or the status of a model, states that nobody here has read the source."""


@dataclass(frozen=True, kw_only=True)
class ShownLayer:
    """One layer of the stack as it is drawn; its role is ``"plate"``, ``"gap"`` or ``"finger"``."""

    name: str
    thickness: str
    material: str
    role: str
    colour: str
    evaluated: bool


@dataclass(frozen=True, kw_only=True)
class ShownParameter:
    """One parameter that has a value; `default` marks the model's own, `unverified` a source that is marked so."""

    path: str
    value: str
    meaning: str
    source: str
    default: bool
    unverified: bool


def scenario_html(scenario: Scenario) -> str:
    """Write a scenario as HTML for a notebook."""
    parameters = parameters_of(scenario)
    models = tables.model_rows(scenario)
    back = scenario.circuit.return_path
    paths = {
        path: pretty_quantity(value, quantity.unit)
        for path, value, quantity in back.parameters()
        if value is not None
    }
    return filled(
        "notebook_scenario.html.jinja",
        title=f"Scenario: {scenario.title or 'without a title'}",
        layers=layers_of(scenario),
        return_path=", ".join([type(back).__name__, *(f"{path} {text}" for path, text in paths.items())]),
        models=[(row, _is_unverified(row.facts)) for row in models],
        given=[row for row in parameters if not row.default],
        defaults=[row for row in parameters if row.default],
        unverified=sum(row.unverified for row in parameters)
        + sum(_is_unverified(row.facts) for row in models),
    )


def layers_of(scenario: Scenario) -> list[ShownLayer]:
    """List the layers from the finger, which is drawn on top, down to the plate."""
    stack = scenario.stack
    colours, roles = layer_colours([*stack.layers]), stack.roles
    found = [
        ShownLayer(
            name=name.replace("_", " "),
            thickness=pretty_quantity(layer.thickness, "m"),
            material=_material(layer, scenario),
            role=roles[name],
            colour=colours[name],
            evaluated=scenario.force.evaluation_surface == name,
        )
        for name, layer in stack.layers.items()
    ]
    return found[::-1]


def _material(layer: Layer, scenario: Scenario) -> str:
    """Write model, substance and values of a layer."""
    text = f"{type(layer.material).__name__}: {values(layer, scenario)}"
    substance = layer.material.substance
    return f"{substance}, {text}" if substance and substance not in text else text


def parameters_of(scenario: Scenario) -> list[ShownParameter]:
    """List the physical parameters that have a value, in the order of the file."""
    found = []
    for path, value, quantity in scenario.parameters():
        if value is None:
            continue
        source = tables.source_of(scenario, path, value=value)
        default = source == tables.DEFAULT
        if default and quantity.source:
            source = f"{source}: {quantity.source}"
        found.append(
            ShownParameter(
                path=path,
                value=pretty_quantity(value, quantity.unit),
                meaning=quantity.doc,
                source=typeset(source),
                default=default,
                unverified=_is_unverified([source]),
            )
        )
    return found


def _is_unverified(texts: Iterable[Any]) -> bool:
    return any(UNVERIFIED in str(text) for text in texts)
