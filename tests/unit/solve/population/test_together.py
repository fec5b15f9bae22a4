"""Fingers in arrays are the same fingers as one by one, and no finger depends on the others."""

import functools
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.solve.one_by_one import ParametricScenario
from electrovib.solve.population import Population, arrays
from electrovib.solve.population import fingers as computed
from electrovib.solve.population.columns import check_values, shared_reductions, with_columns
from electrovib.solve.stack.transfer import NotInArraysError

EQUAL = 1e-12
SCALED = 1e-6
"""Where a permittivity is scaled: the least squares of the scaled one end elsewhere within their own error, which is 1e-5 in
these scenarios; responses differ by up to 1e-7 of the peak."""
GAP, SINE, KIM = "vezzoli_2014/fig6_gap", "bau_2010/sine", "kim_2015/current"
BETWEEN, SKIN, FILM = "stack.gap.thickness", "stack.stratum_corneum.thickness", "stack.insulator.thickness"
MATERIAL = "stack.stratum_corneum.material"
PERIODIC = {"time.initial_state": {"model": "PeriodicState"}}
CASES = {
    GAP: f"{FILM} {BETWEEN} stack.gap.material.conductivity {MATERIAL}.permittivity contact.area "
    "circuit.source_resistance drive.high friction.coefficient load.normal_force",
    "vezzoli_2014/fig6": f"stack.insulator.material.permittivity {SKIN}",
    "vezzoli_2014/fig2": f"{BETWEEN} circuit.return_path.resistance",
    "kaczmarek_2006/biphasic": f"drive.drives.0.high drive.drives.1.high {BETWEEN}",
    "kang_2017/offset": f"drive.drive.amplitude drive.drive.offset {FILM}",
    SINE: f"drive.amplitude {MATERIAL}.conductivity contact.area",
    "strong_1970/display_gap": "stack.insulator.material.permittivity circuit.source_resistance",
    "rauf_2025/field_3": f"circuit.return_path.area contact.area {BETWEEN}",
    "nakamura_2017/charged": f"stack.gap.initial_charge {BETWEEN} drive.level",
}


@pytest.mark.parametrize("scenario", CASES)
def test_all_paths_at_once_agree_with_one_by_one(fingers, scenario):
    fingers.assert_together(scenario, CASES[scenario].split(), (*fingers.OVER_TIME, "current"))


def floating(**more):
    return {"circuit.return_path": {"model": "Floating", "capacitance": 150e-12, **more}}


def drives(*each):
    return {"drive": {"model": "Sum", "drives": list(each)}}


SQUARE = {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}
PULSES = {"model": "PulseTrain", "high": 40.0, "width": 2e-3, "frequency": 120.0, "edge": 1e-3}
STEP = {"model": "Step", "level": 20.0}
HELD = {"circuit.source_resistance": 0.0, "circuit.return_path": {"model": "Grounded", "resistance": 0.0}}
DEBYE = {"model": "Debye", "permittivity_high": 4.0, "strength": 1100.0, "relaxation_time": 1e-3}
DEBYE |= {"conductivity": 1e-6}
TERMS = [{"strength": 900.0, "relaxation_time": 2e-3}, {"strength": 300.0, "relaxation_time": 2e-5}]
PRONY = {"model": "Prony", "permittivity_high": 50.0, "terms": TERMS, "conductivity": 0.0}
SPOTS = {"model": "BridgedAir", "bridged_share": 0.01, "spot_conductivity": 1e-6}
CHARGED = {"stack.insulator.initial_charge": 1e-6}


def of_sine(amplitude, phase=0.0, frequency=100.0):
    return {"model": "Sine", "amplitude": amplitude, "phase": phase, "frequency": frequency}


