"""All equilibria of contact area, surface topography, load and attraction, stable or not, and their path over voltage."""

from electrovib.solve.equilibrium.of_scenario import Balance as Balance
from electrovib.solve.equilibrium.of_scenario import equilibrium as equilibrium
from electrovib.solve.equilibrium.states import Equilibrium as Equilibrium
from electrovib.solve.equilibrium.states import Hysteresis as Hysteresis
from electrovib.solve.equilibrium.states import hysteresis as hysteresis
