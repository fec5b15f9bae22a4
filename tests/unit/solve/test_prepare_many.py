"""Quantities of many points in arrays have the values of each point by itself."""

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

SKIN, AREA, CONDUCTS = (
    "stack.stratum_corneum.thickness",
    "contact.area",
    "stack.stratum_corneum.material.conductivity",
)
GAP, SINE = load("vezzoli_2014/fig6_gap"), load("bau_2010/sine")
FORCE, FRICTION = "mean electrostatic_force", "swing lateral_force"
COULOMB = {"model": "Coulomb", "coefficient": 0.5}
LAG = {"friction": {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": 300.0}}
LEAK = {"model": "PolarityConduction", "conductivity_positive": 1e-9, "conductivity_negative": 3e-9}
LEAKY = {"time": {"initial_state": {"model": "AtRest"}, "duration": 1e-3}, "stack.insulator.leak": LEAK}


def made(scenario, *texts, free=(SKIN, AREA)):
    return Prepared(scenario, free=free, quantities=texts)


def alone(scenario, texts, draws):
    function = made(scenario, *texts, free=tuple(draws))
    points = zip(*[values.tolist() for values in draws.values()], strict=True)
    rows = [function(dict(zip(draws, point, strict=True))) for point in points]
    return {text: np.array([row[text] for row in rows]) for text in texts}


def around(scenario, count, free=(SKIN, AREA)):
    begin, generator = Prepared(scenario, free=free).begin, np.random.default_rng(2)
    return {path: value * generator.uniform(0.8, 1.25, count) for path, value in begin.items()}


def recorded(monkeypatch, many):
    """Points that are solved by themselves."""
    evaluated, one = [], many._numbers
    monkeypatch.setattr(many, "_numbers", lambda point: evaluated.append(point) or one(point))
    return evaluated


def dispersive():
    return GAP.replace({"stack.stratum_corneum.material": palmar_1995.skins()["dry_men"].material.to_dict()})


SEVERAL = [FORCE, "peak electrostatic_force", FRICTION, "peak current", "rms field in insulator"]


@pytest.mark.parametrize(
    ("scenario", "texts", "free", "within"),
    [
        (GAP, [FORCE], None, 1e-12),
        (GAP, ["minimum field in gap"], None, 1e-9),
        (load("vezzoli_2014/fig6"), ["final stack_voltage"], None, 1e-9),
        (SINE, SEVERAL, (SKIN, AREA, "drive.amplitude", "friction.coefficient"), 1e-9),
        (dispersive(), [FORCE], (SKIN, AREA), 1e-12),  # reduced over the band of the time window
    ],
    ids=["force", "field", "voltage", "several signals share a mesh", "dispersive skin"],
)
def test_values_are_those_of_each_point_alone(monkeypatch, scenario, texts, free, within):
    """Relative to the largest value of the signal."""
    draws = around(scenario, 40, free) if free else read_space(scenario, "fingers").draw(1, 0, 40)
    many = made(scenario, *texts, free=tuple(draws))
    assert many.method == TOGETHER
    peaks = [text.replace(text.split()[0], "peak", 1) for text in texts]
    expected = alone(scenario, dict.fromkeys([*texts, *peaks]), draws)
    monkeypatch.setattr(Prepared, "_numbers", None)  # no point is solved by itself
    found = many(draws)
    for text, peak in zip(texts, peaks, strict=True):
        assert np.all(np.abs(found[text] - expected[text]) <= within * expected[peak])


@pytest.mark.parametrize(
    ("scenario", "changes", "texts", "draws", "words"),
    [
        (SINE, LAG, [FORCE, FRICTION], None, "FirstOrderLag has a memory"),
        (SINE, LEAKY, [FORCE, "peak current"], None, "the electrical solver is"),
        (SINE, {}, [FORCE, "peak capacitance"], None, "one finger at a time"),
        (GAP, {}, [FORCE], {"time.duration": np.linspace(0.1, 0.2, 33)}, "grid differs"),
        (SINE, {}, [FORCE], {"drive.frequency": np.linspace(100, 190, 33)}, "times of the drive differ"),
        # the current after a step of the voltage is limited by the rounding of the time: further calls do not try
        (load("vezzoli_2014/fig6"), {}, ["peak current"], None, "no mesh resolved"),
    ],
)
def test_what_is_no_array_is_solved_one_by_one(scenario, changes, texts, draws, words):
    """A memory, a leak, and points with grids, periods and windows of their own."""
    scenario = scenario.replace(changes)
    draws = around(scenario, 33) if draws is None else draws
    many = made(scenario, *texts, free=tuple(draws))
    assert (many.method == TOGETHER) == (words == "no mesh resolved")
    found, expected = many(draws), alone(scenario, texts, draws)
    assert words in many.method
    for text in texts:
        np.testing.assert_array_equal(found[text], expected[text])


@pytest.mark.parametrize("count", [33, 70])
def test_the_value_of_a_point_does_not_depend_on_the_parts_of_a_call(monkeypatch, count):
    draws, many, text = around(GAP, count), made(GAP, "rms electrostatic_force"), "rms electrostatic_force"
    whole, seen = many(draws)[text], []
    monkeypatch.setattr(prepare, "_CHUNK", 8)
    assert many(draws, progress=lambda *at: seen.append(at))[text].tobytes() == whole.tobytes()
    assert seen == [(start, count) for start in range(0, count, 8)]


def test_points_that_the_mesh_of_the_others_does_not_resolve_are_solved_alone(monkeypatch):
    """Skins that conduct 1e6 times better relax faster, and are not among the points on which the mesh is refined."""
    values, text = (
        np.full(100, GAP.stack.layers["stratum_corneum"].material.conductivity),
        "peak field in stratum_corneum",
    )
    values[[1, 2, 5]] *= 1e6
    many = made(GAP, text, free=(CONDUCTS,))
    assert {1, 4, 8} < set(prepare._probes({CONDUCTS: values}, np.arange(100)).tolist())
    monkeypatch.setattr(prepare, "_probes", lambda _draws, left: left[6:])
    evaluated = recorded(monkeypatch, many)
    found = many({CONDUCTS: values})[text]
    assert len(evaluated) == 3
    np.testing.assert_allclose(found, alone(GAP, [text], {CONDUCTS: values})[text], rtol=1e-12)


def test_a_mesh_may_leave_some_of_its_probes_to_be_solved_alone(monkeypatch):
    """Where rounding limits the polynomials of a point, the others stay in arrays."""
    many, draws, whole = made(SINE, FORCE), around(SINE, 64), prepare.relative_tails

    def limited(series):
        found = whole(series)
        found[np.argmax(np.abs(series).sum(axis=(1, 2)))] += len(series) > 1
        return found

    monkeypatch.setattr(prepare, "relative_tails", limited)
    evaluated = recorded(monkeypatch, many)
    found = many(draws)[FORCE]
    assert 1 <= len(evaluated) <= prepare._MESHES
    np.testing.assert_allclose(found, alone(SINE, [FORCE], draws)[FORCE], rtol=1e-12)


def test_a_signal_that_is_not_known_has_no_value():
    many = made(SINE.replace({"motion.speed": 0.0}), "mean lateral_force", free=(AREA,))
    assert many.method == TOGETHER
    assert np.isnan(many({AREA: np.full(40, 1e-4)})["mean lateral_force"]).all()


def test_a_point_that_is_refused_is_refused_as_by_itself():
    values, errors = np.full(40, 1e-4), []
    values[7] = -1.0
    for given in (values, -1.0):
        with pytest.raises(InputError) as error:
            made(GAP, FORCE)({AREA: given})
        errors.append(error.value.problems)
    assert errors[0] == errors[1]
    with pytest.raises(InputError, match="not a free parameter"):
        made(GAP, FORCE)({"load.normal_force": np.full(40, 1.0)})


def test_arrays_keep_their_shape_and_the_last_point_is_the_one_that_is_judged():
    many = made(GAP, FORCE, "peak current")
    found = many({SKIN: np.linspace(1e-4, 4e-4, 40).reshape(5, 8)})
    assert {name: values.shape for name, values in found.items()} == dict.fromkeys(many.quantities, (5, 8))
    assert many.diagnostics == made(GAP.replace({SKIN: 4e-4}), FORCE).diagnostics


def test_a_budget_that_is_spent_ends_the_arrays():
    def spent(done, count):
        raise BudgetError([f"{done} of {count}"])

    with pytest.raises(BudgetError, match="0 of 40"):
        made(GAP, FORCE)({AREA: np.full(40, 1e-4)}, progress=spent)
