"""Equilibria under the attraction of parallel plates."""

from electrovib.physics.contact.attraction import PlateAttraction
from electrovib.solve.equilibrium.states import balance


def equilibria(*, surface, pressure, voltage, electrical_thickness):
    """Return all states with repulsion(g) = pressure + eps0 V^2/(2 (K + g)^2)."""
    attraction = PlateAttraction(voltage, electrical_thickness)
    return balance(surface, attraction, pressure=pressure)
