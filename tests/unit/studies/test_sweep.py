"""Sweeps: numbers for each case, each at the times that its own drive needs, and the checks of all cases."""

import json

import numpy as np
import pytest

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.exports.save import save
from electrovib.papers import palmar_1995
from electrovib.physics.material.tabulated import Tabulated
from electrovib.scenario import load, scenario_of
from electrovib.solve.quantities import cases
from electrovib.solve.quantities.answer import answer
from electrovib.solve.quantities.cases import answers
from electrovib.solve.quantities.names import DEFAULTS, read_name
from electrovib.solve.quantities.resolve import solved
from electrovib.solve.simulate import simulate
from electrovib.studies.felt_spectrum import lines
from electrovib.studies.perceive import perceive
from electrovib.studies.sweep import _scenarios, over_all, parse_over, sweep

SCENARIO = load("vezzoli_2014/fig6")
MEAN, PEAK, THICKNESS = "mean electrostatic_force", "peak electrostatic_force", "stack.insulator.thickness"
SETTLED = {"time.initial_state": {"model": "PeriodicState"}}
SINE = {"drive": {"model": "Sine", "amplitude": 100, "frequency": 100}} | SETTLED


def high(*values):
    return {"drive.high": list(values)}


def checks(trace):
    return {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}


def test_every_case_of_twenty_frequencies_equals_its_own_run():
    """A former fault: all cases on the time grid of the slowest gave 0.1 mN instead of 386 mN at 10 kHz."""
    scenario = load("vezzoli_2014/fig2").replace(SINE | {"drive.amplitude": 1000})
    frequencies, asked = np.geomspace(10, 1e4, 20), [MEAN, "peak current"]
    trace = sweep(scenario, {"drive.frequency": frequencies}, quantity=asked, records=True)
    for place, frequency in enumerate(frequencies):
        alone = scenario.replace({"drive.frequency": float(frequency)})
        record, case = simulate(alone), trace.isel({"drive.frequency": place})
        np.testing.assert_array_equal(case.time.values, record.time.values)
        np.testing.assert_allclose(case.electrostatic_force, record.electrostatic_force, rtol=1e-12, atol=0)
        numbers = sweep(alone, {}, quantity=asked)
        for name in asked:
            assert float(case[name]) == pytest.approx(float(numbers[name]), rel=1e-12)
        in_whole_periods = record.electrostatic_force.values[:-1].mean()
        assert float(case[MEAN]) == pytest.approx(in_whole_periods, rel=1e-12)


def test_a_quantity_for_every_combination_as_numbers_and_as_a_table(tmp_path):
    over = high("100 V", "1 kV") | {THICKNESS: [10e-6, 90e-6, 100e-6]}
    trace = sweep(SCENARIO, over, quantity=["peak  electrostatic force"])
    assert list(trace.data_vars) == [PEAK]
    assert trace[PEAK].dims == ("drive.high", THICKNESS)
    np.testing.assert_allclose(trace[PEAK][1], 100 * trace[PEAK][0], rtol=1e-12)  # square of the voltage
    alone = simulate(SCENARIO.replace({"drive.high": 1000.0, THICKNESS: 10e-6}))
    assert float(trace[PEAK][1, 0]) == pytest.approx(float(alone.electrostatic_force.max()), rel=1e-3)
    assert (trace[THICKNESS].attrs["units"], trace[PEAK].attrs["units"]) == ("m", "N")
    assert 0 <= trace[PEAK].attrs["numerical_error"] < 1e-9
    assert scenario_of(trace) == SCENARIO
    assert json.loads(trace.attrs["over"])["drive.high"] == [100.0, 1000.0]
    assert json.loads(trace.attrs["quantities"]) == [PEAK]
    assert (trace.attrs["records"], trace.attrs["taken_over"]) == (0, "the whole time")
    assert trace.attrs["solver"] == "transient"
    assert trace.identical(sweep(SCENARIO, over | high(100.0, 1000.0), quantity=[PEAK]))
    (file,) = save(trace, tmp_path / "table.csv")
    rows = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    assert rows[0] == f"drive.high [V],{THICKNESS} [m],{PEAK} [N]"
    assert len(rows) == 7
    assert [float(part) for part in rows[5].split(",")] == [1000.0, 90e-6, float(trace[PEAK][1, 1])]


