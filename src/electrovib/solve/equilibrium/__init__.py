"""All equilibria of contact area, surface topography, load and attraction, stable or not, and their path over voltage."""

from electrovib.physics.contact.surface import pull_in_voltage
from electrovib.solve.equilibrium.of_scenario import Balance, equilibrium
from electrovib.solve.equilibrium.states import (
    Equilibrium,
    Hysteresis,
    Path,
    balance,
    equilibria,
    follow,
    hysteresis,
)

__all__ = [
    "Balance",
    "Equilibrium",
    "Hysteresis",
    "Path",
    "balance",
    "equilibria",
    "equilibrium",
    "follow",
    "hysteresis",
    "pull_in_voltage",
]
