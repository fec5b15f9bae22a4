"""The layers of a scenario that block a constant voltage, with a gap under a load: plates in series."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario


class BlockingStack(NamedTuple):
    """The layers that block a constant voltage, with a gap under a load, all as in `Balance`.

    `filling` is the relative permittivity of the gap.
    """

    pressure: float
    area: float
    filling: float
    electrical_thickness: float
    blocking: tuple[str, ...]

    def capacitance(self, gap: ArrayLike) -> float:
        """Return the capacitance [F] of plates in series at each place, for gaps [m] that have equal parts of the area."""
        inverse = np.mean(1 / (np.asarray(gap, dtype=float) + self.electrical_thickness))
        return float(eps0 * self.filling * self.area * inverse)


def blocking_stack(scenario: Scenario) -> BlockingStack:
    """Return across what a constant voltage is held, as `equilibrium` explains."""
    gap, area = _gap(scenario), scenario.contact_area
    parts, filling = blocking_parts(scenario, area), _permittivity(gap, scenario)
    return BlockingStack(
        pressure=scenario.load.normal_force / area,
        area=area,
        filling=filling,
        electrical_thickness=filling * sum(parts.values()),
        blocking=tuple(parts),
    )


def blocking_thickness(scenario: Scenario) -> Any:
    """Return the electrical thickness of the layers that block, times the permittivity of a gap, or a column of it [m].

    None where no layer blocks.
    """
    gap, layers = scenario.stack.gap_name, scenario.stack.layers
    blocking = [layer for name, layer in layers.items() if name != gap and _blocks(layer)]
    filling = _permittivity(layers[gap], scenario) if gap else 1.0
    parts = [layer.thickness / _permittivity(layer, scenario) for layer in blocking]
    return filling * sum(parts) if parts else None


def uniform_stack(scenario: Scenario) -> BlockingStack:
    """Return the same where area and voltage are the same for every contact, as one period of a roughness needs them."""
    if scenario.contact.grows:
        raise InputError(
            f"contact: {type(scenario.contact).__name__} grows with the force, but one period of the roughness has a mean"
            ' pressure; give contact = { model = "FixedArea", area = ... }'
        )
    stack = blocking_stack(scenario)
    if "return_path" in stack.blocking:
        raise InputError(
            "circuit.return_path: a floating body takes a share of the voltage that depends on the whole contact; give the"
            ' voltage between plate and skin, with return_path = { model = "Grounded" }'
        )
    return stack


def _gap(scenario: Scenario) -> Layer:
    layers = scenario.stack.layers
    name = scenario.stack.gap_name
    if name is None:
        raise InputError(
            "stack: there is no gap whose thickness could be computed; add [stack.gap] with any thickness, for instance '1 um'"
        )
    charged = [name for name, layer in layers.items() if layer.initial_charge]
    if charged:
        raise InputError(
            f"stack.{charged[0]}.initial_charge: the equilibrium does not include charge on the layers; set it to 0"
        )
    if not _blocks(layers[name]):
        raise InputError(
            f"stack.{name} conducts: under a constant voltage its field, and the attraction, vanish once charge has crossed."
            " Set material.conductivity = 0 without a leak, or use `simulate` for the time before"
        )
    if scenario.circuit.return_path.second_contact(1.0):
        raise InputError(
            "circuit.return_path: a second electrode has a gap of its own; equilibrium takes one contact, for instance"
            ' return_path = { model = "Grounded" }'
        )
    return layers[name]


def _blocks(layer: Layer) -> bool:
    return (
        bool(np.all(layer.material.conductivity == 0)) and layer.leak is None
    )  # or a column of many fingers


def _permittivity(layer: Layer, scenario: Scenario) -> Any:
    return np.real(layer.material.bound_permittivity(np.asarray(scenario.frequency.low)))[()]


def blocking_parts(scenario: Scenario, area: float) -> dict[str, float]:
    """Return the thickness over permittivity of all blocking parts except the gap [m]."""
    parts = {
        name: layer.thickness / _permittivity(layer, scenario)
        for name, layer in scenario.stack.layers.items()
        if name != scenario.stack.gap_name and _blocks(layer)
    }
    if not parts:
        raise InputError(
            "stack: no layer blocks besides the gap, so the attraction of a closing gap has no bound; equilibrium needs a"
            " layer with conductivity 0 and without a leak, for instance stack.insulator"
        )
    element = scenario.circuit.element()
    if element.elastance > 0 and element.rate == 0:
        parts["return_path"] = eps0 * area * element.elastance
    return parts