def test_the_usual_quantities_answer_if_none_is_asked_and_without_parameters_there_is_one_case():
    seen = []
    trace = sweep(SCENARIO, high(100.0, 200.0), progress=lambda done, cases: seen.append((done, cases)))
    assert seen == [(0, 2), (1, 2)]
    assert list(trace.data_vars) == list(DEFAULTS)
    assert "time" not in trace.coords
    frame = trace.to_dataframe()
    assert (list(frame.index), list(frame.columns)) == ([100.0, 200.0], list(DEFAULTS))
    trace = sweep(SCENARIO, {}, quantity=[MEAN])
    assert trace[MEAN].dims == ()
    assert "at" in checks(trace)["electrowetting"]
    assert "largest at" not in checks(trace)["electrowetting"]["text"]


def test_records_have_their_own_times_and_nothing_after_their_end():
    measured = {"model": "Sampled", "time_samples": [0, 1e-3, 3e-3], "voltage_samples": [0, 9, 0]}
    scenario, durations = SCENARIO.replace({"drive": measured, "time.duration": 3e-3}), [1e-3, 2e-3, 3e-3]
    trace = sweep(scenario, {"time.duration": durations}, records=True)
    assert trace.electrostatic_force.dims == ("time.duration", "sample")
    for place, duration in enumerate(durations):
        alone = simulate(scenario.replace({"time.duration": duration}))
        swept, count = trace.isel({"time.duration": place}), alone.sizes["time"]
        times, field = swept.time.values, swept.field.values
        np.testing.assert_array_equal(times[:count], alone.time.values)
        assert {0, 1e-3, duration} <= set(times)
        assert np.nanmax(times) == duration
        np.testing.assert_allclose(field[:, :count], alone.field.values, rtol=1e-12)
        assert np.isnan(times[count:]).all()
        assert np.isnan(field[:, count:]).all()
    assert np.isnan(trace.time.values[0, -1])
    assert not np.isnan(trace.time.values[-1, -1])
    assert trace.mean_force.dims == ("time.duration", "frequency")


# checks


def test_each_check_tells_its_own_largest_value_and_where():
    """The largest voltage and the largest current occur in different cases."""
    over = {"drive.amplitude": [20.0, 200.0], "drive.frequency": [10.0, 100.0, 1000.0]}
    scenario, name = (
        SCENARIO.replace(SINE | {"stack.insulator.breakdown_field": 1e8}),
        "film strength, insulator",
    )
    found = checks(sweep(scenario, over))
    wet, current = found["electrowetting"], found["current"]
    assert wet["value"] == pytest.approx(200.0, rel=1e-3)
    assert wet["at"]["drive.amplitude"] == 200.0
    assert current["at"] == {"drive.amplitude": 200.0, "drive.frequency": 1000.0}
    assert current["text"].endswith("; largest at drive.amplitude = 200 V, drive.frequency = 1 kHz")
    largest = scenario.replace({"drive.amplitude": 200.0})
    each = (simulate(largest.replace({"drive.frequency": at})) for at in over["drive.frequency"])
    assert found[name]["value"] == pytest.approx(
        max(checks(trace)[name]["value"] for trace in each), rel=1e-5
    )
    found = checks(sweep(SCENARIO, high(100.0, 200.0, 1000.0)))["electrowetting"]
    assert (found["state"], found["cases"]) == ("warning", 1)
    assert found["text"].endswith("; largest at drive.high = 1 kV, warning in 1 of 3 cases")
    same = checks(sweep(SCENARIO, {"drive.rise": [1e-3, 2e-3]}))["electrowetting"]
    assert same["text"].endswith("; the same in all 2 cases")


