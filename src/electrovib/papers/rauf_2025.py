"""A. M. Rauf, S. Follmer, "Modeling the dynamics of sub-millisecond electroadhesive engagement and release", 2025.

Extreme Mechanics Letters 79, 102382: a clutch of interdigitated electrodes on a metal, not a finger.

Claims: engagement and release as squeeze film, contact mechanics, polarisation of the dielectric and rise and
fall of the drive together; in earlier clutches both are far slower than electrostatics alone predicts, and
higher drive frequencies, narrower substrates and faster drives shorten the release; engagement below 15 us, release
below 875 us. The pull takes the air gap into account and agrees with field calculations from 10 nm to 10 um.
Does not claim: fringe fields of the electrodes, anything on skin. An exponent of the voltage is not taken from the measured
means: these belong to sessions with other loads, and it is 2 to 3 by the load. The
clutches and pads of others that the authors' script quotes are declared here too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.papers import published
from electrovib.scenario import Scenario
from electrovib.studies.evidence.quantities import takes_columns

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios, materials = PAPER.scenarios, PAPER.materials

THICKNESS, VOLTAGE = 24e-6, 300.0
AREA = 4 * 1.5e-3 * 2e-3
"""Area of all electrode fingers, half of them of each polarity [m2]."""


def clutch_force(
    *, voltage: float, gap: float, permittivity: float, thickness: float = THICKNESS, area: float = AREA
) -> float:
    """Compute the attraction [N] of interdigitated electrodes under a dielectric to a floating metal.

    eps0 k^2 V^2 A/(8 (d + k g)^2): the Maxwell stress in the gap with V/2, half of the voltage between
    neighbouring electrodes across each interface, without fringe fields. A is the area of the electrodes of
    both polarities.
    """
    return eps0 * (permittivity * voltage) ** 2 * area / (8 * (thickness + permittivity * gap) ** 2)


def stack_over_formula() -> float:
    """Return the force of the stack with two contacts over that of the formula, at 1 um and permittivity 50."""
    from electrovib.solve.simulate import simulate

    trace = simulate(scenarios()["field_50"], time=np.array([0.0, 1e-3]))
    return float(trace.electrostatic_force[-1]) / clutch_force(voltage=VOLTAGE, gap=1e-6, permittivity=50.0)


CHECKS = PAPER.checks(clutch_force, stack_over_formula)


@takes_columns
def capacitance(scenario: Scenario) -> Any:
    """Compute the capacitance [F] between the electrodes of both polarities, with the gap that the surface has under the load.

    `contact.area` is that of all electrodes; half of it is in series with the other half. Numbers may be columns.
    """
    layer, area = scenario.stack.layers["insulator"], scenario.contact_area
    frequency = np.atleast_1d(scenario.drive.frequency)  # type: ignore[attr-defined]
    permittivity = layer.material.complex_permittivity(frequency).real
    surface = scenario.contact.surface
    gap = surface.gap(np.asarray(scenario.load.normal_force / area))  # type: ignore[union-attr]
    return (eps0 * area / (layer.thickness / permittivity + gap) / 4)[..., 0]


def electric_part(scenario: Scenario) -> float:
    """Compute the friction [N] that the attraction adds in the state of the largest stable gap."""
    from electrovib.solve.equilibrium.of_scenario import states_of

    states, areas = states_of(scenario)
    stable = [state.attraction * area for state, area in zip(states, areas, strict=True) if state.stable]
    return float(scenario.friction.coefficient * stable[-1])  # type: ignore[attr-defined]


def shear_force(scenario: Scenario) -> float:
    """Compute the friction [N] of load and attraction, the film with its permittivity at the frequency of the drive."""
    film, frequency = scenario.stack.layers["insulator"], scenario.drive.frequency  # type: ignore[attr-defined]
    permittivity = float(film.material.complex_permittivity(frequency).real)
    held = scenario.replace({"stack.insulator.material": {"model": "Constant", "permittivity": permittivity}})
    before: float = scenario.friction.coefficient * scenario.load.normal_force  # type: ignore[attr-defined]
    return electric_part(held) + before


quantities = PAPER.quantities(electric_part, shear_force, capacitance)
