"""Signals of many fingers: one scenario with other values of a few parameters for each finger."""

from electrovib.solve.population.fingers import Population, population

__all__ = ["Population", "population"]
