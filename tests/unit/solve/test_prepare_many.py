"""Quantities of many points in arrays have the values of each point by itself."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.budget import BudgetError
from electrovib.core.errors import InputError
from electrovib.papers import palmar_1995
from electrovib.scenario import load
from electrovib.scenario.space import read_space
from electrovib.solve import prepare
from electrovib.solve.population.fingers import TOGETHER
from electrovib.solve.prepare import Prepared

THICKNESS, AREA = "stack.stratum_corneum.thickness", "contact.area"
GAP = "vezzoli_2014/fig6_gap"
FORCE, FRICTION = "mean electrostatic_force", "swing lateral_force"
LAG = {
    "friction": {
        "model": "FirstOrderLag",
        "steady": {"model": "Coulomb", "coefficient": 0.5},
        "cut_off": 300.0,
    }
}
LEAK = {
    "time": {"initial_state": {"model": "AtRest"}, "duration": 1e-3},
    "stack.insulator.leak": {
        "model": "PolarityConduction",
        "conductivity_positive": 1e-9,
        "conductivity_negative": 3e-9,
    },
}


def made(scenario, *texts, free=(THICKNESS, AREA)):
    return Prepared(scenario, free=free, quantities=texts)


def alone(scenario, texts, draws):
    function = made(scenario, *texts, free=tuple(draws))
    points = zip(*[values.tolist() for values in draws.values()], strict=True)
    rows = [function(dict(zip(draws, point, strict=True))) for point in points]
    return {text: np.array([row[text] for row in rows]) for text in texts}


def draws_of(scenario, count, seed=1):
    return read_space(scenario, "fingers").draw(seed, 0, count)


def around(scenario, count, free):
    begin, generator = Prepared(scenario, free=free).begin, np.random.default_rng(2)
    return {path: value * generator.uniform(0.8, 1.25, count) for path, value in begin.items()}


def assert_same(scenario, texts, draws, *, within=1e-12):
    """Compare with each point by itself, relative to the largest value of its signal."""
    found, expected = made(scenario, *texts, free=tuple(draws))(draws), alone(scenario, texts, draws)
    for text in texts:
        peak = text.replace(text.split()[0], "peak", 1)
        largest = alone(scenario, [peak], draws)[peak]
        assert np.all(np.abs(found[text] - expected[text]) <= within * largest)


@pytest.mark.parametrize(
    ("preset", "text", "within"),
    [
        (GAP, FORCE, 1e-12),
        (GAP, "minimum field in gap", 1e-9),
        ("vezzoli_2014/fig6", "final stack_voltage", 1e-9),
        ("bau_2010/sine", FRICTION, 1e-12),
    ],
)
def test_values_are_those_of_each_point_alone(preset, text, within):
    scenario = load(preset)
    draws = draws_of(scenario, 40)
    assert made(scenario, text, free=tuple(draws)).method == TOGETHER
    assert_same(scenario, [text], draws, within=within)


def test_several_quantities_of_several_signals_share_a_mesh(monkeypatch):
    scenario = load("bau_2010/sine")
    texts = [FORCE, "peak electrostatic_force", FRICTION, "peak current", "rms field in insulator"]
    draws = around(scenario, 40, (THICKNESS, AREA, "drive.amplitude", "friction.coefficient"))
    assert made(scenario, *texts, free=tuple(draws)).method == TOGETHER
    assert_same(scenario, texts, draws, within=1e-9)
    monkeypatch.setattr(Prepared, "_numbers", None)  # no point is solved by itself
    assert set(made(scenario, *texts, free=tuple(draws))(draws)) == set(texts)


@pytest.mark.parametrize(
    ("changes", "texts", "words"),
    [
        (LAG, [FORCE, FRICTION], "FirstOrderLag has a memory"),
        (LEAK, [FORCE, "peak current"], "the electrical solver is"),
        ({}, [FORCE, "peak capacitance"], "one finger at a time"),
    ],
)
def test_what_has_a_memory_or_a_leak_is_solved_one_by_one(changes, texts, words):
    scenario = load("bau_2010/sine", changes=changes)
    draws = around(scenario, 33, (THICKNESS, AREA))
    many = made(scenario, *texts)
    assert words in many.method
    found, expected = many(draws), alone(scenario, texts, draws)
    for text in texts:
        np.testing.assert_array_equal(found[text], expected[text])


def test_dispersive_skins_are_reduced_over_the_band_of_the_time_window():
    skin = palmar_1995.skins()["dry_men"].material.to_dict()
    scenario = load(GAP).replace({"stack.stratum_corneum.material": skin})
    generator = np.random.default_rng(1)
    draws = {THICKNESS: generator.uniform(1e-4, 4e-4, 40), AREA: generator.uniform(5e-5, 2e-4, 40)}
    assert made(scenario, FORCE).method == TOGETHER
    assert_same(scenario, [FORCE], draws)


@pytest.mark.parametrize("count", [33, 70])
def test_the_value_of_a_point_does_not_depend_on_the_parts_of_a_call(monkeypatch, count):
    scenario, text = load(GAP), "rms electrostatic_force"
    draws, many = draws_of(scenario, count), made(scenario, text)
    draws = {path: draws[path] for path in (THICKNESS, AREA)}
    whole, seen = many(draws)[text], []
    monkeypatch.setattr(prepare, "_CHUNK", 8)
    assert many(draws, progress=lambda *at: seen.append(at))[text].tobytes() == whole.tobytes()
    assert seen == [(start, count) for start in range(0, count, 8)]


def test_points_that_the_mesh_of_the_others_does_not_resolve_are_solved_alone(monkeypatch):
    """Skins that conduct 1e6 times better relax faster, and are not among the points on which the mesh is refined."""
    scenario, path = load(GAP), "stack.stratum_corneum.material.conductivity"
    usual = scenario.stack.layers["stratum_corneum"].material.conductivity
    values = np.full(100, usual)
    values[[1, 2, 5]] = 1e6 * usual
    text = "peak field in stratum_corneum"
    many = made(scenario, text, free=(path,))
    assert {1, 4, 8} < set(prepare._probes({path: values}, np.arange(100)).tolist())
    monkeypatch.setattr(prepare, "_probes", lambda _draws, left: left[6:])
    evaluated, one = [], many._numbers
    monkeypatch.setattr(many, "_numbers", lambda *given: evaluated.append(given) or one(*given))
    found = many({path: values})[text]
    assert len(evaluated) == 3
    np.testing.assert_allclose(found, alone(scenario, [text], {path: values})[text], rtol=1e-12)


def test_a_mesh_may_leave_some_of_its_probes_to_be_solved_alone(monkeypatch):
    """Where rounding limits the polynomials of a point, the others stay in arrays."""
    scenario, whole = load("bau_2010/sine"), prepare.relative_tails
    many, draws = made(scenario, FORCE), around(load("bau_2010/sine"), 64, (THICKNESS, AREA))

    def limited(series):
        found = whole(series)
        found[np.argmax(np.abs(series).sum(axis=(1, 2)))] += len(series) > 1
        return found

    monkeypatch.setattr(prepare, "relative_tails", limited)
    evaluated, one = [], many._numbers
    monkeypatch.setattr(many, "_numbers", lambda point: evaluated.append(point) or one(point))
    found = many(draws)[FORCE]
    assert 1 <= len(evaluated) <= prepare._MESHES
    np.testing.assert_allclose(found, alone(scenario, [FORCE], draws)[FORCE], rtol=1e-12)


def test_where_no_mesh_resolves_a_signal_further_calls_do_not_try():
    """The current after a step of the voltage is limited by the rounding of the time."""
    scenario, text = load("vezzoli_2014/fig6"), "peak current"
    many, draws = made(scenario, text), around(load("vezzoli_2014/fig6"), 33, (THICKNESS, AREA))
    assert many.method == TOGETHER
    np.testing.assert_array_equal(many(draws)[text], alone(scenario, [text], draws)[text])
    assert "no mesh resolved" in many.method


def test_a_signal_that_is_not_known_has_no_value():
    scenario, text = load("bau_2010/sine").replace({"motion.speed": 0.0}), "mean lateral_force"
    many = made(scenario, text, free=(AREA,))
    assert many.method == TOGETHER
    assert np.isnan(many({AREA: np.full(40, 1e-4)})[text]).all()


def test_points_with_grids_of_their_own_are_solved_one_by_one():
    scenario, draws = load(GAP), {"time.duration": np.linspace(0.1, 0.2, 33)}
    many = made(scenario, FORCE, free=("time.duration",))
    assert "grid differs" in many.method
    np.testing.assert_array_equal(many(draws)[FORCE], alone(scenario, [FORCE], draws)[FORCE])


def test_points_with_a_period_of_their_own_have_their_own_window():
    scenario, draws = load("bau_2010/sine"), {"drive.frequency": np.linspace(100.0, 190.0, 40)}
    many = made(scenario, FORCE, free=("drive.frequency",))
    assert "times of the drive differ" in many.method
    np.testing.assert_array_equal(many(draws)[FORCE], alone(scenario, [FORCE], draws)[FORCE])


def test_a_point_that_is_refused_is_refused_as_by_itself():
    scenario, values = load(GAP), np.full(40, 1e-4)
    values[7] = -1.0
    errors = []
    for given in (values, -1.0):
        with pytest.raises(InputError) as error:
            made(scenario, FORCE)({AREA: given})
        errors.append(error.value.problems)
    assert errors[0] == errors[1]
    with pytest.raises(InputError, match="not a free parameter"):
        made(scenario, FORCE)({"load.normal_force": np.full(40, 1.0)})


def test_arrays_keep_their_shape_and_the_last_point_is_the_one_that_is_judged():
    many = made(load(GAP), FORCE, "peak current")
    thickness = np.linspace(1e-4, 4e-4, 40).reshape(5, 8)
    found = many({THICKNESS: thickness})
    assert {name: values.shape for name, values in found.items()} == dict.fromkeys(many.quantities, (5, 8))
    assert many.diagnostics == made(load(GAP).replace({THICKNESS: 4e-4}), FORCE).diagnostics


def test_a_budget_that_is_spent_ends_the_arrays():
    def spent(done, count):
        raise BudgetError([f"{done} of {count}"])

    with pytest.raises(BudgetError, match="0 of 40"):
        made(load(GAP), FORCE)({AREA: np.full(40, 1e-4)}, progress=spent)