def judged(value=None, limit=None, *, state="ok", text="x"):
    return [Diagnostic("x", state, text, value, limit, "V")]


def told(*cases):
    at = [({"a": float(place)}, diagnostics) for place, diagnostics in enumerate(cases)]
    return over_all(at, words=lambda at: f"a = {at['a']:g}")


def test_the_largest_is_relative_to_the_limit_of_its_case_and_what_cannot_be_judged_is_told_beside_it():
    (found,) = told(judged(5.0, 10.0), judged(6.0, 100.0), [])
    assert (found["value"], found["at"]) == (5.0, {"a": 0.0})
    (found,) = told(judged(5.0, 10.0), judged(1e-3, 0.0), judged(np.nan, 1.0))
    assert found["at"] == {"a": 1.0}
    first, second = told(judged(1.0, 10.0) + judged(9.0, 10.0), judged(3.0, 10.0) + judged(2.0, 10.0))
    assert (first["value"], second["value"]) == (3.0, 9.0), "a check of two layers stays two"
    unknown = judged(state="unknown", text="no law")
    known, unknown = told(judged(1.0, 10.0), unknown, judged(2.0, 10.0))
    assert (known["value"], known["at"]) == (2.0, {"a": 2.0})
    assert (unknown["state"], unknown["cases"], unknown["at"]) == ("unknown", 1, {"a": 1.0})
    assert unknown["text"] == "no law; in 1 of 3 cases, the first at a = 1"


@pytest.mark.parametrize(
    ("cases", "state", "text"),
    [
        (["ok fine", "warning bad", "warning worse"], "warning", "bad; in 2 of 3 cases, the first at a = 1"),
        (["ok fine", "ok fine"], "ok", "fine"),
        (["ok a1", "ok a2"], "ok", "a1; in all cases, this is the one at a = 0"),
    ],
)
def test_words_without_a_number(cases, state, text):
    (found,) = told(*(judged(state=each.split()[0], text=each.split()[1]) for each in cases))
    assert (found["state"], found["text"]) == (state, text)


def test_advice_on_samples_silences_every_case_when_it_is_followed():
    """A former fault: the advice "use 2073 samples" led to the advice "use 5559"."""
    over = {"drive.frequency": np.geomspace(10, 1e4, 8)}
    scenario = SCENARIO.replace(SINE | {"time.duration": 0.5, "time.samples": 2001})
    advice = checks(sweep(scenario, over, records=True, quantity=[MEAN]))["sampling"]
    assert advice["at"] == {"drive.frequency": pytest.approx(1e4)}
    samples = int(advice["text"].partition("time.samples = ")[2].split()[0])
    assert "sampling" not in checks(sweep(scenario.replace({"time.samples": samples}), over, records=True))
    assert "sampling" not in checks(sweep(scenario, over)), "numbers do not depend on output times"


# what is refused


def test_ranges_are_read_with_units_wrong_ones_told_at_once_and_cases_that_cannot_be_solved_with_their_values():
    found = parse_over(SCENARIO, ["drive.rise=1ms:100ms:3log", "drive.high=0:1 kV:5"])
    np.testing.assert_allclose(found["drive.rise"], [1e-3, 1e-2, 1e-1], rtol=1e-12)
    np.testing.assert_allclose(found["drive.high"], [0, 250, 500, 750, 1000])
    wrong = ["drive.rise=1ms:2ms", "drive.rize=1ms:2ms:3", "drive.high=1 m:2 m:3", "frequency.low=1:2:3"]
    with pytest.raises(InputError) as error:
        parse_over(SCENARIO, wrong)
    assert len(error.value.problems) == 4
    with pytest.raises(InputError, match=r"does not repeat.*\(at drive.high = 100 V\)"):
        sweep(SCENARIO.replace(SETTLED), high(100.0, 200.0))


NAMES = ["peak curent", "detection levle"]
PATHS = {"drive.hihg": [1.0], "drive.high": 5.0, "frequency.low": [1.0, 2.0]}


