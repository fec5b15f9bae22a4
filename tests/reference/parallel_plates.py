"""Equilibria under the attraction of parallel plates."""

import math

from electrovib.core.constants import eps0
from electrovib.physics.contact.attraction import PlateAttraction
from electrovib.solve.equilibrium.states import balance


def equilibria(*, surface, pressure, voltage, electrical_thickness):
    """Return all states with repulsion(g) = pressure + eps0 V^2/(2 (K + g)^2)."""
    attraction = PlateAttraction(voltage, electrical_thickness)
    return balance(surface, attraction, pressure=pressure)


def pull_in_voltage(*, stiffness, free_gap, electrical_thickness, pressure=0.0):
    """Return the voltage at which a spring snaps in, V^2 = 8 k (K + g0)^3/(27 eps0); None where it closes continuously."""
    left = free_gap - pressure / stiffness
    if left <= electrical_thickness / 2:
        return None
    return math.sqrt(8 * stiffness * (electrical_thickness + left) ** 3 / (27 * eps0))
