"""Studies of a population in closed form."""

import numpy as np
import pytest
from stand_in_population import SPACE, StandInPopulation, stand_in

from electrovib.core.deprecation import former_values
from electrovib.studies.population import StudyCancelledError, study


@pytest.fixture
def quick(monkeypatch):
    """A study whose fingers cost nothing; another seed, number, statistic, memory or progress can be given."""
    monkeypatch.setattr("electrovib.solve.population.Population", stand_in)
    monkeypatch.setattr(StandInPopulation, "kernel", "stand-in")

    def run(**asked):
        former = {name: asked.pop(name) for name in ("budget_memory", "progress") if name in asked}
        with former_values(**former):
            return study("vezzoli_2014/fig6", SPACE, **{"seed": 3} | asked)

    return run


@pytest.fixture
def ended(quick):
    """Begin a study at a path and end it after some fingers."""

    def end(path, after=1, **asked):
        with pytest.raises(StudyCancelledError, match="the same call continues"):
            quick(**{"n": 5000} | asked, output=path, progress=lambda done, _: done >= after)
        return path

    return end


@pytest.fixture
def tiles(monkeypatch):
    """Set the number of fingers of every tile."""

    def fix(size):
        sizes = "electrovib.studies.population.tiles"
        monkeypatch.setattr(f"{sizes}.TileSizes.measured", lambda self, *_: setattr(self, "wanted", size))
        monkeypatch.setattr(f"{sizes}._FIRST", size)

    return fix


@pytest.fixture
def content():
    """What stands in the files of a folder."""

    def read(folder):
        return {each.relative_to(folder): each.read_bytes() for each in folder.rglob("*") if each.is_file()}

    return read


@pytest.fixture
def same():
    """Compare the numbers of two results.

    Sums over fingers are formed tile by tile, so that means and variances differ by rounding; all else is counted or sorted.
    """

    def compare(one, other):
        assert set(one.variables) == set(other.variables)
        for name in one.variables:
            rtol = 1e-12 if name.endswith(("_mean", "_variance")) else 0.0
            np.testing.assert_allclose(one[name].values, other[name].values, rtol=rtol, err_msg=name)
            assert one[name].attrs == other[name].attrs

    return compare
