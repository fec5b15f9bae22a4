"""Quantities of many fingers in arrays have the values of each finger by itself."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.papers import palmar_1995
from electrovib.scenario import load
from electrovib.scenario.space import read_space
from electrovib.solve.population import quantity
from electrovib.solve.population.fingers import TOGETHER
from electrovib.solve.population.quantity import QuantityOfFingers
from electrovib.solve.prepare import Prepared
from electrovib.solve.quantities import read_name

THICKNESS, AREA = "stack.stratum_corneum.thickness", "contact.area"
GAP = "vezzoli_2014/fig6_gap"


def made(scenario, text, free=(THICKNESS, AREA)):
    return QuantityOfFingers(scenario, free, read_name(text, tuple(scenario.stack.layers)))


def alone(scenario, text, draws):
    return Prepared(scenario, free=tuple(draws), quantities=[text])(draws)[text]


def draws_of(scenario, count, seed=1):
    return read_space(scenario, "fingers").draw(seed, 0, count)


def assert_same(scenario, text, draws, *, within=1e-12):
    """Compare with each finger by itself, relative to the largest value of its signal."""
    peak = text.replace(text.split()[0], "peak", 1)
    many = made(scenario, text, tuple(draws))
    assert many.method == TOGETHER
    found, expected = many(draws), alone(scenario, text, draws)
    assert np.all(np.abs(found - expected) <= within * alone(scenario, peak, draws))


@pytest.mark.parametrize(
    ("preset", "text", "within"),
    [
        (GAP, "mean electrostatic_force", 1e-12),
        (GAP, "minimum field in gap", 1e-9),
        ("vezzoli_2014/fig6", "final stack_voltage", 1e-9),
        ("bau_2010/sine", "swing lateral_force", 1e-12),
    ],
)
def test_values_are_those_of_each_finger_alone(preset, text, within):
    scenario = load(preset)
    assert_same(scenario, text, draws_of(scenario, 40), within=within)


def test_dispersive_skins_are_reduced_over_the_band_of_the_time_window():
    skin = palmar_1995.skins()["dry_men"].material.to_dict()
    scenario = load(GAP).replace({"stack.stratum_corneum.material": skin})
    generator = np.random.default_rng(1)
    draws = {THICKNESS: generator.uniform(1e-4, 4e-4, 40), AREA: generator.uniform(5e-5, 2e-4, 40)}
    assert_same(scenario, "mean electrostatic_force", draws)


@pytest.mark.parametrize("count", [33, 70])
def test_the_value_of_a_finger_does_not_depend_on_the_parts_of_a_call(monkeypatch, count):
    scenario = load(GAP)
    draws, many = draws_of(scenario, count), made(scenario, "rms electrostatic_force")
    draws = {path: draws[path] for path in (THICKNESS, AREA)}
    whole, seen = many(draws), []
    monkeypatch.setattr(quantity, "_CHUNK", 8)
    monkeypatch.setattr(quantity, "_SERIES", 3)
    assert many(draws, progress=lambda *at: seen.append(at)).tobytes() == whole.tobytes()
    assert seen == [(start, count) for start in range(0, count, 8)]


def test_fingers_that_the_mesh_of_the_others_does_not_resolve_are_solved_alone(monkeypatch):
    """Skins that conduct 1e6 times better relax faster; none of them is among the fingers on which the mesh is refined."""
    scenario, path = load(GAP), "stack.stratum_corneum.material.conductivity"
    usual = scenario.stack.layers["stratum_corneum"].material.conductivity
    values = np.full(100, usual)
    values[[1, 2, 5]] = 1e6 * usual
    text = "peak field in stratum_corneum"
    many = made(scenario, text, (path,))
    assert not {1, 2, 5} & set(quantity._probes(np.arange(100)).tolist())
    counted = Counted(Prepared(scenario, free=[path], quantities=[text]))
    monkeypatch.setattr(many, "_alone", counted)
    found = many({path: values})
    assert counted.evaluated == 3
    np.testing.assert_allclose(found, alone(scenario, text, {path: values}), rtol=1e-12)


class Counted:
    """A prepared scenario that counts its evaluations."""

    def __init__(self, prepared):
        self.prepared, self.evaluated = prepared, 0

    def scenario(self, point):
        return self.prepared.scenario(point)

    def __call__(self, draws):
        self.evaluated += len(next(iter(draws.values())))
        return self.prepared(draws)


def test_a_signal_that_is_not_known_has_no_value():
    scenario, text = load("bau_2010/sine").replace({"motion.speed": 0.0}), "mean lateral_force"
    many = made(scenario, text, (AREA,))
    assert many.method == TOGETHER
    assert np.isnan(many({AREA: np.full(40, 1e-4)})).all()


def test_what_is_not_computed_in_arrays_is_solved_one_by_one():
    scenario, draws = load(GAP), {"time.duration": np.array([0.1, 0.2])}
    many = made(scenario, "mean electrostatic_force", ("time.duration",))
    assert "time grid differs" in many.method
    np.testing.assert_array_equal(many(draws), alone(scenario, "mean electrostatic_force", draws))
    assert "one finger at a time" in made(scenario, "peak plate_voltage").method
