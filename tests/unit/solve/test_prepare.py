"""A scenario as a function of its parameters: the same numbers as one by one, and only what changed computed again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.numbers import with_numbers
from electrovib.solve import expanded
from electrovib.solve.prepare import prepare

SINE = "bau_2010/sine"
FORCE, MEAN, PEAK = "electrostatic_force", "mean electrostatic_force", "peak electrostatic_force"
FILM, SKIN, AREA = "stack.insulator.thickness", "stack.stratum_corneum.thickness", "contact.area"
PATHS = ("drive.amplitude", FILM, SKIN, AREA, "friction.coefficient")


def ready(quantities=(MEAN,), free=PATHS, scenario=SINE):
    return prepare(scenario, free=free, quantities=quantities)


def one_by_one(scenario, point, quantity):
    path, value = next(iter(point.items()))
    found = ev.sweep(ev.load(scenario, changes=point), {path: [value]}, quantities=[quantity])
    return float(found[quantity].values[0])


@pytest.mark.parametrize(
    ("scenario", "paths", "quantity"),
    [
        (SINE, PATHS, MEAN),
        ("kim_2015/current", ("drive.amplitude", AREA), PEAK),
        ("shultz_2018/sliding", (FILM,), MEAN),
        (SINE, ("friction.coefficient", "drive.amplitude"), "mean lateral_force"),
        (SINE, ("circuit.return_path.resistance", "drive.frequency"), "peak current"),
        ("kaczmarek_2006/biphasic", ("drive.drives.0.high",), PEAK),
        ("nakamura_2017/rise", ("drive.level",), "final current"),
    ],
)
def test_the_numbers_are_those_of_a_sweep(scenario, paths, quantity):
    function, rng = ready((quantity,), paths, scenario), np.random.default_rng(3)
    columns = {path: function.begin[path] * rng.uniform(0.2, 5.0, 3) for path in paths}
    points = [{path: float(column[index]) for path, column in columns.items()} for index in range(3)]
    expected = [one_by_one(scenario, point, quantity) for point in points]
    np.testing.assert_allclose(function(columns)[quantity], expected, rtol=1e-12)


def test_a_faster_drive_has_its_material_reduced_over_its_own_band():
    function = ready(("peak current",), ("drive.frequency",), "vardar_2017/sine")
    function({"drive.frequency": 100.0})
    fast = {"drive.frequency": 2e6}
    expected = one_by_one("vardar_2017/sine", fast, "peak current")
    assert function(fast)["peak current"] == pytest.approx(expected, rel=1e-12)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.sampled_from(PATHS), min_size=1, max_size=12), st.data())
def test_whatever_changed_last_the_answer_is_that_of_the_point(order, data):
    """What is kept from the point before is never that of another point."""
    function = ready((MEAN, "mean lateral_force"))
    point = dict(function.begin)
    for path in order:
        point[path] = function.begin[path] * data.draw(st.sampled_from([0.7, 1.0, 1.5]))
        kept = function(point)
    assert kept == ready((MEAN, "mean lateral_force"))(point)


@pytest.mark.parametrize(
    ("path", "modes", "solved"),
    [(FILM, 1, 1), (AREA, 1, 1), ("drive.amplitude", 0, 1), ("friction.coefficient", 0, 0)],
)
def test_only_what_a_parameter_touches_is_computed_again(monkeypatch, path, modes, solved):
    counts = {"modes": 0, "solve": 0}

    def counted(name):
        whole = getattr(expanded, name)

        def call(*arguments, **options):
            counts[name] += 1
            return whole(*arguments, **options)

        return call

    function = ready(("mean lateral_force",))
    function(function.begin)
    for name in counts:
        monkeypatch.setattr(expanded, name, counted(name))
    function({path: 1.1 * function.begin[path]})
    assert counts == {"modes": modes, "solve": solved}


def test_arrays_are_broadcast_and_a_mapping_leaves_out_what_stays():
    function = ready()
    amplitude, thickness = np.array([50.0, 100.0]), np.array([[1e-6], [2e-6], [3e-6]])
    found = function({"drive.amplitude": amplitude, FILM: thickness})[MEAN]
    assert found.shape == (3, 2)
    np.testing.assert_allclose(found[:, 1] / found[:, 0], 4.0, rtol=1e-12)  # linear layers: a square law
    alone = function({"drive.amplitude": 50.0, FILM: 2e-6})[MEAN]
    assert isinstance(alone, float)
    assert alone == found[1, 0]
    assert function([50.0, 2e-6, *list(function.begin.values())[2:]])[MEAN] == alone  # in order


def test_signals_are_those_of_simulate_and_a_judged_answer_says_how_far_its_numbers_hold():
    function, time, names = ready(), np.linspace(0, 8e-3, 301), [FORCE, "lateral_force", "field"]
    point = {"drive.amplitude": 80.0, "friction.coefficient": 0.3}
    found = function.signals(point, names=names, time=time)
    trace = ev.simulate(ev.load(SINE, changes=point), time=time)
    assert set(found) == {"time", *names}
    for name in names:
        np.testing.assert_array_equal(found[name], trace[name].values)
    judged = function.judged(point)
    assert judged.values == pytest.approx(function(point), rel=1e-14)
    assert judged.diagnostics
    assert judged.how["solver"] == "periodic"


@pytest.mark.parametrize(
    "asked",
    [
        [("force", 1), ("field", 1)],  # what was left out before is not taken for what is there
        [("field", 1), ("field", 2), ("force", 2)],  # as many times, and other ones
        [("force", 1), ("force", 2), ("field", 2)],
    ],
)
def test_signals_asked_for_later_and_other_times_are_not_those_of_before(asked):
    function = ready()
    for what, shorter in asked:
        time = np.linspace(0, 8e-3, 301) / shorter
        names = [FORCE] if what == "force" else ["field", "stack_voltage"]
        found, expected = function.signals({}, names=names, time=time), ev.simulate(SINE, time=time)
        for name in names:
            np.testing.assert_allclose(found[name], expected[name].values, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ready(free=("stack.insulator.thicknes",)), f"Did you mean '{FILM}'"),
        (lambda: ready(("mean electrostatic_forc",)), "Did you mean 'electrostatic_force'"),
        (lambda: ready(free=(AREA, AREA)), "named twice"),
        (lambda: ready()([1.0, 2.0]), "2 given, 5 expected"),
        (lambda: ready()({"load.normal_force": 1.0}), "load.normal_force: not a free parameter"),
        (lambda: ready()({AREA: -1.0}), "contact.area = -1"),
        (lambda: ready().signals({}, names=["force"]), "no 'force'"),
        (lambda: ready(("mean forc",), ("contact.are",)), r"(?s)contact\.are.*forc|forc.*contact\.are"),
    ],
)
def test_mistakes_are_one_sentence_and_told_at_once(call, words):
    with pytest.raises(InputError, match=words):
        call()


@pytest.mark.parametrize("path", PATHS)
def test_other_numbers_in_a_model_share_the_rest(path):
    scenario = ev.load(SINE)
    value = 1.5 * {where: number for where, number, _ in scenario.parameters()}[path]
    changed = with_numbers(scenario, {path: value})
    assert changed == scenario.replace({path: value})
    other = [name for name, part in changed if name != "sources" and part is not getattr(scenario, name)]
    assert other == [path.split(".")[0]]