RETURN, CONTACT = "circuit.return_path", {"model": "SecondElectrode", "area": 5e-5}
POWER = {"model": "PowerLaw", "coefficient": 0.6, "at_force": 1.0, "exponent": -0.2}
PRESS = {"model": "Press", "rise": 0.05}
FIRST, SECOND, THIRD = (f"drive.drives.{place}" for place in range(3))
OTHERS = {
    "floating with a leak": (
        floating(leak=1e8, charge=1e-9),
        f"{RETURN}.capacitance {RETURN}.leak {RETURN}.resistance contact.area",
    ),
    "floating and charged": (
        floating(charge=1e-9) | CHARGED,
        f"{RETURN}.charge stack.insulator.initial_charge {FILM} drive.high drive.low",
    ),
    "second electrode": ({RETURN: CONTACT}, f"{RETURN}.area {BETWEEN}"),
    "without resistance": (HELD, f"drive.high {BETWEEN} {MATERIAL}.conductivity"),
    "Debye": ({MATERIAL: DEBYE}, " ".join(f"{MATERIAL}.{each}" for each in list(DEBYE)[1:])),
    "Prony": ({MATERIAL: PRONY}, f"{MATERIAL}.terms.0.strength {SKIN}"),
    "bridged air": ({"stack.gap.material": SPOTS}, f"stack.gap.material.spot_conductivity {BETWEEN}"),
    "power law": ({"friction": POWER}, "friction.coefficient friction.exponent load.normal_force"),
    "pressed": ({"load.time_profile": PRESS}, "load.normal_force friction.coefficient"),
    "square with an amplitude": ({"drive": SQUARE}, f"drive.amplitude {BETWEEN}"),
    "periodic square": ({"drive": SQUARE} | PERIODIC, f"drive.high drive.low {BETWEEN}"),
    "corners after the last output": (
        {"drive": SQUARE | {"frequency": 5.0}} | PERIODIC,
        f"drive.frequency {BETWEEN}",
    ),
    "sine and step": (drives(of_sine(50.0), STEP), f"{FIRST}.amplitude {SECOND}.level {FILM}"),
    "periodic square and pulses": (
        drives(SQUARE, PULSES) | PERIODIC,
        f"{FIRST}.high {SECOND}.high {BETWEEN}",
    ),
    "periodic square, step and sine": (
        drives(SQUARE, STEP, of_sine(5.0, frequency=120.0)) | PERIODIC,
        f"{FIRST}.low {SECOND}.level {THIRD}.amplitude {BETWEEN}",
    ),
    "edges of other lengths": ({}, f"drive.rise drive.hold drive.high {BETWEEN}"),
}


@pytest.mark.parametrize(("changes", "free"), OTHERS.values(), ids=OTHERS)
def test_other_circuits_materials_frictions_and_drives_agree(fingers, changes, free):
    """The scenario has a drive that repeats, or an own time: 61 times of it."""
    time = np.linspace(0, 0.04 if "model" in changes.get("time.initial_state", {}) else 0.1, 61)
    names = (*fingers.OVER_TIME, "current")
    fingers.assert_together(ev.load(GAP).replace(changes), free.split(), names, time=time)


LEAKING = {"circuit.return_path": {"model": "Floating", "capacitance": 1e-10, "leak": 1e9}}
CHARGE = "stack.insulator.initial_charge"
OF_A_LAW = ("electrostatic_force", "lateral_force", "drive_voltage", "effective_voltage")
OF_A_CURRENT = ("electrostatic_force", "interface_field", "field", "stack_voltage", "current")


