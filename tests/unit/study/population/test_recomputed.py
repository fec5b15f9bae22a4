"""Percentiles of signals that are computed again: those of stored signals, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.scenario import load
from electrovib.solve.population.fingers import Population
from electrovib.study.population import open_study, study, tile
from electrovib.study.population.declared import read_study
from electrovib.study.population.run import StudyCancelledError
from electrovib.study.population.tile import Evaluator
from electrovib.study.population.worker import tile_on_worker

NAME = "electrostatic_force"
SCENARIO = load("vezzoli_2014/fig6_gap").replace({"time.samples": 150})
ASKED = {"n": 5000, "seed": 4}


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
    assert (evaluator(draws=True).kept, evaluator(draws=True).recomputed) == (True, False)
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


@pytest.fixture(scope="module")
def binned():
    """The study whose histogram counts stored signals."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Evaluator, "__init__", without_counting(Evaluator.__init__))
        return study(SCENARIO, "fingers", budget_memory="2.5 MB", **ASKED)


def without_counting(original):
    def made(self, *arguments, **options):
        original(self, *arguments, **options)
        self.counted = False

    return made


@pytest.mark.parametrize("size", [1024, 4096])
def test_histograms_are_those_of_stored_signals(tiles, binned, size):
    tiles(size)
    found = study(SCENARIO, "fingers", budget_memory="2.5 MB", **ASKED)
    assert "histogram" in found.attrs["percentiles_from"]
    assert_same(found, binned)


def test_blocks_that_are_not_known_are_counted_as_zero(monkeypatch, binned):
    """One finger is unknown: the bands are unknown, and its block is counted from stored signals."""
    original, squares = Population.signals, Population.squares
    one = evaluator(budget_memory="2.5 MB")
    path, value = next((path, values[0]) for path, values in one._draws(1030, 1031).items())

    def signals(self, draws, **asked):
        found = original(self, draws, **asked)
        found[NAME][draws[path] == value, 20] = np.nan
        return found

    def spoilt(self, draws, **asked):
        found = squares(self, draws, **asked)
        return found._replace(factor=np.where(draws[path] == value, np.nan, found.factor))

    monkeypatch.setattr(Population, "signals", signals)
    monkeypatch.setattr(Population, "squares", spoilt)
    reduced = one.tile(0, 5000).reduced[NAME]
    assert [isinstance(each, np.ndarray) for each in reduced.forms] == [False, True, False, False, False]
    counted = one.histogram_of(reduced.forms)
    assert counted.count == 5000
    assert (counted.quantiles([0.0])[0, 20] <= 0).all()
    assert (counted.quantiles([0.5])[0, 19] == binned[f"{NAME}_percentile"][1, 19]).all()


def test_a_worker_sends_a_histogram(binned):
    one = evaluator(budget_memory="2.5 MB")
    found = tile_on_worker(one.declared.to_text(), 0, 2048, {})
    (each,) = found.reduced.values()
    assert not each.forms
    assert each.histogram.count == 2048
    expected = one.histogram_of(one.forms(0, 2048))
    np.testing.assert_array_equal(each.histogram.quantiles([0.5]), expected.quantiles([0.5]))
