"""Fingers in arrays are the same fingers as one by one, and no finger depends on the others."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.solve.population import arrays, population
from electrovib.solve.population.columns import check_values, shared_reductions, with_columns
from electrovib.solve.stack.transfer import NotInArraysError

_SPEC = importlib.util.spec_from_file_location("fingers_of", Path(__file__).with_name("fingers_of.py"))
fingers_of = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(fingers_of)
difference, draw, times_of = fingers_of.difference, fingers_of.draw, fingers_of.times_of

EQUAL = 1e-12
SCALED = 1e-6
"""Where a permittivity is scaled: the least squares of the scaled one end elsewhere within their own error, which is 1e-5 in
these scenarios; responses differ by up to 1e-7 of the peak."""
GAP = "vezzoli_2014/fig6_gap"
CASES = {
    GAP: (
        "stack.insulator.thickness",
        "stack.gap.thickness",
        "stack.gap.material.conductivity",
        "stack.stratum_corneum.material.permittivity",
        "contact.area",
        "circuit.source_resistance",
        "drive.high",
        "friction.coefficient",
        "load.normal_force",
    ),
    "vezzoli_2014/fig6": ("stack.insulator.material.permittivity", "stack.stratum_corneum.thickness"),
    "vezzoli_2014/fig6_static": ("stack.stratum_corneum.material.permittivity", "drive.low"),
    "vezzoli_2014/fig2": ("stack.gap.thickness", "circuit.return_path.resistance"),
    "kaczmarek_2006/biphasic": ("drive.drives.0.high", "drive.drives.1.high", "stack.gap.thickness"),
    "kang_2017/offset": ("drive.drive.amplitude", "drive.drive.offset", "stack.insulator.thickness"),
    "bau_2010/sine": ("drive.amplitude", "stack.stratum_corneum.material.conductivity", "contact.area"),
    "strong_1970/display": ("drive.amplitude", "stack.insulator.thickness"),
    "strong_1970/display_gap": ("stack.insulator.material.permittivity", "circuit.source_resistance"),
    "rauf_2025/field_3": ("circuit.return_path.area", "contact.area", "stack.gap.thickness"),
    "shultz_2018/at_rest": ("stack.stratum_corneum.thickness", "friction.coefficient"),
    "nakamura_2017/charged": ("stack.gap.initial_charge", "stack.gap.thickness", "drive.level"),
    "nakamura_2017/rise": ("stack.gap.material.conductivity", "stack.stratum_corneum.thickness"),
}
SKIN = {
    "vardar_2017/square": ("stack.stratum_corneum.thickness", "stack.stratum_corneum.material.conductivity"),
    "aliabbasi_2022/maximum": ("stack.stratum_corneum.thickness", "stack.gap.thickness"),
    "rauf_2025/relaxor": ("stack.insulator.thickness", "circuit.return_path.area"),
}


def close(one, other):
    """Whether signals agree to 1e-12 of the peak, NaN included."""
    peak = np.nanmax(np.abs(other), initial=0.0)
    return np.allclose(one, other, rtol=0, atol=EQUAL * peak, equal_nan=True)


def is_together(method):
    return method.startswith("together")


@pytest.mark.parametrize("scenario", CASES)
def test_all_paths_at_once_agree_with_one_by_one(scenario):
    found, method = difference(scenario, CASES[scenario])
    assert is_together(method)
    assert found < EQUAL


@pytest.mark.parametrize("scenario", [*CASES, "kim_2015/current"])
def test_currents_agree_with_one_by_one(scenario):
    """To 1e-10: rounding of the time decides what remains of the fastest mode after a corner."""
    free = CASES.get(scenario, ("stack.insulator.thickness", "stack.stratum_corneum.thickness"))
    found, method = difference(scenario, free, ["current"])
    assert is_together(method)
    assert found < 1e-10


@pytest.mark.parametrize(
    ("scenario", "free"),
    [
        (GAP, ("drive.rise", "stack.gap.thickness")),
        (GAP, ("drive.hold", "drive.high", "friction.coefficient")),
        ("bau_2010/sine", ("drive.phase", "drive.amplitude", "stack.insulator.thickness")),
        ("bau_2010/sine", ("drive.frequency", "contact.area")),
        ("kang_2017/offset", ("drive.drive.frequency", "drive.drive.offset")),
        ("strong_1970/display", ("drive.frequency",)),
    ],
)
def test_drives_of_other_times_and_frequencies_agree_with_one_by_one(scenario, free):
    found, method = difference(scenario, free)
    assert is_together(method), method
    assert found < EQUAL


def test_a_law_of_magnitudes_over_time_agrees_with_one_by_one():
    free = ("stack.stratum_corneum.thickness", "stack.stratum_corneum.material.exponent", "drive.amplitude")
    names = ("electrostatic_force", "lateral_force", "drive_voltage", "effective_voltage")
    found, method = difference("vezzoli_2014/fig7", free, names)
    assert is_together(method), method
    assert found < EQUAL


def test_a_law_of_magnitudes_sees_the_sum_of_two_sines_of_one_frequency():
    member = ev.load("vezzoli_2014/fig7")
    sine = {"model": "Sine", "amplitude": 50.0, "frequency": 100.0}
    member = member.replace(
        {"drive": {"model": "Sum", "drives": [sine, sine | {"phase": 1.0, "amplitude": 80.0}]}}
    )
    free = ("stack.stratum_corneum.thickness", "drive.drives.1.amplitude")
    names = ("electrostatic_force", "drive_voltage")
    found, method = difference(member, free, names, time=np.linspace(0.0, 0.02, 41))
    assert is_together(method), method
    assert found < EQUAL


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(sorted(CASES)), st.data())
def test_any_combination_agrees_with_one_by_one(scenario, data):
    free = data.draw(st.lists(st.sampled_from(CASES[scenario]), min_size=1, unique=True))
    names = data.draw(st.lists(st.sampled_from(fingers_of.OVER_TIME), min_size=1, max_size=3, unique=True))
    found, method = difference(
        scenario,
        free,
        names,
        count=2,
        seed=data.draw(st.integers(0, 99)),
        time=times_of(ev.load(scenario), 100),
    )
    assert is_together(method)
    assert found < EQUAL


@pytest.mark.slow
@pytest.mark.parametrize("scenario", [each.name for each in ev.scenarios()])
def test_every_path_of_every_scenario_agrees_with_one_by_one(scenario):
    member = ev.load(scenario)
    marched = any(layer.leak for layer in member.stack.layers.values()) or member.motion.moved_gap is not None
    if marched:
        free = ["friction.coefficient"]
        assert "the electrical solver is" in population(member, free).method
        return
    several, time = [], times_of(member, 100)
    for path, value, _ in member.parameters():
        if value is None or path.startswith(("time.", "frequency.")):
            continue
        if not is_together(population(member, [path], fingers_of.OVER_TIME, time).method):
            continue
        found, method = agreement(scenario, [path], count=2, time=time)
        assert found < limit_of(member, [path]), (path, method)
        several.append(path)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        free = [path for path in several if rng.random() < 0.5]
        if free:
            found, method = agreement(scenario, free, count=3, seed=seed, time=time)
            assert found < limit_of(member, free), (free, method)


def limit_of(member, free):
    """The limit of agreement: wider only where the permittivity of a dispersive layer is scaled."""
    dispersive = [name for name, layer in member.stack.layers.items() if layer.material.debye() is None]
    starts = tuple(f"stack.{name}.material." for name in dispersive)
    scaled = [path for path in free if path.startswith(starts) and not path.endswith(".conductivity")]
    return SCALED if starts and scaled else EQUAL


def agreement(scenario, free, count, time, seed=1):
    """The difference from one by one; 0 where both refuse, as a leaky film under a voltage with a mean."""
    try:
        return difference(scenario, free, count=count, seed=seed, time=time)
    except InputError:
        member = ev.load(scenario)
        alone = fingers_of.OneByOne(member, free, fingers_of.OVER_TIME, time)
        with pytest.raises(InputError, match=r"no 'interface_field'|has a mean|does not repeat"):
            alone.signals(population(member, free, time=time).columns(draw(member, free, count, seed)))
        with pytest.raises(InputError, match=r"interface_field|has a mean|does not repeat"):
            population(member, free, fingers_of.OVER_TIME, time).signals(draw(member, free, count, seed))
        return 0.0, "refused"


def test_a_scaled_skin_keeps_its_relaxations():
    """The reduction of each finger is that of the scenario times a factor, with the same relative error."""
    member = ev.load("vardar_2017/square")
    skin = "stack.stratum_corneum.material."
    free = [skin + "permittivity", skin + "reference_frequency", skin + "conductivity"]
    found, method = difference(member, free, ["electrostatic_force"], count=2, time=times_of(member, 100))
    assert is_together(method)
    assert found < SCALED


def test_the_terms_of_a_scaled_skin_are_those_of_the_scenario_times_a_factor():
    member, name = ev.load("vardar_2017/square"), "stratum_corneum"
    path = f"stack.{name}.material.permittivity"
    times, given = times_of(member), draw(member, [path], 3)[path][:, np.newaxis]
    known = shared_reductions(member, (path,), times)[name]
    material = member.stack.layers[name].material
    found = known.of_fingers(with_columns(material, {"permittivity": given}))
    frequency = np.geomspace(1.0, 1e6, 21)
    factors = given / material.permittivity
    expected = factors * known.debye.permittivity(frequency)
    assert np.allclose(found.permittivity(frequency), expected, rtol=1e-13, atol=0)
    conducting = shared_reductions(member, (f"stack.{name}.material.conductivity",), times)[name]
    assert conducting.of_fingers(material) is conducting.debye


def test_a_permittivity_of_another_shape_is_reduced_for_each_finger():
    member = ev.load("vardar_2017/square")
    path = "stack.stratum_corneum.material.exponent"
    with pytest.raises(NotInArraysError, match="has to reduce by itself"):
        shared_reductions(member, (path,), times_of(member))


@pytest.mark.slow
@pytest.mark.parametrize("scenario", SKIN)
def test_reduced_skins_agree_with_one_by_one(scenario):
    found, method = difference(scenario, SKIN[scenario])
    assert is_together(method)
    assert found < EQUAL


@pytest.mark.parametrize(
    ("changes", "free"),
    [
        (
            {"circuit.return_path": {"model": "Floating", "capacitance": 150e-12}},
            ("circuit.return_path.capacitance",),
        ),
        (
            {"circuit.return_path": {"model": "Floating", "capacitance": 150e-12, "leak": 1e8}},
            ("circuit.return_path.leak", "circuit.return_path.resistance", "contact.area"),
        ),
        (
            {
                "circuit.return_path": {"model": "Floating", "capacitance": 150e-12, "charge": 1e-9},
                "stack.insulator.initial_charge": 1e-6,
            },
            (
                "circuit.return_path.charge",
                "stack.insulator.initial_charge",
                "stack.insulator.thickness",
                "drive.high",
                "drive.low",
            ),
        ),
        (
            {"circuit.return_path": {"model": "SecondElectrode", "area": 5e-5}},
            ("circuit.return_path.area", "stack.gap.thickness"),
        ),
        (
            {"circuit.return_path": {"model": "Grounded", "resistance": 0.0}},
            ("stack.gap.thickness", "stack.stratum_corneum.material.conductivity"),
        ),
        (
            {
                "stack.stratum_corneum.material": {
                    "model": "Debye",
                    "permittivity_high": 4.0,
                    "strength": 1100.0,
                    "relaxation_time": 1e-3,
                    "conductivity": 1e-6,
                }
            },
            (
                "stack.stratum_corneum.material.strength",
                "stack.stratum_corneum.material.relaxation_time",
                "stack.stratum_corneum.material.conductivity",
                "stack.stratum_corneum.material.permittivity_high",
            ),
        ),
        (
            {
                "stack.stratum_corneum.material": {
                    "model": "Prony",
                    "permittivity_high": 50.0,
                    "terms": [
                        {"strength": 900.0, "relaxation_time": 2e-3},
                        {"strength": 300.0, "relaxation_time": 2e-5},
                    ],
                    "conductivity": 0.0,
                }
            },
            ("stack.stratum_corneum.material.terms.0.strength", "stack.stratum_corneum.thickness"),
        ),
        (
            {"stack.gap.material": {"model": "BridgedAir", "bridged_share": 0.01, "spot_conductivity": 1e-6}},
            ("stack.gap.material.spot_conductivity", "stack.gap.thickness"),
        ),
        (
            {"friction": {"model": "PowerLaw", "coefficient": 0.6, "at_force": 1.0, "exponent": -0.2}},
            ("friction.coefficient", "friction.exponent", "load.normal_force"),
        ),
        (
            {"load.time_profile": {"model": "Press", "rise": 0.05}},
            ("load.normal_force", "friction.coefficient"),
        ),
        (
            {"drive": {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}},
            ("drive.high", "drive.low"),
        ),
        ({"drive": {"model": "Square", "high": 100.0, "low": -100.0, "frequency": 60.0}}, ("drive.high",)),
        (
            {"drive": {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}},
            ("drive.amplitude", "stack.gap.thickness"),
        ),
        (
            {
                "drive": {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0},
                "time.initial_state": {"model": "PeriodicState"},
            },
            ("drive.high", "stack.gap.thickness"),
        ),
        (
            {"drive": {"model": "PulseTrain", "high": 100.0, "width": 2e-3, "frequency": 50.0, "edge": 1e-4}},
            ("drive.high", "stack.insulator.thickness"),
        ),
        (
            {
                "drive": {
                    "model": "Sum",
                    "drives": [
                        {"model": "Sine", "amplitude": 50.0, "frequency": 35.0},
                        {"model": "Step", "level": 20.0},
                    ],
                }
            },
            ("drive.drives.0.amplitude", "drive.drives.1.level", "stack.insulator.thickness"),
        ),
    ],
)
def test_other_circuits_materials_frictions_and_drives_agree(changes, free):
    member = ev.load(GAP).replace(changes)
    found, method = difference(member, free, time=np.linspace(0, 0.1, 61))
    assert is_together(method), method
    assert found < EQUAL


@pytest.mark.parametrize(
    "scenario", ["vezzoli_2014/fig2", "strong_1970/display_gap", "bau_2010/sine", "vezzoli_2014/fig6"]
)
def test_charge_at_time_0_agrees(scenario):
    """Trapped between blocking layers, relaxing, and without a gap; in the periodic state only trapped charge remains."""
    member = ev.load(scenario)
    free = ["stack.insulator.initial_charge", "stack.insulator.thickness", "drive.amplitude"]
    if scenario == "strong_1970/display_gap":
        free[0] = "circuit.return_path.charge"
        member = member.replace(
            {"circuit.return_path": {"model": "Floating", "capacitance": 1e-10, "leak": 1e9}}
        )
    free = [path for path in free if path in {each for each, _, _ in member.parameters()}]
    found, method = difference(member, free)
    assert is_together(method)
    assert found < EQUAL


def test_outputs_at_and_beside_corners_agree():
    member = ev.load(GAP).replace(
        {"drive": {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}}
    )
    period = 1 / 60
    time = np.unique(
        [0.0, period / 2, np.nextafter(period, 0), np.nextafter(period, 1), 1.5 * period, 2.25 * period]
    )
    assert difference(member, ["stack.gap.thickness"], time=time)[0] < EQUAL
    assert difference(member, ["stack.gap.thickness"], time=time[2:])[0] < EQUAL
    assert difference(member, ["stack.gap.thickness"], time=np.array([0.3]))[0] < EQUAL


@pytest.mark.parametrize("scenario", [GAP, "bau_2010/sine", "strong_1970/display_gap", "vardar_2017/square"])
def test_a_finger_does_not_depend_on_the_others(scenario):
    """For every signal, in calls of 1, 7 and 1024 fingers."""
    member = ev.load(scenario)
    free, names = (CASES | SKIN)[scenario], fingers_of.OVER_TIME
    many = population(member, free, names, times_of(member, 100))
    given = draw(member, free, 1031)
    whole = many.signals(given)
    for size, places in ((1, (0, 5, 1030)), (7, (0, 511, 1024)), (1024, (0, 7))):
        for begin in places:
            part = many.signals({path: values[begin : begin + size] for path, values in given.items()})
            for name in names:
                assert close(part[name], whole[name][begin : begin + size])
    backwards = many.signals({path: values[::-1] for path, values in given.items()})
    for name in names:
        assert close(backwards[name][::-1], whole[name])


@pytest.mark.parametrize(
    ("scenario", "free", "names"),
    [
        (GAP, CASES[GAP], fingers_of.OVER_TIME),
        (GAP, ("drive.rise", "drive.high", "stack.gap.thickness"), fingers_of.OVER_TIME),
        ("strong_1970/display_gap", CASES["strong_1970/display_gap"], ("electrostatic_force", "current")),
        ("bau_2010/sine", CASES["bau_2010/sine"], ("mean_force", "impedance", "field_gain")),
    ],
)
def test_fingers_do_not_depend_on_the_parts_in_memory(monkeypatch, scenario, free, names):
    """Responses of 3 fingers at once, of stacks of 7, are those of all at once."""
    member = ev.load(scenario)
    time = None if "mean_force" in names else times_of(member, 100)
    given = draw(member, free, 17)
    given[free[0]][[1, 5, 6]] = given[free[0]][0]
    expected = population(member, free, names, time).signals(given)
    monkeypatch.setattr(arrays, "STACKS", 7)
    monkeypatch.setattr(arrays, "RESPONSES", 1)
    monkeypatch.setattr(arrays, "FEWEST", 3)
    many = population(member, free, names, time)
    assert is_together(many.method)
    found = many.signals(given)
    for name in names:
        for mine, its in zip(found[name], expected[name], strict=True):
            assert close(mine, its) if mine.dtype.kind == "f" else np.allclose(mine, its, rtol=EQUAL, atol=0)


def test_a_stack_that_arrays_refuse_is_computed_one_by_one(monkeypatch):
    """Only the second of three stacks of fingers has a finger with fewer modes."""
    member, free = ev.load(GAP), ["stack.gap.thickness", "contact.area"]
    many, given = population(member, free, time=times_of(member)), draw(member, free, 8)
    expected = many.signals(given)["electrostatic_force"]
    monkeypatch.setattr(arrays, "STACKS", 3)
    known, calls = arrays.linear_quantities, []

    def sometimes(*each):
        calls.append(each)
        if len(calls) == 2:
            raise NotInArraysError("fewer modes")
        return known(*each)

    monkeypatch.setattr(arrays, "linear_quantities", sometimes)
    assert close(many.signals(given)["electrostatic_force"], expected)
    assert len(calls) == 3


def test_fingers_of_another_form_are_computed_one_by_one():
    """A conductivity of 0 among others, and two equal rates, have another number of modes."""
    member = ev.load(GAP)
    free = ["stack.gap.material.conductivity", "stack.stratum_corneum.thickness", "circuit.source_resistance"]
    given = draw(member, free, 12)
    given[free[0]][[2, 7]] = 0.0
    skin, gap = member.stack.stratum_corneum.material, member.stack.gap.material
    given[free[0]][4] = skin.conductivity / skin.permittivity * gap.permittivity
    assert difference(member, free, draws=given)[0] < EQUAL
    many = population(member, free, time=times_of(member))
    whole = many.signals(given)["electrostatic_force"]
    for finger in range(12):
        one = many.signals({path: values[[finger]] for path, values in given.items()})
        assert close(one["electrostatic_force"][0], whole[finger])


def test_a_number_of_0_leaves_the_others_in_arrays(monkeypatch):
    """Fingers with the same numbers of 0 have the same modes: no finger is computed alone."""
    member = ev.load(GAP)
    free = ["stack.gap.material.conductivity", "stack.stratum_corneum.thickness", "circuit.source_resistance"]
    many, given = population(member, free, time=times_of(member)), draw(member, free, 9)
    given[free[0]][[2, 7]] = 0.0
    given[free[2]][[3, 7]] = 0.0
    alone = []
    monkeypatch.setattr(fingers_of.OneByOne, "signals", lambda _, draws: alone.append(draws))
    found = many.signals(given)
    assert not alone
    assert np.all(np.isfinite(found["electrostatic_force"]))


@pytest.mark.parametrize(
    ("scenario", "free", "names", "words"),
    [
        ("vezzoli_2014/fig7", "drive.frequency", "electrostatic_force", "changes more of the drive"),
        (GAP, "stack.gap.thickness", "capacitance", "the signal capacitance"),
        ("kim_2015/current", "contact.area", "drive_voltage", "the drive is a current"),
        (
            "kaczmarek_2006/gap_positive",
            "contact.area",
            "electrostatic_force",
            "solver is 'nonlinear branch'",
        ),
        ("shultz_2018/sliding", "motion.speed", "lateral_force", "motion.speed is no number of"),
    ],
)
def test_what_is_one_by_one_has_a_reason(scenario, free, names, words):
    many = population(scenario, [free], [names], np.linspace(0.0, 0.2, 5))
    assert many.method.startswith("one by one: ")
    assert words in many.method
    assert many.kernel == "one scenario at a time"


FOLLOWING = {"steady": {"model": "Coulomb", "coefficient": 0.5}, "stiffness": 1e3}


@pytest.mark.parametrize(
    ("changes", "names", "words"),
    [
        ({"circuit.amplifier": {"gain": 2.0}}, ["electrostatic_force"], "amplifier before the plate"),
        ({"friction": {"model": "Dahl"} | FOLLOWING}, ["lateral_force"], "Dahl has a memory"),
    ],
)
def test_what_depends_on_the_past_or_on_an_amplifier_is_one_by_one(changes, names, words):
    member = ev.load(GAP).replace(changes)
    assert words in population(member, ["stack.gap.thickness"], names, np.linspace(0.0, 0.2, 5)).method


@pytest.mark.slow
@pytest.mark.parametrize(("file", "count"), [("laws_of_users", 2), ("models_of_users", 26)])
def test_models_of_users_pass_their_tests(file, count):
    """In a process of their own, because a model that is declared is offered everywhere from then on."""
    file = Path(__file__).with_name(f"{file}.py")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
    assert f"{count} passed" in done.stdout


def test_values_outside_their_range_are_refused():
    many = population(GAP, ["stack.gap.thickness", "contact.area"])
    assert is_together(many.method)
    with pytest.raises(
        InputError, match=r"stack.gap.thickness = 1: must lie between .*finger 1 of the call"
    ) as error:
        many.signals({"stack.gap.thickness": [1e-6, 1.0], "contact.area": [np.nan, 1e-4]})
    assert len(error.value.problems) == 2


def test_the_ends_of_a_range_are_within_it():
    member, path = ev.load(GAP), "stack.gap.thickness"
    quantity = quantity_at(member, path)
    check_values(member, {path: quantity}, {path: np.array([quantity.low, quantity.high])})
    for beyond in (np.nextafter(quantity.low, -1.0), np.nextafter(quantity.high, np.inf)):
        with pytest.raises(InputError, match=r"finger 2 of the call"):
            check_values(member, {path: quantity}, {path: np.array([quantity.low, quantity.high, beyond])})


def test_values_that_a_model_refuses_together_are_refused_for_the_finger_that_has_them():
    material = {
        "model": "HavriliakNegami",
        "permittivity_high": 50.0,
        "strength": 1000.0,
        "relaxation_time": 1e-3,
        "broadness": 0.8,
        "skewness": 0.6,
        "conductivity": 1e-6,
    }
    start = "stack.stratum_corneum.material"
    member = ev.load("vezzoli_2014/fig6").replace({start: material})
    paths = [f"{start}.broadness", f"{start}.skewness"]
    given = {paths[0]: np.array([0.8, 0.5, 0.9]), paths[1]: np.array([1.2, 1.9, 1.2])}
    with pytest.raises(InputError, match=r"broadness \* skewness is 1.08.*finger 2 of the call"):
        check_values(member, {path: quantity_at(member, path) for path in paths}, given)
    fine = {path: values[:2] for path, values in given.items()}
    check_values(member, {path: quantity_at(member, path) for path in paths}, fine)


@pytest.mark.parametrize("scenario", [GAP, "bau_2010/sine", "kaczmarek_2006/biphasic", "kim_2015/current"])
def test_signals_in_parts_are_those_of_one_call(scenario):
    member = ev.load(scenario)
    free = ["stack.gap.thickness", "stack.insulator.thickness"]
    names, time = ("electrostatic_force", "drive_voltage"), times_of(member, 100)
    many, given = population(member, free, names, time), draw(member, free, 11)
    expected = many.signals(given)
    seen = []
    for fingers, signals in many.parts(given):
        seen += np.arange(11)[fingers].tolist()
        for name in names:
            np.testing.assert_array_equal(signals[name], expected[name][fingers])
    assert sorted(seen) == list(range(11))
