"""Spaces of parameters: probability distributions of the values of a scenario, for studies of many fingers.

A draw is a function of seed, path and index: the index counts in a Philox generator whose key is made of the seed and the
path. Hence a chunk, a worker or one more parameter changes no draw; one that breaks a relation is repeated from its own
index.
"""

from electrovib.scenario.space.reading import SpaceSource, read_space
from electrovib.scenario.space.relations import Group, Grouping
from electrovib.scenario.space.space import Space
from electrovib.scenario.space.writing import Origin

__all__ = ["Group", "Grouping", "Origin", "Space", "SpaceSource", "read_space"]
