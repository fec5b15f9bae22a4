"""Spaces of parameters: probability distributions of the values of a scenario, for studies of many fingers."""

from electrovib.scenario.space.reading import SpaceSource, read_space
from electrovib.scenario.space.relations import Group, Grouping
from electrovib.scenario.space.space import Space
from electrovib.scenario.space.writing import Origin

__all__ = ["Group", "Grouping", "Origin", "Space", "SpaceSource", "read_space"]
