"""Studies of a population in closed form."""

from __future__ import annotations

import functools

import pytest
from stand_in_population import SPACE, StandInPopulation, stand_in

from electrovib.study.population import study


@pytest.fixture
def quick(monkeypatch):
    """A study whose fingers cost nothing; another seed, number or statistic can be given."""
    monkeypatch.setattr("electrovib.solve.population.population", stand_in)
    monkeypatch.setattr(StandInPopulation, "kernel", "stand-in")
    return functools.partial(study, "vezzoli_2014/fig6", SPACE, seed=3)


@pytest.fixture
def tiles(monkeypatch):
    """Set the number of fingers of every tile."""

    def fix(size):
        monkeypatch.setattr(
            "electrovib.study.population.tiles.TileSizes.measured",
            lambda self, *_: setattr(self, "wanted", size),
        )
        monkeypatch.setattr("electrovib.study.population.tiles._FIRST", size)

    return fix
