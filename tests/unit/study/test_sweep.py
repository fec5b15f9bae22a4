"""Sweeps: numbers for each case, each at the times that its own drive needs."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.data.traces import load_csv
from electrovib.export.save import save
from electrovib.scenario import load, scenario_of
from electrovib.solve.quantities import DEFAULTS
from electrovib.solve.simulate import simulate
from electrovib.study.perceive import perceive
from electrovib.study.sweep import parse_over, sweep
from electrovib.study.sweep.checks import over_all

SCENARIO = load("vezzoli_2014/fig6")
MEAN = "mean electrostatic_force"
SINE = {
    "drive": {"model": "Sine", "amplitude": 100, "frequency": 100},
    "time.initial_state": {"model": "PeriodicState"},
}


def checks(trace):
    return {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}


def test_every_case_of_twenty_frequencies_equals_its_own_run():
    """A former fault: all cases on the time grid of the slowest gave 0.1 mN instead of 386 mN at 10 kHz."""
    scenario = load("vezzoli_2014/fig2").replace(SINE | {"drive.amplitude": 1000})
    frequencies = np.geomspace(10, 1e4, 20)
    trace = sweep(scenario, {"drive.frequency": frequencies}, quantities=[MEAN, "peak current"], records=True)
    for place, frequency in enumerate(frequencies):
        alone = scenario.replace({"drive.frequency": float(frequency)})
        record, case = simulate(alone), trace.isel({"drive.frequency": place})
        np.testing.assert_array_equal(case.time.values, record.time.values)
        np.testing.assert_allclose(case.electrostatic_force, record.electrostatic_force, rtol=1e-12, atol=0)
        numbers = sweep(alone, {}, quantities=[MEAN, "peak current"])
        assert float(case[MEAN]) == pytest.approx(float(numbers[MEAN]), rel=1e-12)
        assert float(case["peak current"]) == pytest.approx(float(numbers["peak current"]), rel=1e-12)
        in_whole_periods = record.electrostatic_force.values[:-1].mean()
        assert float(case[MEAN]) == pytest.approx(in_whole_periods, rel=1e-12)


def test_a_quantity_for_every_combination():
    over = {"drive.high": [100.0, 1000.0], "stack.insulator.thickness": [10e-6, 90e-6, 100e-6]}
    trace = sweep(SCENARIO, over, quantities=["peak electrostatic_force"])
    assert trace["peak electrostatic_force"].dims == ("drive.high", "stack.insulator.thickness")
    assert list(trace.data_vars) == ["peak electrostatic_force"]
    alone = simulate(SCENARIO.replace({"drive.high": 1000.0, "stack.insulator.thickness": 10e-6}))
    assert float(trace["peak electrostatic_force"][1, 0]) == pytest.approx(
        float(alone.electrostatic_force.max()), rel=1e-3
    )
    assert trace["stack.insulator.thickness"].attrs["units"] == "m"
    assert trace["peak electrostatic_force"].attrs["units"] == "N"
    assert 0 <= trace["peak electrostatic_force"].attrs["numerical_error"] < 1e-9


def test_values_with_units_are_read():
    texts = sweep(SCENARIO, {"drive.high": ["100 V", 200, "0.3 kV"]}, quantities=[MEAN])
    numbers = sweep(SCENARIO, {"drive.high": [100.0, 200.0, 300.0]}, quantities=[MEAN])
    assert texts.identical(numbers)
    with pytest.raises(InputError) as caught:
        sweep(SCENARIO, {"drive.high": ["100 V", "1 kg"], "drive.rise": [None, 1e-3]})
    assert [(problem.path, problem.value) for problem in caught.value.problems] == [
        ("drive.high", "'1 kg'"),
        ("drive.rise", "None"),
    ]


def test_the_usual_quantities_answer_if_none_is_asked():
    trace = sweep(SCENARIO, {"drive.high": [100.0, 200.0]})
    assert list(trace.data_vars) == list(DEFAULTS)
    assert "time" not in trace.coords
    frame = trace.to_dataframe()
    assert (len(frame), list(frame.columns)) == (2, list(DEFAULTS))
    assert list(frame.index) == [100.0, 200.0]


def test_force_goes_as_the_square_of_the_voltage():
    trace = sweep(
        SCENARIO, {"drive.high": np.linspace(100, 1000, 4)}, quantities=["peak electrostatic_force"]
    )
    peak = trace["peak electrostatic_force"].values
    np.testing.assert_allclose(peak / peak[0], np.linspace(1, 10, 4) ** 2, rtol=1e-12)


def test_records_have_their_own_times_and_nothing_after_their_end():
    measured = {"model": "Sampled", "time_samples": [0, 1e-3, 3e-3], "voltage_samples": [0, 9, 0]}
    scenario = SCENARIO.replace({"drive": measured, "time.duration": 3e-3})
    durations = [1e-3, 2e-3, 3e-3]
    trace = sweep(scenario, {"time.duration": durations}, records=True)
    assert trace.electrostatic_force.dims == ("time.duration", "sample")
    for place, duration in enumerate(durations):
        alone, swept = (
            simulate(scenario.replace({"time.duration": duration})),
            trace.isel({"time.duration": place}),
        )
        times, count = swept.time.values, alone.sizes["time"]
        np.testing.assert_array_equal(times[:count], alone.time.values)
        assert {0, 1e-3, duration} <= set(times)
        assert np.nanmax(times) == duration
        np.testing.assert_allclose(swept.field.values[:, :count], alone.field.values, rtol=1e-12)
        assert np.isnan(times[count:]).all()
        assert np.isnan(swept.field.values[:, count:]).all()
    assert np.isnan(trace.time.values[0, -1])
    assert not np.isnan(trace.time.values[-1, -1])
    assert trace.mean_force.dims == ("time.duration", "frequency")


def test_a_swept_trace_carries_scenario_axes_and_names():
    trace = sweep(SCENARIO, {"drive.high": [100.0, 200.0]}, quantities=["mean  lateral force"])
    assert scenario_of(trace) == SCENARIO
    assert json.loads(trace.attrs["over"]) == {"drive.high": [100.0, 200.0]}
    assert json.loads(trace.attrs["quantities"]) == ["mean lateral_force"]
    assert (trace.attrs["records"], trace.attrs["taken_over"]) == (0, "the whole time")
    assert trace.attrs["solver"] == "transient"


def test_without_parameters_there_is_one_case():
    trace = sweep(SCENARIO, {}, quantities=[MEAN])
    assert trace[MEAN].dims == ()
    assert "at" in checks(trace)["electrowetting"]
    assert "largest at" not in checks(trace)["electrowetting"]["text"]


def test_the_table_has_one_row_for_each_case(tmp_path):
    over = {"drive.high": [100.0, 200.0], "drive.rise": [1e-3, 2e-3, 3e-3]}
    trace = sweep(SCENARIO, over, quantities=[MEAN])
    (file,) = save(trace, tmp_path / "table.csv")
    rows = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    assert rows[0] == "drive.high [V],drive.rise [s],mean electrostatic_force [N]"
    assert len(rows) == 7
    assert [float(part) for part in rows[5].split(",")] == [200.0, 2e-3, float(trace[MEAN][1, 1])]
    assert load_csv(file).identical(trace)


# checks


def test_each_check_tells_its_own_largest_value_and_where():
    """The largest voltage and the largest current occur in different cases."""
    over = {"drive.amplitude": [20.0, 200.0], "drive.frequency": [10.0, 100.0, 1000.0]}
    scenario = SCENARIO.replace(SINE | {"stack.insulator.breakdown_field": 1e8})
    found = checks(sweep(scenario, over))
    wet, current, film = (found[name] for name in ("electrowetting", "current", "film strength, insulator"))
    assert wet["value"] == pytest.approx(200.0, rel=1e-3)
    assert wet["at"]["drive.amplitude"] == 200.0
    assert current["at"] == {"drive.amplitude": 200.0, "drive.frequency": 1000.0}
    assert current["text"].endswith("; largest at drive.amplitude = 200 V, drive.frequency = 1 kHz")
    name = "film strength, insulator"
    alone = [
        checks(simulate(scenario.replace({"drive.amplitude": 200.0, "drive.frequency": frequency})))[name][
            "value"
        ]
        for frequency in over["drive.frequency"]
    ]
    assert film["value"] == pytest.approx(max(alone), rel=1e-5)


def test_a_warning_says_in_how_many_cases():
    found = checks(sweep(SCENARIO, {"drive.high": [100.0, 200.0, 1000.0]}))["electrowetting"]
    assert (found["state"], found["cases"]) == ("warning", 1)
    assert found["text"].endswith("; largest at drive.high = 1 kV, warning in 1 of 3 cases")
    same = checks(sweep(SCENARIO, {"drive.rise": [1e-3, 2e-3]}))["electrowetting"]
    assert same["text"].endswith("; the same in all 2 cases")


def diagnostic(name, value=None, limit=None, *, state="ok", text="x"):
    return Diagnostic(name, state, text, value, limit, "V")


def told(*cases):
    return over_all(
        [({"a": float(place)}, diagnostics) for place, diagnostics in enumerate(cases)],
        words=lambda at: f"a = {at['a']:g}",
    )


def test_the_largest_is_relative_to_the_limit_of_its_case():
    (found,) = told(
        [diagnostic("x", 5.0, 10.0)], [diagnostic("x", 6.0, 100.0)], [diagnostic("x", 0.4, 0.0)][:0]
    )
    assert (found["value"], found["at"]) == (5.0, {"a": 0.0})
    (found,) = told(
        [diagnostic("x", 5.0, 10.0)], [diagnostic("x", 1e-3, 0.0)], [diagnostic("x", np.nan, 1.0)]
    )
    assert found["at"] == {"a": 1.0}


def test_a_check_of_two_layers_stays_two():
    first, second = told(
        [diagnostic("film", 1.0, 10.0), diagnostic("film", 9.0, 10.0)],
        [diagnostic("film", 3.0, 10.0), diagnostic("film", 2.0, 10.0)],
    )
    assert (first["value"], second["value"]) == (3.0, 9.0)


def test_what_some_cases_cannot_judge_is_told_beside_the_largest():
    judged, unknown = told(
        [diagnostic("x", 1.0, 10.0)],
        [diagnostic("x", state="unknown", text="no law")],
        [diagnostic("x", 2.0, 10.0)],
    )
    assert (judged["value"], judged["at"]) == (2.0, {"a": 2.0})
    assert (unknown["state"], unknown["cases"], unknown["at"]) == ("unknown", 1, {"a": 1.0})
    assert unknown["text"] == "no law; in 1 of 3 cases, the first at a = 1"


def test_words_without_a_number():
    (found,) = told(
        [diagnostic("x", text="fine")],
        [diagnostic("x", state="warning", text="bad")],
        [diagnostic("x", state="warning", text="worse")],
    )
    assert (found["state"], found["text"]) == ("warning", "bad; in 2 of 3 cases, the first at a = 1")
    (found,) = told([diagnostic("x", text="fine")], [diagnostic("x", text="fine")])
    assert found["text"] == "fine"
    (found,) = told([diagnostic("x", text="a 1")], [diagnostic("x", text="a 2")])
    assert found["text"] == "a 1; in all cases, this is the one at a = 0"


def test_advice_on_samples_silences_every_case_when_it_is_followed():
    """A former fault: the advice "use 2073 samples" led to the advice "use 5559"."""
    over = {"drive.frequency": np.geomspace(10, 1e4, 8)}
    scenario = SCENARIO.replace(SINE | {"time.duration": 0.5, "time.samples": 2001})
    advice = checks(sweep(scenario, over, records=True, quantities=[MEAN]))["sampling"]
    assert advice["at"] == {"drive.frequency": pytest.approx(1e4)}
    samples = int(advice["text"].partition("time.samples = ")[2].split()[0])
    assert "sampling" not in checks(sweep(scenario.replace({"time.samples": samples}), over, records=True))
    assert "sampling" not in checks(sweep(scenario, over)), "numbers do not depend on output times"


# what is refused


def test_ranges_are_read_with_units():
    found = parse_over(SCENARIO, ["drive.rise=1ms:100ms:3log", "drive.high=0:1 kV:5"])
    np.testing.assert_allclose(found["drive.rise"], [1e-3, 1e-2, 1e-1], rtol=1e-12)
    np.testing.assert_allclose(found["drive.high"], [0, 250, 500, 750, 1000])


def test_all_wrong_ranges_are_told_at_once():
    with pytest.raises(InputError) as error:
        parse_over(
            SCENARIO,
            ["drive.rise=1ms:2ms", "drive.rize=1ms:2ms:3", "drive.high=1 m:2 m:3", "frequency.low=1:2:3"],
        )
    assert len(error.value.problems) == 4


def test_all_wrong_names_and_paths_are_told_at_once():
    with pytest.raises(InputError) as error:
        sweep(
            SCENARIO,
            {"drive.hihg": [1.0], "drive.high": 5.0, "frequency.low": [1.0, 2.0]},
            quantities=["peak curent", "detection levle"],
            records=True,
        )
    problems = "\n".join(error.value.problems)
    assert len(error.value.problems) == 5
    for words in ("drive.high", "at least one", "share the grid", "'current'", "'detection level'"):
        assert words in problems


def test_every_value_out_of_range_is_refused_before_the_work():
    with pytest.raises(InputError, match=r"stack\.insulator\.thickness") as error:
        sweep(SCENARIO, {"stack.insulator.thickness": [-1e-6, 1e-6, -2e-6]}, progress=pytest.fail)
    assert len(error.value.problems) == 2
    with pytest.raises(InputError, match="and 10 more like these"):
        sweep(SCENARIO, {"stack.insulator.thickness": np.linspace(-2e-6, -1e-6, 20)})


def test_a_case_that_cannot_be_solved_is_told_with_its_values():
    with pytest.raises(InputError, match=r"does not repeat.*\(at drive.high = 100 V\)"):
        sweep(
            SCENARIO.replace({"time.initial_state": {"model": "PeriodicState"}}),
            {"drive.high": [100.0, 200.0]},
        )


def test_progress_counts():
    seen = []
    sweep(SCENARIO, {"drive.high": [1.0, 2.0, 3.0]}, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(0, 3), (1, 3), (2, 3)]


# what is felt


def test_what_is_felt_can_be_asked_of_every_case():
    square = {"model": "Square", "high": 100, "low": -100, "frequency": 60, "edge": 1e-4}
    scenario = SCENARIO.replace({"drive": square})
    trace = sweep(
        scenario, {"drive.high": [100.0, 200.0]}, quantities=["detection level", "relative level", MEAN]
    )
    assert list(trace.data_vars) == ["detection level", "relative level", MEAN]
    assert np.isfinite(trace["detection level"]).all()
    assert checks(trace)["detection level"]["state"] == "unknown"
    assert "assumed from publications: a detection threshold" in checks(trace)["detection level"]["text"]
    assert trace["relative level"].attrs["units"] == "dB"
    assert np.isfinite(trace["relative level"]).all()


def test_a_calibrated_level_follows_the_voltage():
    skin = {"model": "ElasticViscousSkin", "stiffness": 1000.0, "corner": 100.0}
    person = {"compliance": skin, "threshold": 1e-7, "threshold_uncertainty": 3.0}
    scenario = load("vardar_2017/square").replace({"perception": person})
    levels = sweep(scenario, {"drive.high": [100.0, 200.0]}, quantities=["detection level"])[
        "detection level"
    ]
    assert float(levels[1]) == perceive(scenario, set={"drive.high": 200.0}).sensation
