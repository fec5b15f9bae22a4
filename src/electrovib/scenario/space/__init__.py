"""Spaces of parameters: probability distributions of the values of a scenario, for studies of many fingers."""

from electrovib.scenario.space.groups import Group, Grouping
from electrovib.scenario.space.origin import Origin
from electrovib.scenario.space.reading import SpaceSource, read_space
from electrovib.scenario.space.space import Space

__all__ = ["Group", "Grouping", "Origin", "Space", "SpaceSource", "read_space"]
