"""A scenario as a function of its parameters: of one point, of many in arrays, and of fingers one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.budget import BudgetError
from electrovib.core.errors import InputError
from electrovib.core.paths import with_numbers
from electrovib.papers import palmar_1995
from electrovib.scenario.space import read_space
from electrovib.solve import expanded
from electrovib.solve.one_by_one import ParametricScenario
from electrovib.solve.population import Population
from electrovib.solve.population.fingers import TOGETHER
from electrovib.solve.prepare import Prepared, prepare
from electrovib.solve.quantities import cases

SINE = "bau_2010/sine"
FORCE, MEAN, PEAK = "electrostatic_force", "mean electrostatic_force", "peak electrostatic_force"
FILM, SKIN, AREA = "stack.insulator.thickness", "stack.stratum_corneum.thickness", "contact.area"
PATHS = ("drive.amplitude", FILM, SKIN, AREA, "friction.coefficient")


def ready(quantity=(MEAN,), free=PATHS, scenario=SINE):
    return prepare(scenario, free=free, quantity=quantity)


def one_by_one(scenario, point, quantity):
    path, value = next(iter(point.items()))
    found = ev.sweep(ev.load(scenario, changes=point), {path: [value]}, quantity=[quantity])
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


CONDUCTS = "stack.stratum_corneum.material.conductivity"
OF_GAP, OF_SINE = ev.load("vezzoli_2014/fig6_gap"), ev.load("bau_2010/sine")
SWING = "swing lateral_force"
COULOMB = {"model": "Coulomb", "coefficient": 0.5}
LAG = {"friction": {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": 300.0}}
LEAK = {"model": "PolarityConduction", "conductivity_positive": 1e-9, "conductivity_negative": 3e-9}
LEAKY = {"time": {"initial_state": {"model": "AtRest"}, "duration": 2e-4}, "stack.insulator.leak": LEAK}


def made(scenario, *texts, free=(SKIN, AREA)):
    return Prepared(scenario, free=free, quantity=texts)


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


DRY = {"stack.stratum_corneum.material": palmar_1995.skins()["dry_men"].material.to_dict()}
SEVERAL = [MEAN, "peak electrostatic_force", SWING, "peak current", "rms field in insulator"]


@pytest.mark.parametrize(
    ("scenario", "texts", "free", "within"),
    [
        (OF_GAP, [MEAN], None, 1e-12),
        (OF_GAP, ["minimum field in gap"], None, 1e-9),
        (ev.load("vezzoli_2014/fig6"), ["final stack_voltage"], None, 1e-9),
        (OF_SINE, SEVERAL, (SKIN, AREA, "drive.amplitude", "friction.coefficient"), 1e-9),
        (OF_GAP.replace(DRY), [MEAN], (SKIN, AREA), 1e-12),  # reduced over the band of the time window
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
        (OF_SINE, LAG, [MEAN, SWING], None, "FirstOrderLag has a memory"),
        pytest.param(
            OF_SINE,
            LEAKY,
            [MEAN, "peak current"],
            None,
            "the electrical solver is",
            marks=pytest.mark.slow,
        ),
        (OF_SINE, {}, [MEAN, "peak capacitance"], None, "one finger at a time"),
        (OF_GAP, {}, [MEAN], {"time.duration": np.linspace(0.1, 0.2, 33)}, "grid differs"),
        (OF_SINE, {}, [MEAN], {"drive.frequency": np.linspace(100, 190, 33)}, "times of the drive differ"),
        # the current after a step of the voltage is limited by the rounding of the time: further calls do not try
        (ev.load("vezzoli_2014/fig6"), {}, ["peak current"], None, "no mesh resolved"),
    ],
)
def test_what_is_no_array_is_solved_one_by_one(scenario, changes, texts, draws, words):
    """A memory, a leak, and points with grids, periods and windows of their own."""
    scenario = scenario.replace(changes)
    draws = around(scenario, 33) if draws is None else draws
    many = made(scenario, *texts, free=tuple(draws))
    assert (many.method == TOGETHER) == (words == "no mesh resolved")
    found, expected = (
        many(draws),
        alone(scenario, texts, {path: values[::8] for path, values in draws.items()}),
    )
    assert words in many.method
    for text in texts:
        np.testing.assert_array_equal(found[text][::8], expected[text])


@pytest.mark.parametrize("count", [33, 70])
def test_the_value_of_a_point_does_not_depend_on_the_parts_of_a_call(monkeypatch, count):
    draws, text = around(OF_GAP, count), "rms electrostatic_force"
    many = made(OF_GAP, text)
    whole, seen = many(draws)[text], []
    monkeypatch.setattr(cases, "_CHUNK", 8)
    assert many(draws, progress=lambda *at: seen.append(at))[text].tobytes() == whole.tobytes()
    assert seen == [(start, count) for start in range(0, count, 8)]


def test_points_that_the_mesh_of_the_others_does_not_resolve_are_solved_alone(monkeypatch):
    """Skins that conduct 1e6 times better relax faster, and are not among the points on which the mesh is refined."""
    text = "peak field in stratum_corneum"
    values = np.full(100, OF_GAP.stack.layers["stratum_corneum"].material.conductivity)
    values[[1, 2, 5]] *= 1e6
    many = made(OF_GAP, text, free=(CONDUCTS,))
    assert {1, 4, 8} < set(cases._probes({CONDUCTS: values}, np.arange(100)).tolist())
    monkeypatch.setattr(cases, "_probes", lambda _draws, left: left[6:])
    evaluated = recorded(monkeypatch, many)
    found = many({CONDUCTS: values})[text]
    assert len(evaluated) == 3
    np.testing.assert_allclose(found, alone(OF_GAP, [text], {CONDUCTS: values})[text], rtol=1e-12)


def test_a_mesh_may_leave_some_of_its_probes_to_be_solved_alone(monkeypatch):
    """Where rounding limits the polynomials of a point, the others stay in arrays."""
    many, draws, whole = made(OF_SINE, MEAN), around(OF_SINE, 64), cases.relative_tails

    def limited(series):
        found = whole(series)
        found[np.argmax(np.abs(series).sum(axis=(1, 2)))] += len(series) > 1
        return found

    monkeypatch.setattr(cases, "relative_tails", limited)
    evaluated = recorded(monkeypatch, many)
    found = many(draws)[MEAN]
    assert 1 <= len(evaluated) <= cases._MESHES
    np.testing.assert_allclose(found, alone(OF_SINE, [MEAN], draws)[MEAN], rtol=1e-12)


def test_a_signal_that_is_not_known_has_no_value():
    many = made(OF_SINE.replace({"motion.speed": 0.0}), "mean lateral_force", free=(AREA,))
    assert many.method == TOGETHER
    assert np.isnan(many({AREA: np.full(40, 1e-4)})["mean lateral_force"]).all()


def test_a_point_that_is_refused_is_refused_as_by_itself():
    values, errors = np.full(40, 1e-4), []
    values[7] = -1.0
    for wrong in (values, -1.0):
        with pytest.raises(InputError) as error:
            made(OF_GAP, MEAN)({AREA: wrong})
        errors.append(error.value.problems)
    assert errors[0] == errors[1]
    with pytest.raises(InputError, match="not a free parameter"):
        made(OF_GAP, MEAN)({"load.normal_force": np.full(40, 1.0)})


def test_arrays_keep_their_shape_and_the_last_point_is_the_one_that_is_judged():
    many = made(OF_GAP, MEAN, "peak current")
    found = many({SKIN: np.linspace(1e-4, 4e-4, 40).reshape(5, 8)})
    assert {name: values.shape for name, values in found.items()} == dict.fromkeys(many.quantities, (5, 8))
    assert many.diagnostics == made(OF_GAP.replace({SKIN: 4e-4}), MEAN).diagnostics


def test_a_budget_that_is_spent_ends_the_arrays():
    def spent(done, count):
        raise BudgetError([f"{done} of {count}"])

    with pytest.raises(BudgetError, match="0 of 40"):
        made(OF_GAP, MEAN)({AREA: np.full(40, 1e-4)}, progress=spent)


SCENARIO = "vezzoli_2014/fig6_gap"
COEFFICIENT, LATERAL = "friction.coefficient", "lateral_force"
FREE = (SKIN, COEFFICIENT)
NAMES = (FORCE, LATERAL)


@pytest.mark.parametrize(
    "scenario", [SCENARIO, "kaczmarek_2006/gap_biphasic", "vezzoli_2014/fig2_tremor", "vardar_2017/square"]
)
def test_a_finger_has_the_signals_of_prepare_whatever_the_others(scenario):
    time, given = np.linspace(0.0, 0.02, 40), around(ev.load(scenario), 3, FREE)
    given[SKIN][2] = given[SKIN][1]
    found = Population(scenario, FREE, NAMES, time).signals(given)
    whole = ParametricScenario(ev.load(scenario), FREE).of_many(given, names=NAMES, time=time)
    for finger in range(3):
        point = {path: values[finger] for path, values in given.items()}
        expected = prepare(scenario, free=FREE).signals(point, names=NAMES, time=time)
        for name in NAMES:
            assert found[name].shape == (3, 40)
            np.testing.assert_array_equal(whole[name][finger], expected[name])
            peak = np.nanmax(np.abs(expected[name]))
            np.testing.assert_allclose(found[name][finger], expected[name], rtol=0, atol=1e-12 * peak)


def test_the_times_are_those_of_the_scenario_unless_given_and_an_omitted_path_keeps_its_value():
    member, found = OF_GAP, Population(SCENARIO, FREE, [LATERAL])
    np.testing.assert_array_equal(found.time, member.time.times(member.drive))
    assert found.frequency is None
    given = around(OF_GAP, 2, FREE)
    left = found.signals({SKIN: given[SKIN]})[LATERAL]
    assert left.shape == (2, len(found.time))
    kept = found.signals({SKIN: given[SKIN], COEFFICIENT: np.full(2, member.friction.coefficient)})[LATERAL]
    np.testing.assert_array_equal(left, kept)


def test_signals_over_frequency_are_those_of_simulate():
    found, thickness = Population(SCENARIO, [SKIN], ["mean_force", "impedance"]), [1e-4, 3e-4]
    assert found.time is None
    signals = found.signals({SKIN: np.array(thickness)})
    for finger, value in enumerate(thickness):
        trace = ev.simulate(ev.load(SCENARIO, changes={SKIN: value}), signals=["mean_force", "impedance"])
        np.testing.assert_array_equal(found.frequency, trace.frequency)
        for name in ("mean_force", "impedance"):
            np.testing.assert_allclose(signals[name][finger], trace[name].values, rtol=1e-12)


BETWEEN = ["stack.gap.thickness"]
TIMES = [[], [0.0, 0.0], [1e-3, 0.0], [-1e-3, 0.0], [0.0, np.nan], [0.0, np.inf], [[0.0, 1.0]]]


@pytest.mark.parametrize(
    ("free", "names", "time", "words"),
    [
        (["stack.gap.thicknes"], [FORCE], None, "Did you mean 'stack.gap.thickness'"),
        (BETWEEN, ["electrostatic_forc"], None, "Did you mean 'electrostatic_force'"),
        (["time.duration"], [FORCE], None, "the grid is the same for all fingers"),
        ([], [FORCE], None, "name at least one parameter"),
        (BETWEEN, [FORCE, "mean_force"], None, "ask for one kind"),
        (BETWEEN, ["time"], None, "not a signal"),
        *[(BETWEEN, [FORCE], time, "time: expected") for time in TIMES],
    ],
)
def test_what_does_not_exist_and_wrong_times_are_refused(free, names, time, words):
    with pytest.raises(InputError, match=words):
        Population(SCENARIO, free, names, time=time)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({SKIN: [], COEFFICIENT: []}, "at least one finger"),
        ({"contact.area": [1e-4]}, "not a free parameter"),
        ({SKIN: [1e-4, 2e-4], COEFFICIENT: [0.5]}, "one value for each finger"),
    ],
)
def test_wrong_draws_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        Population(SCENARIO, FREE).signals(given)
    engine = ParametricScenario(ev.load(SCENARIO), FREE)
    draws = {SKIN: np.array([1e-4, 1.0]), COEFFICIENT: np.array([0.5, 0.5])}
    with pytest.raises(InputError, match=r"finger 1 of the call: stack.stratum_corneum.thickness = 1,"):
        engine.of_many(draws, names=[FORCE], time=np.array([0.0, 1e-3]))
