"""The wanted quantities of a stack: everything in a result that is linear in the drive, by key."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.constants import eps0
from electrovib.physics.interface import INTERFACE
from electrovib.scenario import PeriodicState
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.integrator import drive_mean, integral_weight
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key


def linear_quantities(scenario: Scenario, section: Any) -> dict[Key, Any]:
    """Return everything in a result that is linear in the drive."""
    found = fields(scenario, section)
    if not scenario.force.causal:
        return found
    effective = scenario.force.effective_voltage(section)
    if effective is not None:
        found["effective_voltage"] = effective
    return found | amplitudes(scenario, section)


def amplitudes(scenario: Scenario, section: Any) -> dict[Key, Any]:
    """Return the arguments of the law's pressure."""
    return {AmplitudeOf(name): value for name, value in scenario.force.amplitudes(section).items()}


def fields(scenario: Scenario, section: Any) -> dict[Key, Any]:
    """Return voltage, current, fields and displacements, without quantities of the law."""
    wanted: dict[Key, Any] = {
        "stack_voltage": section.voltage,
        "current": section.current_density * Surroundings.of(scenario).area,
    }
    for name in section.names:
        wanted[FieldOf(name)] = section[name].field
        wanted[DisplacementOf(name)] = section[name].displacement
    if scenario.stack.gap_name is None:
        displacement = section.interface_displacement
        if not (isinstance(displacement, Transfer) and _grown_without_end(scenario, displacement)):
            wanted[FieldOf(INTERFACE)] = displacement * (1 / eps0)
    return wanted


def _grown_without_end(scenario: Scenario, displacement: Transfer) -> bool:
    """Return whether the interface charge is unbounded: a mean voltage over conducting layers in the periodic state."""
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    return settled and bool(integral_weight(displacement)) and bool(drive_mean(scenario.drive))


def name_interface(scenario: Scenario, found: dict[Key, Real]) -> None:
    """Store the field at the interface under the name of its signal, where it was computed."""
    name = FieldOf(scenario.stack.gap_name or INTERFACE)
    if name in found:
        found["interface_field"] = found[name]
