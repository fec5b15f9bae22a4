"""T. Nakamura, A. Yamamoto, "Modeling and control of electroadhesion force in DC voltage", ROBOMECH Journal 4, 2017.

Claims: between two surface-insulated plates under a constant voltage the force rises or falls with time, depending on
the insulators; the rise is the classic Johnsen-Rahbek effect, and the same electrics explain the fall; a spring and a
damper explain the small initial force; the inverse of the model makes the force follow pulses; surface charge has to
be neutralised for a response to repeat. Does not claim: in the abstract, which alone was read, a resistivity, a
thickness, a spring constant.

The electrics are two leaky layers in series: V = E_d d + E_g g, and the charge between them grows by the difference of
their current densities. The voltage of the gap begins at V C_d/(C_d + C_g) and ends at V G_d/(G_d + G_g), with one time
constant (C_d + C_g)/(G_d + G_g), so that it rises if and only if rho_g > eps_d rho_d. With a third layer that blocks,
such as the film of Vezzoli et al. 2014, the gap's field always ends at 0, whatever its beginning. The mechanical part
is not computed.
"""

from __future__ import annotations

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

VOLTAGE, AREA = 100.0, 1e-4
THICKNESS, PERMITTIVITY, RESISTIVITY = 200e-6, 1650.0, 5.6e5
"""Thickness, permittivity and resistivity of the leaky dielectric, here a stratum corneum, a choice [m, 1, ohm m]."""
GAP = 3e-6
RISING = 1e12
"""Resistivity of the gap above eps_d rho_d, a choice [ohm m]."""


def rises(*, permittivity: float, resistivity: float, gap_resistivity: float) -> bool:
    """Return whether the gap's field rises under a constant voltage: rho_g > eps_d rho_d.

    This is the rise between two layers; with a third layer that blocks, the field ends at 0.
    """
    return gap_resistivity > permittivity * resistivity


def interface_charge(*, gap_resistivity: float) -> float:
    """Compute the charge per area [C/m2] that a constant voltage accumulates between gap and dielectric.

    It is D_d - D_g on the gap's face towards the finger, negative where the gap conducts less.
    """
    current_density = VOLTAGE / (THICKNESS * RESISTIVITY + GAP * gap_resistivity)
    return eps0 * current_density * (PERMITTIVITY * RESISTIVITY - gap_resistivity)


def pressures(name: str) -> tuple[float, float]:
    """Return the attraction per area just after the voltage is switched on, and long after [Pa]."""
    from electrovib.solve.simulate import simulate

    trace = simulate(scenarios()[name], time=np.array([0.0, 10.0]))
    first, last = (trace.electrostatic_force.values / AREA).tolist()
    return first, last


def time_constant(name: str) -> float:
    """Return the time constant of a scenario of two layers [s]."""
    from electrovib.solve.stack.expand import modes

    section, _ = modes(scenarios()[name])
    return 1 / float(section.modes.rates[0])


CHECKS = PAPER.checks(pressures, time_constant)