@pytest.mark.parametrize(
    ("over", "asked", "words"),
    [
        (PATHS, NAMES, ["drive.high", "at least one", "share the grid", "'current'", "'detection level'"]),
        (
            high("100 V", "1 kg") | {"drive.rise": [None, 1e-3]},
            None,
            ["drive.high = '1 kg'", "drive.rise = None"],
        ),
        ({THICKNESS: [-1e-6, 1e-6, -2e-6]}, None, [THICKNESS, "-2e-06"]),
        ({THICKNESS: np.linspace(-2e-6, -1e-6, 20)}, None, [*[THICKNESS] * 10, "and 10 more like these"]),
    ],
)
def test_all_wrong_names_paths_and_values_are_told_at_once_before_the_work(over, asked, words):
    with pytest.raises(InputError) as error:
        sweep(SCENARIO, over, quantity=asked, records=True, progress=pytest.fail)
    assert len(error.value.problems) == len(words)
    for each in words:
        assert each in str(error.value)


# what is felt


def test_what_is_felt_can_be_asked_of_every_case_and_a_calibrated_level_follows_the_voltage():
    square = {"model": "Square", "high": 100, "low": -100, "frequency": 60, "edge": 1e-4}
    asked = ["detection level", "relative level", MEAN]
    trace = sweep(SCENARIO.replace({"drive": square}), high(100.0, 200.0), quantity=asked)
    assert list(trace.data_vars) == asked
    assert np.isfinite([trace[name] for name in asked[:2]]).all()
    detected = checks(trace)["detection level"]
    assert detected["state"] == "unknown"
    assert "assumed from publications: a detection threshold" in detected["text"]
    assert trace["relative level"].attrs["units"] == "dB"
    skin = {"model": "ElasticViscousSkin", "stiffness": 1000.0, "corner": 100.0}
    person = {"compliance": skin, "threshold": 1e-7, "threshold_uncertainty": 3.0}
    scenario = load("vardar_2017/square").replace({"perception": person})
    levels = sweep(scenario, high(100.0, 200.0), quantity=["detection level"])["detection level"]
    assert float(levels[1]) == perceive(scenario, set={"drive.high": 200.0}).sensation


def test_the_swing_counts_from_the_value_just_before_a_window():
    """A step of the force from 0.2 N to between 1 and 1.5 N at the beginning of the window enters the swing in full."""
    values = 1.25 + 0.25 * np.sin(2 * np.pi * np.arange(64) / 64)
    whole = (1.5 - 0.2) / 2
    for sign, before, swing in ((1, 0.2, whole), (-1, 0.2, whole), (1, values[-1], 0.25), (1, 1.3, 0.25)):
        found = lines(sign * values, span=1.0, before=sign * before, signal="lateral_force", how="")
        assert found.swing == pytest.approx(swing)


# cases that share a stack are solved at once, with the numbers, errors and diagnostics of each on its own

FIG6, BAU = "vezzoli_2014/fig6", "bau_2010/sine"
TONE = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": 1e3}} | SETTLED
ASKED = [
    "mean electrostatic_force",
    "swing lateral_force",
    "peak current",
    "rms field in insulator",
    "minimum drive_voltage",
]
SKIN = {"stack.stratum_corneum.material": palmar_1995.skins()["dry_men"].material.to_dict()}
OVER = {"stack.insulator.thickness": [1e-6, 30e-6], "drive.frequency": [3e-1, 10.0, 1e3, 3e5]}
LOUD = OVER | {"drive.amplitude": [20.0, 500.0]}
MODULATED = {"model": "AmplitudeModulation", "amplitude": 50, "carrier": 1e3, "modulation": 100, "depth": 0.5}
GROWING = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}
TABLE = {"stack.stratum_corneum.material": {"model": "Tabulated"} | Tabulated.example}
INEXACT = ("transfer_error", "attraction_error")
"""Least squares, of which the last digits depend on how many cases share one matrix."""


