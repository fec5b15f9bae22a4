"""Percentiles of signals that are computed again: those of stored signals, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.scenario import load
from electrovib.solve.population.fingers import Population
from electrovib.solve.population.kernels.choice import compiled
from electrovib.study.population import study, tile
from electrovib.study.population.declared import read_study
from electrovib.study.population.existing import open_study
from electrovib.study.population.run import StudyCancelledError
from electrovib.study.population.tile import Evaluator

NAME = "electrostatic_force"
SCENARIO = load("vezzoli_2014/fig6_gap").replace({"time.samples": 150})
ASKED = {"n": 5000, "seed": 4}
pytestmark = pytest.mark.skipif(compiled() is None, reason="the numpy kernels store the signals")


def evaluator(**changed):
    asked = {"signal": NAME, "percentiles": (5,), "exceed": (), "draws": False, "budget_memory": "1 GB"}
    return Evaluator(read_study(SCENARIO, "fingers", **ASKED, **(asked | changed)))


@pytest.fixture(scope="module")
def stored():
    """The study whose signals are stored."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tile, "_FEWEST_SAMPLES", 1000)
        return study(SCENARIO, "fingers", exceed="0.3 mN", **ASKED)


def assert_same(found, expected):
    assert set(found.data_vars) == set(expected.data_vars)
    for name in found.data_vars:
        assert found[name].values.tobytes() == expected[name].values.tobytes(), name


def test_signals_are_computed_again_where_that_takes_less_memory(monkeypatch):
    one = evaluator()
    assert one.recomputed
    assert not one.kept
    assert evaluator(draws=True).kept
    assert evaluator(budget_memory="2 MB").binned
    assert evaluator(signal=(NAME, "stack_voltage")).kept
    monkeypatch.setattr(tile, "_FEWEST_SAMPLES", 151)
    assert evaluator().kept


@pytest.mark.parametrize("size", [1024, 4096])
def test_percentiles_are_those_of_stored_signals(tiles, stored, size):
    tiles(size)
    assert_same(study(SCENARIO, "fingers", exceed="0.3 mN", **ASKED), stored)


def test_blocks_of_another_form_are_stored(monkeypatch, stored):
    original, seen = Population.squares, []

    def squares(self, draws, **asked):
        seen.append(next(iter(draws.values()))[0])
        return None if seen[-1] == second else original(self, draws, **asked)

    one = evaluator()
    second = next(iter(one._draws(1024, 1025).values()))[0]
    monkeypatch.setattr(Population, "squares", squares)
    found = study(SCENARIO, "fingers", exceed="0.3 mN", **ASKED)
    assert second in seen
    name = f"{NAME}_percentile"
    np.testing.assert_array_equal(found[name], stored[name])
    assert isinstance(one.forms(1024, 2048)[0], np.ndarray)
    monkeypatch.setattr(Population, "squares", lambda *_, **__: None)
    np.testing.assert_array_equal(study(SCENARIO, "fingers", **ASKED)[name], stored[name])


def test_a_study_that_was_ended_continues_without_stored_signals(tmp_path, tiles, stored):
    tiles(1024)
    path = tmp_path / "study.zarr"
    with pytest.raises(StudyCancelledError):
        study(
            SCENARIO,
            "fingers",
            exceed="0.3 mN",
            output=path,
            progress=lambda done, _: done > 2000,
            **ASKED,
        )
    assert not (path / "checkpoint" / NAME).exists()
    study(SCENARIO, "fingers", exceed="0.3 mN", output=path, **ASKED)
    assert_same(open_study(path), stored)
