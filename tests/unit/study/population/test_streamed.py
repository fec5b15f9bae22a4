"""Moments that are streamed and signals that are written as float32, compared with signals stored in float64."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.scenario import load
from electrovib.study.population import study
from electrovib.study.population.declared import read_study
from electrovib.study.population.tile import Evaluator

NAME = "electrostatic_force"
FINGERS = 2500


def evaluator(scenario="vezzoli_2014/fig6_gap", **asked):
    """Return the evaluator of a study of the real population."""
    scenario = load(scenario).replace({"time.samples": 40})
    asked = {
        "signal": NAME,
        "percentiles": (5, 95),
        "exceed": (),
        "draws": False,
        "budget_memory": "1 GB",
    } | asked
    return Evaluator(read_study(scenario, "fingers", n=FINGERS, seed=4, **asked), threads=1)


def stored(study_, start=0, stop=FINGERS):
    """Reduce fingers from signals that are stored in float64."""
    study_.streamed = False
    found = study_.reduced(start, stop)[NAME]
    study_.streamed = True
    return found


def assert_near(found, expected):
    """Compare moments with 1e-12 of the largest, and everything else bit for bit."""
    assert [each.fingers for each in found.blocks] == [each.fingers for each in expected.blocks]
    for one, other in zip(found.blocks, expected.blocks, strict=True):
        np.testing.assert_allclose(one.mean, other.mean, rtol=1e-12, atol=1e-12 * other.mean.max())
        np.testing.assert_allclose(one.squares, other.squares, rtol=1e-12, atol=1e-12 * other.squares.max())
    for name in ("above", "anywhere", "unknown"):
        np.testing.assert_array_equal(getattr(found.counts, name), getattr(expected.counts, name))
    if expected.values is None:
        assert found.values is None
    else:
        np.testing.assert_array_equal(found.values.view(np.int32), expected.values.view(np.int32))


@pytest.mark.parametrize("exceed", [(), "0.3 mN"])
@pytest.mark.parametrize("percentiles", [(5, 95), ()])
@pytest.mark.parametrize("scenario", ["vezzoli_2014/fig6", "vezzoli_2014/fig6_gap"])
def test_both_ways_agree(scenario, percentiles, exceed):
    one = evaluator(scenario, percentiles=percentiles, exceed=exceed)
    assert one.streamed
    found, expected = one.reduced(0, FINGERS)[NAME], stored(one)
    assert_near(found, expected)
    assert any(not np.array_equal(a.mean, b.mean) for a, b in zip(found.blocks, expected.blocks, strict=True))
    assert expected.counts.above.any() == bool(exceed)


def test_known_signals_do_not_change_the_moments():
    one = evaluator()
    signals = one._signals(one._draws(1024, FINGERS))
    found, expected = one.reduced(1024, FINGERS, signals=signals)[NAME], one.reduced(1024, FINGERS)[NAME]
    for a, b in zip(found.blocks, expected.blocks, strict=True):
        np.testing.assert_array_equal(a.mean, b.mean)
        np.testing.assert_array_equal(a.squares, b.squares)
    np.testing.assert_array_equal(found.values, expected.values)


def test_the_mean_depends_on_no_other_statistic():
    scenario = load("vezzoli_2014/fig6_gap").replace({"time.samples": 40})
    reference = study(scenario, "fingers", n=FINGERS, seed=4)
    for asked in (
        {"exceed": "10 mN"},
        {"percentiles": ()},
        {"budget_memory": "700 kB", "percentiles": (50,)},
    ):
        other = study(scenario, "fingers", n=FINGERS, seed=4, **asked)
        for name in (f"{NAME}_mean", f"{NAME}_variance"):
            np.testing.assert_array_equal(other[name], reference[name])


def test_a_block_of_another_form_is_stored(monkeypatch):
    one = evaluator()
    expected, original = stored(one), one.population.squares
    first = one._draws(1024, 1025)

    def squares(draws, **asked):
        path = next(iter(draws))
        return None if draws[path][0] == first[path][0] else original(draws, **asked)

    streamed = one.reduced(0, FINGERS)[NAME]
    monkeypatch.setattr(one.population, "squares", squares)
    found = one.reduced(0, FINGERS)[NAME]
    assert_near(found, expected)
    for place, same in enumerate((streamed, expected, streamed)):
        np.testing.assert_array_equal(found.blocks[place].mean, same.blocks[place].mean)


@pytest.mark.parametrize("percentiles", [(5, 95), ()])
def test_unknown_values_are_counted(monkeypatch, percentiles):
    one = evaluator(percentiles=percentiles)
    squares, signals = one.population.squares, one.population.signals

    def without(draws, *, out=None, threads=None):
        found = squares(draws, out=out, threads=threads)
        for rows in (out or {}).values():
            rows[5] = np.nan
        factor = found.factor.copy()
        factor[5] = np.nan
        return found._replace(factor=factor)

    def unknown(draws, **asked):
        found = signals(draws, **asked)
        found[NAME][5] = np.nan
        return found

    monkeypatch.setattr(one.population, "squares", without)
    monkeypatch.setattr(one.population, "signals", unknown)
    found = one.reduced(0, FINGERS)[NAME]
    np.testing.assert_array_equal(found.counts.unknown, 3)
    assert all(np.isnan(block.mean).all() for block in found.blocks)


def test_signals_of_many_poles_are_stored(monkeypatch):
    monkeypatch.setattr("electrovib.solve.population.together.over_time.FEW_POLES", 0)
    assert not evaluator().streamed


def test_thresholds_are_compared_with_numbers_in_float64():
    one = evaluator()
    values = one._signals(one._draws(0, 1024))[NAME][:, 20]
    threshold = float(np.nextafter(np.median(values[:1023]), 0.0))  # both have the same float32
    expected = np.count_nonzero(values > threshold)
    assert np.count_nonzero(values.astype(np.float32) > np.float32(threshold)) != expected
    assert evaluator(exceed=[threshold]).reduced(0, 1024)[NAME].counts.above[0, 20] == expected