def settled(preset, changes):
    return load(preset).replace(TONE | changes)


def assert_same(found, alone):
    """Compare the answer of a case with that of the case alone."""
    assert list(found.values) == list(alone.values)
    ours, theirs = ([*each.values.values()] for each in (found, alone))
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)
    np.testing.assert_allclose([*found.errors.values()], [*alone.errors.values()], atol=1e-15)
    exact = [each.how | dict.fromkeys(INEXACT, 0) for each in (found, alone)]
    assert exact[0] == exact[1]
    for name in INEXACT:
        assert found.how.get(name, 0) == pytest.approx(alone.how.get(name, 0), rel=1e-8)
    for each, other in zip(found.diagnostics, alone.diagnostics, strict=True):
        words = [(one.name, one.state, one.text, one.unit) for one in (each, other)]
        assert words[0] == words[1]
        numbers = [np.array([one.value, one.limit], float) for one in (each, other)]
        np.testing.assert_allclose(*numbers, rtol=1e-9)


@pytest.mark.parametrize(
    ("preset", "changes", "over", "alone"),
    [
        (FIG6, SKIN, LOUD, 4),  # alone are those whose materials need another band
        ("vezzoli_2014/fig6_gap", SKIN, LOUD, 4),
        (BAU, {}, LOUD, 4),
        (FIG6, TABLE, {"drive.frequency": [3.0, 5.0, 100.0, 1e3, 3e5, 4e5]}, 6),
        (BAU, {"drive": MODULATED}, {"drive.amplitude": [3.0, 40.0], "drive.depth": [0.2, 1.0]}, 0),
        (FIG6, {"drive": MODULATED}, {"drive.amplitude": [3.0, 40.0]}, 0),
        (BAU, {"drive": MODULATED}, {"drive.modulation": [100.0, 200.0, 250.0]}, 3),
        (BAU, {"drive": MODULATED}, {"drive.modulation": [50.0, 100.0, 50.0]}, 1),
        # the area under the larger attraction is not resolved by the first pieces
        (BAU, {"contact": GROWING}, {"drive.amplitude": [20.0, 300.0], "drive.phase": [0.0, 1.0]}, 2),
        (BAU, {"limits.rms_current": 1e-6}, {"drive.amplitude": [20.0, 60.0]}, 0),
        (BAU, {}, {"drive.amplitude": [0.0, 20.0, 40.0], "drive.offset": [0.0, 5.0]}, 4),
        (BAU, {"friction.coefficient": 0.3}, {"drive.frequency": [30.0, 300.0]}, 0),
    ],
)
def test_cases_of_one_stack_answer_as_each_alone(preset, changes, over, alone, monkeypatch):
    scenario = settled(preset, changes)
    names = [read_name(text, tuple(scenario.stack.layers)) for text in ASKED]
    grid = np.array(np.meshgrid(*over.values(), indexing="ij")).reshape(len(over), -1)
    points = [dict(zip(over, values, strict=True)) for values in grid.T.tolist()]
    found = answers(_scenarios(scenario, points), names)
    asked_alone = []
    monkeypatch.setattr(
        "electrovib.solve.quantities.cases.answer",
        lambda expanded, names: asked_alone.append(expanded) or answer(expanded, names),
    )
    for point in points:
        own = answer(solved(scenario.replace(point)), names)
        assert_same(next(found), own)
        if changes is TABLE:  # below its first frequency
            remembered = point["drive.frequency"] >= Tabulated.example["frequency_samples"][0]
            assert ("memory" in [each.name for each in own.diagnostics]) == remembered
    assert len(asked_alone) <= alone if over is LOUD or changes is TABLE else len(asked_alone) == alone