@pytest.mark.parametrize(
    ("scenario", "changes", "free", "names"),
    [
        (SINE, {}, f"drive.phase drive.frequency drive.amplitude {FILM}", None),
        ("kang_2017/offset", {}, "drive.drive.frequency drive.drive.offset", None),
        # charge at time 0, trapped and relaxing; in the periodic state only trapped charge remains
        ("vezzoli_2014/fig2", {}, f"{CHARGE} {FILM}", None),
        ("strong_1970/display_gap", LEAKING, f"circuit.return_path.charge {FILM} drive.amplitude", None),
        (SINE, {}, f"{CHARGE} {FILM} drive.amplitude", None),
        ("vezzoli_2014/fig6", {}, f"{CHARGE} {FILM}", None),
        # a law of magnitudes, over time; it sees the sum of two sines of one frequency
        ("vezzoli_2014/fig7", {}, f"{SKIN} {MATERIAL}.exponent drive.amplitude", OF_A_LAW),
        (
            "vezzoli_2014/fig7",
            drives(of_sine(50.0), of_sine(80.0, 1.0)) | {"time.duration": 0.02, "time.samples": 1601},
            f"{SKIN} drive.drives.1.amplitude",
            ("electrostatic_force", "drive_voltage"),
        ),
        # a law of many gaps
        (
            "persson_2018/coating",
            {},
            f"force.mean_gap force.rms_gap {FILM} {SKIN} drive.amplitude",
            ("electrostatic_force", "lateral_force"),
        ),
        (KIM, {}, f"drive.amplitude {BETWEEN} {FILM} {SKIN}", OF_A_CURRENT),
        (KIM, CHARGED, f"{CHARGE} {BETWEEN} contact.area", ("electrostatic_force", "field", "displacement")),
    ],
)
def test_other_drives_charges_and_laws_agree(fingers, scenario, changes, free, names):
    member = ev.load(scenario).replace(changes)
    fingers.assert_together(member, free.split(), names or fingers.OVER_TIME)


@pytest.mark.slow
@pytest.mark.parametrize("scenario", [each.name for each in ev.scenarios()])
def test_every_path_of_every_scenario_agrees_with_one_by_one(fingers, scenario):
    member = ev.load(scenario)
    if any(layer.leak for layer in member.stack.layers.values()) or member.motion.moved_gap is not None:
        assert "the electrical solver is" in Population(member, ["friction.coefficient"]).method
        return
    several, time = [], fingers.times_of(member, 100)
    for path, value, _ in member.parameters():
        if value is None or path.startswith(("time.", "frequency.")):
            continue
        if not Population(member, [path], fingers.OVER_TIME, time).method.startswith("together"):
            continue
        assert agreement(fingers, member, [path], 2, time) < limit_of(member, [path]), path
        several.append(path)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        free = [path for path in several if rng.random() < 0.5]
        assert not free or agreement(fingers, member, free, 3, time, seed) < limit_of(member, free), free


def limit_of(member, free):
    """The limit of agreement: wider only where the permittivity of a dispersive layer is scaled."""
    dispersive = [name for name, layer in member.stack.layers.items() if layer.material.debye() is None]
    starts = tuple(f"stack.{name}.material." for name in dispersive)
    scaled = [path for path in free if path.startswith(starts) and not path.endswith(".conductivity")]
    return SCALED if starts and scaled else EQUAL


def agreement(fingers, member, free, count, time, seed=1):
    """The difference from one by one; 0 where both refuse, as a rough contact all of whose layers conduct."""
    try:
        return max(fingers.difference(member, free, count=count, seed=seed, time=time)[0].values())
    except InputError:
        given_ = fingers.draw(member, free, count, seed)
        many = Population(member, free, fingers.OVER_TIME, time)
        alone = functools.partial(
            ParametricScenario(member, free).of_many, names=fingers.OVER_TIME, time=time
        )
        for way in (alone, many.signals):
            with pytest.raises(
                InputError, match=r"interface_field|has a mean|does not repeat|every layer conducts"
            ):
                way(many.columns(given_))
        return 0.0


