"""Signals of a Trace over frequency: gains, impedance, permittivities and the mean force of a sine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.scenario import Scenario
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import behind_amplifier, per_volt_of
from electrovib.solve.stack.section import PhasorSection

if TYPE_CHECKING:
    pass


def over_frequency(scenario: Scenario, section: PhasorSection) -> dict[str, Any]:
    """Compute the signals over frequency."""
    area = scenario.contact_area
    plate = per_volt_of(scenario, section.frequency)
    per_volt = behind_amplifier(scenario, plate)
    section = behind_amplifier(scenario, section)
    variables: dict[str, Any] = {}
    effective = scenario.force.effective_voltage(per_volt)
    if effective is not None:
        variables["effective_voltage_gain"] = (("frequency",), effective)
    layers = per_volt.layers.values()
    gains = np.array([state.field * state.thickness for state in layers])
    permittivities = np.array([state.material.complex_permittivity(section.frequency) for state in layers])
    variables["field_gain"] = (("layer", "frequency"), gains)
    variables["mean_force"] = (
        ("frequency",),
        mean_force(scenario, section, amplitude=scenario.drive.largest()),
    )
    variables["impedance"] = (("frequency",), 1 / (plate.current_density * area))
    variables["permittivity"] = (("layer", "frequency"), permittivities)
    return variables