def test_cases_with_other_numbers_of_tones_are_apart():
    """One sine, two sines, and a drive that is no sum of tones: those of one form are computed together."""
    scenario = settled(BAU, {})
    sines = [{"model": "Sine", "amplitude": 30.0, "frequency": each} for each in (100.0, 200.0, 300.0)]
    drives = [
        sines[0],
        {"model": "Sum", "drives": [sines[0], sines[2]]},
        {"model": "Square", "high": 30.0, "low": -30.0, "frequency": 100.0},
        sines[1],
    ]
    names = [read_name(text, tuple(scenario.stack.layers)) for text in ASKED]
    members = [scenario.replace({"drive": each}) for each in drives]
    for found, member in zip(answers(members, names), members, strict=True):
        assert_same(found, answer(solved(member), names))


def test_a_sweep_is_the_same_in_any_order_of_its_parameters():
    scenario = settled(FIG6, SKIN)
    one, other = (sweep(scenario, dict(each), quantity=ASKED) for each in (OVER, reversed(OVER.items())))
    for name in ASKED:
        np.testing.assert_allclose(other[name].transpose(*one[name].dims), one[name], rtol=1e-12)
    judged = [json.loads(trace.attrs["validity"]) for trace in (one, other)]
    ours, theirs = ({each["name"]: each["value"] for each in found if "value" in each} for found in judged)
    assert ours == pytest.approx(theirs, rel=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"time.initial_state": {"model": "AtRest"}},
        {"drive.offset": 20.0},
        {"load.time_profile": {"model": "Press", "begin": 0.0, "rise": 0.1}},
        {"drive.amplitude": 0.0},
        {"drive": {"model": "Square", "high": 50, "frequency": 100}},
        {"circuit.amplifier": {"model": "Amplifier", "bandwidth": 1e4}},
    ],
)
def test_other_drives_states_and_circuits_are_left_to_their_own_solvers(change):
    scenario = settled(BAU, {})
    assert cases.is_of_tones(scenario)
    assert not cases.is_of_tones(scenario.replace(change))


def test_a_drive_of_nothing_among_others_and_more_cases_than_are_held_at_once(monkeypatch):
    trace = sweep(settled(FIG6, {}), {"drive.amplitude": [0.0, 1.0, 2.0]}, quantity=ASKED[:1])
    values = trace["mean electrostatic_force"].values
    assert values[0] == 0
    np.testing.assert_allclose(values[2], 4 * values[1], rtol=1e-12)
    monkeypatch.setattr("electrovib.solve.quantities.cases.MOST", 260)  # three of 86 times
    frequencies = [100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0]
    scenario, asked = settled(FIG6, {}), ["peak current"]
    found = sweep(scenario, {"drive.frequency": frequencies}, quantity=asked)["peak current"].values
    each = (sweep(scenario.replace({"drive.frequency": at}), {}, quantity=asked) for at in frequencies)
    np.testing.assert_allclose(found, [float(alone["peak current"]) for alone in each], rtol=1e-12)


def test_a_load_that_changes_bends_the_signals_of_a_sine():
    """The pieces end where the load begins to rise, so that the mean of the friction is exact."""
    pressed = {"load.time_profile": {"model": "Press", "begin": 0.13e-3, "rise": 0.31e-3}}
    scenario = settled(FIG6, {"drive.amplitude": 1e-3} | pressed)
    trace = sweep(scenario, {}, quantity=["mean normal_force", "minimum normal_force"])
    share = (0.5 * 0.31e-3 + 1e-3 - 0.44e-3) / 1e-3
    assert float(trace["mean normal_force"]) == pytest.approx(scenario.load.normal_force * share, rel=1e-12)
    assert float(trace["minimum normal_force"]) == pytest.approx(0.0, abs=1e-15)


def test_felt_quantities_alone_are_swept():
    """No signal is computed for their pieces."""
    swept = {"drive.amplitude": [10.0, 20.0]}
    alone = sweep("bau_2010/sine", swept, quantity=["detection level"])
    beside = sweep("bau_2010/sine", swept, quantity=["detection level", "mean electrostatic_force"])
    np.testing.assert_allclose(alone["detection level"], beside["detection level"], rtol=1e-12)