def test_a_scaled_skin_keeps_its_relaxations(fingers):
    """The reduction of each finger is that of the scenario times a factor, with the same relative error."""
    member, times = ev.load("vardar_2017/square"), fingers.times_of(ev.load("vardar_2017/square"), 100)
    free = [f"{MATERIAL}.{name}" for name in ("permittivity", "reference_frequency", "conductivity")]
    found, method = fingers.difference(member, free, ["electrostatic_force"], count=2, time=times)
    assert method.startswith("together")
    assert found["electrostatic_force"] < SCALED

    given_ = fingers.draw(member, free[:1], 3)[free[0]][:, np.newaxis]
    known = shared_reductions(member, (free[0],), times)["stratum_corneum"]
    material = member.stack.layers["stratum_corneum"].material
    scaled, frequency = with_columns(material, {"permittivity": given_}), np.geomspace(1.0, 1e6, 21)
    expected = given_ / material.permittivity * known.debye.permittivity(frequency)
    assert np.allclose(known.of_fingers(scaled).permittivity(frequency), expected, rtol=1e-13, atol=0)
    conducting = shared_reductions(member, (free[2],), times)["stratum_corneum"]
    assert conducting.of_fingers(material) is conducting.debye
    with pytest.raises(NotInArraysError, match="has to reduce by itself"):  # a permittivity of another shape
        shared_reductions(member, (f"{MATERIAL}.exponent",), times)


OVER_FREQUENCY = ("mean_force", "impedance", "field_gain", "permittivity")


@pytest.mark.parametrize(
    ("scenario", "free", "more"),
    [
        (GAP, f"{BETWEEN} stack.gap.material.conductivity contact.area", ()),
        (
            "vezzoli_2014/fig7",
            f"{SKIN} drive.amplitude {MATERIAL}.permittivity {MATERIAL}.exponent {MATERIAL}.conductivity",
            ("effective_voltage_gain",),
        ),
        ("vardar_2017/sine", f"{MATERIAL}.permittivity circuit.source_resistance", ()),
        (
            "rauf_2025/relaxor",
            "circuit.return_path.area stack.insulator.material.terms.0.strength "
            "stack.insulator.material.terms.0.broadening",
            (),
        ),
    ],
)
def test_signals_over_frequency_agree_with_one_by_one(fingers, scenario, free, more):
    draws = fingers.draw(ev.load(scenario), free.split(), 3, spread=0.2)
    fingers.assert_together(scenario, free.split(), OVER_FREQUENCY + more, draws=draws)


def test_outputs_at_and_beside_corners_agree(fingers):
    member, period = ev.load(GAP).replace({"drive": SQUARE}), 1 / 60
    beside = [np.nextafter(period, 0), np.nextafter(period, 1)]
    time = np.unique([0.0, period / 2, *beside, 1.5 * period, 2.25 * period])
    for some in (time, time[2:], np.array([0.3])):
        fingers.assert_together(member, [BETWEEN], time=some)


@pytest.mark.parametrize(
    ("scenario", "free", "names", "count"),
    [
        (GAP, CASES[GAP], None, 1031),
        (GAP, f"drive.rise drive.high {BETWEEN}", None, 17),
        ("vardar_2017/square", f"{SKIN} {MATERIAL}.conductivity", ("electrostatic_force", "current"), 1031),
        (SINE, CASES[SINE], ("mean_force", "impedance", "field_gain"), 200),
    ],
)
def test_a_finger_does_not_depend_on_the_company_or_on_the_parts_in_memory(
    monkeypatch, fingers, scenario, free, names, count
):
    """In calls of 1, 7 and many fingers; and with responses of 3 fingers at once, of stacks of 7."""
    member, free, names = ev.load(scenario), free.split(), names or fingers.OVER_TIME
    time = None if "mean_force" in names else fingers.times_of(member, 100)
    many, draws = Population(member, free, names, time), fingers.draw(member, free, count)
    draws[free[0]][[1, 5, 6]] = draws[free[0]][0]
    whole = many.signals(draws)

    def assert_parts(*parts):
        for part in parts:
            found = many.signals({path: values[part] for path, values in draws.items()})
            for name in names:
                for mine, its in zip(found[name], whole[name][part], strict=True):
                    scale = np.nanmax(np.abs(its), initial=0.0) if time is not None else np.abs(its)
                    known = ~np.isnan(its)
                    assert np.array_equal(known, ~np.isnan(mine))
                    assert np.all((np.abs(mine - its) <= EQUAL * scale)[known])

    assert_parts(slice(5, 6), slice(count - 1, None), slice(3, 10), slice(7, None), slice(None, None, -1))
    for name, value in {"STACKS": 7, "RESPONSES": 1, "FEWEST": 3}.items():
        monkeypatch.setattr(computed, name, value)
    many = Population(member, free, names, time)
    assert many.method.startswith("together")
    assert_parts(slice(0, 17))


@pytest.mark.parametrize(("scenario", "way"), [(GAP, "together"), (KIM, "one by one")])
def test_signals_in_parts_are_those_of_one_call(fingers, scenario, way):
    member, free, names = ev.load(scenario), [BETWEEN, FILM], ("electrostatic_force", "drive_voltage")
    many = Population(member, free, names, fingers.times_of(member, 100))
    draws = fingers.draw(member, free, 11)
    assert many.method.startswith(way)
    expected, seen = many.signals(draws), []
    for part, signals in many.parts(draws):
        seen += np.arange(11)[part].tolist()
        for name in names:
            np.testing.assert_array_equal(signals[name], expected[name][part])
    assert sorted(seen) == list(range(11))


def test_a_stack_that_arrays_refuse_is_computed_one_by_one(monkeypatch, fingers):
    """Only the second of three stacks of fingers has a finger with fewer modes."""
    member, free = ev.load(GAP), [BETWEEN, "contact.area"]
    many, draws = Population(member, free, time=fingers.times_of(member)), fingers.draw(member, free, 8)
    expected = many.signals(draws)["electrostatic_force"]
    monkeypatch.setattr(computed, "STACKS", 3)
    known, calls = arrays.linear_quantities, []

    def sometimes(*each):
        calls.append(each)
        if len(calls) == 2:
            raise NotInArraysError("fewer modes")
        return known(*each)

    monkeypatch.setattr(arrays, "linear_quantities", sometimes)
    assert fingers.close(many.signals(draws)["electrostatic_force"], expected)
    assert len(calls) == 3


def test_fingers_of_another_form_are_those_of_one_by_one(monkeypatch, fingers):
    """A conductivity of 0 among others, and two equal rates, have another number of modes."""
    member = ev.load(GAP)
    free = ["stack.gap.material.conductivity", SKIN, "circuit.source_resistance"]
    draws = fingers.draw(member, free, 12)
    draws[free[0]][[2, 7]] = draws[free[2]][[3, 7]] = 0.0
    many = Population(member, free, time=fingers.times_of(member))
    # fingers with the same numbers of 0 have the same modes: none is alone
    with monkeypatch.context() as patch:
        patch.setattr(ParametricScenario, "of_many", None)
        assert np.all(np.isfinite(many.signals(draws)["electrostatic_force"]))
    fingers.assert_together(
        member, free[:2], OVER_FREQUENCY[:1], draws={path: draws[path] for path in free[:2]}
    )
    skin, gap = member.stack.stratum_corneum.material, member.stack.gap.material
    draws[free[0]][4] = skin.conductivity / skin.permittivity * gap.permittivity
    fingers.assert_together(member, free, draws=draws)
    whole = many.signals(draws)["electrostatic_force"]
    for finger in range(12):
        one = many.signals({path: values[[finger]] for path, values in draws.items()})
        assert fingers.close(one["electrostatic_force"][0], whole[finger])


FORCE = "electrostatic_force"
DAHL = {"model": "Dahl", "steady": {"model": "Coulomb", "coefficient": 0.5}, "stiffness": 1e3}


@pytest.mark.parametrize(
    ("scenario", "changes", "free", "name", "words"),
    [
        ("vezzoli_2014/fig7", {}, "drive.frequency", FORCE, "changes more of the drive"),
        (GAP, {}, BETWEEN, "capacitance", "the signal capacitance"),
        (KIM, {}, "contact.area", "drive_voltage", "the drive is a current"),
        ("kaczmarek_2006/gap_positive", {}, "contact.area", FORCE, "solver is 'nonlinear branch'"),
        ("shultz_2018/sliding", {}, "motion.speed", "lateral_force", "motion.speed is no number of"),
        (GAP, {"circuit.amplifier": {"gain": 2.0}}, BETWEEN, FORCE, "amplifier before the plate"),
        (GAP, {"friction": DAHL}, BETWEEN, "lateral_force", "Dahl has a memory"),
        ("kaczmarek_2006/gap_positive", {}, "contact.area", "mean_force", "nonlinear branch"),
        (SINE, {}, "drive.frequency", "mean_force", "more of the drive than its amplitude"),
    ],
)
def test_what_is_one_by_one_has_a_reason(scenario, changes, free, name, words):
    time = None if name == "mean_force" else np.linspace(0.0, 0.2, 5)
    many = Population(ev.load(scenario).replace(changes), [free], [name], time)
    assert many.method.startswith("one by one: ")
    assert words in many.method
    assert many.kernel == "one scenario at a time"


def test_a_formula_that_takes_no_arrays_is_computed_one_by_one(monkeypatch):
    law = type(ev.load("persson_2018/coating").force)
    whole = law.amplitudes
    monkeypatch.setattr(
        law, "amplitudes", lambda self, section: float(self.mean_gap) and whole(self, section)
    )
    many = Population(
        "persson_2018/coating", ["force.mean_gap"], ["electrostatic_force"], np.linspace(0, 0.02, 5)
    )
    assert many.method.startswith("one by one: a formula of the scenario does not run on arrays")


@pytest.mark.slow
def test_models_of_users_pass_their_tests():
    """In a process of their own, because a model that is declared is offered everywhere from then on."""
    file = Path(__file__).with_name("models_of_users.py")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
    assert "29 passed" in done.stdout


def test_values_outside_their_range_are_refused_and_its_ends_are_within():
    many = Population(GAP, [BETWEEN, "contact.area"])
    words = r"stack.gap.thickness = 1: must lie between .*finger 1 of the call"
    with pytest.raises(InputError, match=words) as error:
        many.signals({BETWEEN: [1e-6, 1.0], "contact.area": [np.nan, 1e-4]})
    assert len(error.value.problems) == 2
    quantity = quantity_at(ev.load(GAP), BETWEEN)
    check_values(ev.load(GAP), {BETWEEN: quantity}, {BETWEEN: np.array([quantity.low, quantity.high])})
    for beyond in (np.nextafter(quantity.low, -1.0), np.nextafter(quantity.high, np.inf)):
        values = {BETWEEN: np.array([quantity.low, quantity.high, beyond])}
        with pytest.raises(InputError, match=r"finger 2 of the call"):
            check_values(ev.load(GAP), {BETWEEN: quantity}, values)


def test_values_that_a_model_refuses_together_are_refused_for_the_finger_that_has_them():
    material = DEBYE | {"model": "HavriliakNegami", "broadness": 0.8, "skewness": 0.6}
    member, paths = ev.load("vezzoli_2014/fig6").replace({MATERIAL: material}), {}
    for name in ("broadness", "skewness"):
        paths[f"{MATERIAL}.{name}"] = quantity_at(member, f"{MATERIAL}.{name}")
    draws = dict(zip(paths, np.array([[0.8, 0.5, 0.9], [1.2, 1.9, 1.2]]), strict=True))
    with pytest.raises(InputError, match=r"broadness \* skewness is 1.08.*finger 2 of the call"):
        check_values(member, paths, draws)
    check_values(member, paths, {path: values[:2] for path, values in draws.items()})


def shared(scenario, free, columns, names=("lateral_force", "current")):
    """Signals of fingers that have stacks in common, and of the same fingers one by one."""
    member = ev.load(scenario)
    many = Population(member, free, names, member.time.times(member.drive)[::40])
    assert many.method == computed.TOGETHER
    expected = ParametricScenario(member, free).of_many(columns, names=names, time=many.time)
    return many, many.signals(columns), expected


@pytest.mark.parametrize(
    ("scenario", "free"),
    [
        (GAP, f"{BETWEEN} drive.high friction.coefficient"),
        ("kaczmarek_2006/biphasic", f"drive.drives.0.high {BETWEEN} drive.drives.1.high"),
        ("nakamura_2017/charged", f"stack.gap.initial_charge drive.level {BETWEEN}"),
        ("rauf_2025/field_3", f"contact.area {BETWEEN}"),
        (GAP, "drive.high friction.coefficient"),
    ],
)
def test_fingers_of_one_stack_share_its_response(fingers, scenario, free, monkeypatch):
    """Stacks in turn, not beside each other, so that rows are put in order and back; one has two areas in series."""
    free = free.split()
    columns = fingers.draw(ev.load(scenario), free, 40)
    for path in free:
        if path.startswith(("stack.", "circuit.")):
            columns[path] = np.tile(columns[path][:4], 10)
    stacks = []
    known = computed.Population.asked

    def asked(self, member):
        found = known(self, member)
        stacks.extend(np.size(each.direct) for each in found.values())
        return found

    monkeypatch.setattr(computed.Population, "asked", asked)
    many, found, expected = shared(scenario, free, columns)
    stacks.clear()
    found = many.signals(columns)
    shares = (
        scenario != "rauf_2025/field_3"
    )  # a second contact: its share of the voltage differs with the area
    assert (max(stacks) <= 4) == shares
    for name, rows in found.items():
        peak = np.max(np.abs(expected[name]), axis=-1, keepdims=True)
        assert np.all(np.abs(rows - expected[name]) <= EQUAL * peak), name


def test_the_area_and_the_load_do_not_change_a_stack_with_nothing_in_series(fingers):
    alone = ev.load(GAP, changes=HELD)
    free = ["contact.area", "load.normal_force"]
    columns = fingers.draw(alone, free, 40)
    for names, changes, count in (
        (("lateral_force",), {}, 1),
        (("lateral_force", "current"), {}, 40),
        (("lateral_force",), {"circuit.source_resistance": 1e5}, 40),
        (("lateral_force",), {"circuit.return_path": floating()["circuit.return_path"]}, 40),
        (("lateral_force",), {"circuit.return_path": CONTACT | {"resistance": 0.0}}, 40),
    ):
        member = alone.replace(changes)
        many, found, expected = shared(member, free, columns, names)
        first_of, _ = many._stacks(columns)
        assert len(np.arange(40)[first_of]) == count, changes
        np.testing.assert_allclose(found["lateral_force"], expected["lateral_force"], rtol=1e-10)


def test_a_finger_has_the_same_bits_alone_and_beside_others_of_its_stack(fingers):
    free = [BETWEEN, "drive.high", "friction.coefficient"]
    columns = fingers.draw(ev.load(GAP), free, 30)
    columns[BETWEEN] = np.tile(columns[BETWEEN][:3], 10)
    many, found, _ = shared(GAP, free, columns, ("lateral_force",))
    for place in (0, 17):
        alone = many.signals({path: values[place : place + 1] for path, values in columns.items()})
        np.testing.assert_array_equal(alone["lateral_force"][0], found["lateral_force"][place])


def test_a_fast_mode_after_a_late_corner_is_compared_up_to_the_rounding_of_the_times():
    """After half a second that rounding is 1e-7 of a nanosecond, so that 1e-10 of the force differ there; means do not."""
    slow = ev.measurements("rauf_2025/frequency_150V")["rauf_2025/frequency_150V"].scenario
    slow = slow.replace({"drive.frequency": 1.0})
    mean = "mean electrostatic_force"
    prepared = ev.prepare(slow, free=[BETWEEN], quantity=[mean])
    gaps = np.linspace(4e-6, 8e-6, 40)
    found = prepared({BETWEEN: gaps})[mean]
    assert prepared.method == computed.TOGETHER
    for place in (0, 39):
        alone = ev.prepare(slow, free=[BETWEEN], quantity=[mean])({BETWEEN: gaps[place]})
        assert found[place] == pytest.approx(alone[mean], rel=1e-9)
