"""A drive compared with limits: every row states value, limit and source, and nothing unlimited is cleared."""

import json
import math
from dataclasses import replace

import numpy as np
import openpyxl
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError
from electrovib.physics.drive.extremes import slew_of
from electrovib.physics.limits import WORDS, Limits, limited
from electrovib.solve.diagnostics.judge import discontinuities
from electrovib.solve.quantities.answer import of_record
from electrovib.studies.check import LimitsFrom, cleared_for_output, sampled
from electrovib.studies.check.function import checked_values
from electrovib.studies.check.result import LINES_TO_ADD, limits_from, strictest
from electrovib.studies.design.limits import Bounds

FIG6 = "vezzoli_2014/fig6"
CAPACITANCE = 8.8541878128e-12 * 1e-4 / (90e-6 / 3.35 + 200e-6 / 1560)
SLOPE = 1000 / 36e-3
SINE = {"model": "Sine", "amplitude": "100 V", "frequency": "1 kHz"}
SETTLED = {"time.initial_state": {"model": "PeriodicState"}}
CLEARED = {"voltage": "1 kV", "current": "250 uA"}


def row(result, quantity):
    return next(each for each in (*result.rows, *result.comparisons) if each.quantity == quantity)


def amplified(**amplifier):
    return {"circuit.amplifier": amplifier}


def step(level):
    return {"model": "Step", "level": level}


def square(low, high):
    return {"model": "Square", "low": low, "high": high, "frequency": 60}


def diagnostics(trace):
    return {each.name: each for each in read_diagnostics(trace.attrs["validity"])}


def test_largest_and_rms_values_of_a_sine_and_of_a_slow_ramp():
    """Between the corners of the ramp the film of 32.96 pF takes C dV/dt; the skin adds less than 1 %."""
    result = ev.check(SINE, FIG6, limits={"voltage": "120 V"})
    voltage = row(result, "peak voltage")
    assert (voltage.value, voltage.limit, voltage.state, voltage.unit) == (100, 120, "pass", "V")
    assert voltage.margin == pytest.approx(1.2)
    assert result.value("rms voltage") == pytest.approx(100 / math.sqrt(2), rel=1e-9)
    assert result.value("slew rate") == pytest.approx(2 * math.pi * 1e3 * 100, rel=1e-12)
    untitled = ev.load(FIG6).replace({"title": ""})
    assert ev.check(untitled).title == "the drive of the scenario"
    result = ev.check(FIG6)
    assert result.title.startswith("the drive of the scenario in: Vezzoli 2014, figure 6")
    assert result.value("peak current") == pytest.approx(32.96e-12 * SLOPE, rel=1e-2)
    assert result.value("slew rate") == pytest.approx(SLOPE)
    for limit, state in ((1000.0, "pass"), (np.nextafter(1000.0, 0), "fail")):
        assert row(ev.check(FIG6, limits={"voltage": limit}), "peak voltage").state == state


FLOATING = {"model": "Floating", "capacitance": 50e-12}, 1 / 50e-12
SECOND = {"model": "SecondElectrode", "area": 0.5e-4}, 2 / CAPACITANCE


@pytest.mark.parametrize(("path", "series"), [FLOATING, SECOND], ids=["floating", "second"])
def test_rms_voltage_of_a_prescribed_current_includes_the_return_path(path, series):
    """The plate is at the voltage of stack and return path together, as the peak is; by the elastances of both."""
    drive = {"model": "CurrentSine", "amplitude": 1e-6, "frequency": 1e3, "phase": math.pi / 2}
    insulates = {"stack.stratum_corneum.material": {"model": "Constant", "permittivity": 1560.0}}
    result = ev.check(drive, "vezzoli_2014/fig6_static", set={"circuit.return_path": path} | insulates)
    expected = 1e-6 * (1 / CAPACITANCE + series) / (2 * math.pi * 1e3)
    assert result.value("peak voltage") == pytest.approx(expected, rel=1e-3)
    assert result.value("rms voltage") == pytest.approx(expected / math.sqrt(2), rel=1e-3)


def test_stray_capacitance_takes_current_that_the_body_does_not():
    found, plain = ev.check(FIG6, set=amplified(stray_capacitance="200 pF")), ev.check(FIG6)
    more = found.value("peak current") - found.value("peak body current")
    assert more == pytest.approx(200e-12 * SLOPE, rel=1e-2)
    assert found.value("stored energy") - plain.value("stored energy") == pytest.approx(1e-4, rel=1e-6)
    stated = [any("No stray capacitance" in note for note in each.notes) for each in (found, plain)]
    assert stated == [False, True]


@pytest.mark.parametrize("name", WORDS)
def test_each_limit_declares_with_which_power_of_the_drive_its_value_grows(name):
    """Designs take this root of value over limit, so that a drive scaled by it is at the limit."""
    one, two = (
        checked_values(ev.load(FIG6).replace({"drive.high": high})).largest[name] for high in (500.0, 1000.0)
    )
    assert two / one == pytest.approx(2 ** limited(name).order, rel=1e-6)
    scenario = ev.load(FIG6).replace({"drive.high": 1000.0, f"limits.{name}": two / 2 ** limited(name).order})
    assert Bounds.of(scenario, None).overload(scenario)[name] == pytest.approx(2, rel=1e-6)


def test_breakdown_of_the_film_and_of_air():
    result = ev.check(FIG6, set={"stack.insulator.breakdown_field": "10 MV/m"})
    film = row(result, "film strength, insulator")
    assert film.value == pytest.approx(1000 / 90e-6, rel=1e-4)
    assert (film.state, film in result.failed, result.state) == ("fail", True, "fail")
    emission = row(ev.check(FIG6, set={"drive.high": "20 kV"}), "field emission")
    assert emission.state == "unknown", "a limit that was cited from memory decides nothing"
    for high, state in (("1 kV", "unknown"), ("2 kV", "fail")):
        assert row(ev.check("vezzoli_2014/fig2", set={"drive.high": high}), "Paschen").state == state


def test_a_solver_by_time_steps_and_many_samples_give_the_same_values():
    """An amplifier far from its limits changes nothing but the solver; one at its limit never passes its target."""
    stray = {"stray_capacitance": "100 pF"}
    limited, free = (ev.check(FIG6, set=amplified(**stray, **own)) for own in ({"source_current": "1 A"}, {}))
    for quantity in ("rms voltage", "rms current", "peak current", "stored energy"):
        assert limited.value(quantity) == pytest.approx(free.value(quantity), rel=1e-2)
    own = amplified(source_current="250 uA", stray_capacitance="200 pF") | {"drive.rise": "0.1 ms"}
    held = ev.check(FIG6, set=own, limits={"voltage": 1000})
    assert [row(held, f"peak {each}").state for each in ("voltage", "current")] == ["pass", "pass"]
    times = np.linspace(0, 0.1, 5001)
    result = ev.check(sampled(times, 50 * np.sin(2 * np.pi * 40 * times)), FIG6)
    assert result.value("rms voltage") == pytest.approx(50 / math.sqrt(2), rel=1e-4)
    lines = of_record("rms", np.array([0.0, 1, 3]), np.array([0.0, 3, 3]))
    assert lines == pytest.approx(math.sqrt((3 + 18) / 3))


@pytest.mark.parametrize("source", [250e-6, 300e-6])
def test_peak_current_never_exceeds_what_the_amplifier_supplies(source):
    """The largest current is that of the limiter, also where the current has a kink between evaluation times."""
    sine = {"model": "Sine", "amplitude": 600, "frequency": 3000}
    own = amplified(bandwidth=1e4, source_current=source, sink_current=240e-6, stray_capacitance=30e-12)
    current = row(ev.check(sine, FIG6, set=own | {"limits.current": source}), "peak current")
    assert (current.value, current.state) == (source, "pass")


def test_a_published_current_decides_nothing():
    result = ev.check("kim_2015/current", limits={"current": "10 mA"})
    above = [each for each in result.comparisons if each.state == "fail"]
    assert [each.limit for each in above] == [250e-6, 0.5e-3]
    assert above[1].value == pytest.approx(1e-3, rel=1e-6), "1 mA rms at 25 kHz"
    assert not result.failed
    assert all(each.state != "pass" for each in result.comparisons if "unverified" in each.source)


def test_the_strictest_limit_counts_with_its_source_and_what_is_not_declared_is_a_number():
    own = LimitsFrom("the scenario", Limits(voltage=1000, current=1e-3), {"voltage": "Section 4"})
    found = strictest([own, LimitsFrom("bench.toml", Limits(voltage=500)), limits_from({"voltage": "800 V"})])
    assert {name: each.value for name, each in found.items()} == {"voltage": 500, "current": 1e-3}
    others = "also declared: 800 V of limits, 1 kV of the scenario"
    assert found["voltage"].source == f"limits.voltage of bench.toml; {others}"
    assert strictest([own])["voltage"].source == "limits.voltage of the scenario (Section 4)"
    limits = [{"rms_voltage": "1 kV"}, {"rms_voltage": "700 V", "slew_rate": "20 kV/s"}]
    result = ev.check(FIG6, limits=limits)
    assert row(result, "rms voltage").limit == 700
    assert row(result, "slew rate").state == "fail"
    assert "rms current" in [each.quantity for each in result.numbers]
    words = r"the rate of change of the drive times the gain reaches 27\.7778 kV/s, above 20 kV/s"
    with pytest.raises(InputError, match=words):
        result.refuse()


LIMITS_FILES = {
    "voltag = 5": "limits.toml: limits.voltag",
    "voltage = 'x'": "limits.toml: limits.voltage",
    "voltage = nan": "finite",
    "voltage = -5.0": "between",
    "voltage =": "not valid TOML",
}


@pytest.mark.parametrize(
    "text", ['[limits]\nvoltage = "500 V"', 'schema = 1\nvoltage = "500 V"', *LIMITS_FILES]
)
def test_limits_of_a_file(tmp_path, text):
    path = tmp_path / "limits.toml"
    path.write_text(text, encoding="utf-8")
    if text in LIMITS_FILES:
        with pytest.raises(InputError, match=LIMITS_FILES[text]):
            ev.check(FIG6, limits=path)
        return
    limited = row(ev.check(FIG6, limits=path), "peak voltage")
    assert (limited.limit, limited.state, limited.source) == (500, "fail", f"limits.voltage of {path}")


@pytest.mark.parametrize(
    ("limits", "missing"),
    [({}, "voltage"), ({"voltage": "2 kV"}, "current"), ({"current": "1 mA"}, "voltage")],
)
def test_nothing_is_cleared_without_the_largest_voltage_and_current(limits, missing):
    scenario = ev.load(FIG6).replace({"limits": {}})
    with pytest.raises(InputError, match=f"limits.{missing}") as refused:
        cleared_for_output(scenario, limits=limits)
    assert LINES_TO_ADD in str(refused.value)
    assert not cleared_for_output(scenario, limits=[limits, CLEARED]).failed
    assert cleared_for_output(scenario.replace({"limits": CLEARED})).rows
    exceeded = r"reaches 1 kV, above 900 V: limits.voltage of limits. Nothing was written"
    with pytest.raises(InputError, match=exceeded):
        cleared_for_output(scenario, limits=CLEARED | {"voltage": "900 V"})


@pytest.mark.parametrize("gain", [200.0, -200.0])
@pytest.mark.parametrize("holding", [{"saturation": "900 V"}, {"bandwidth": "0.1 Hz"}])
def test_what_an_amplifier_leaves_of_a_demanded_voltage_does_not_clear_it(gain, holding):
    """10 V times 200 are 2 kV whatever the sign, although the plate never reaches the limit of 1 kV."""
    scenario = ev.load(FIG6, changes={"drive.high": "10 V"} | amplified(gain=gain, **holding))
    limits = {"voltage": "1 kV", "current": "1 A"}
    assert row(ev.check(scenario, limits=limits), "peak voltage").state == "pass"
    words = r"times the gain of the amplifier reaches 2 kV, above 1 kV: .*does not count"
    with pytest.raises(InputError, match=words):
        cleared_for_output(scenario, limits=limits)


def test_a_declared_limit_that_could_not_be_compared_is_refused():
    result = ev.check(FIG6)
    charge = row(result, "charge")
    unknown = replace(charge, value=None, limit=1.0, state="unknown", text="the charge is not known")
    with pytest.raises(InputError, match=r"the charge is not known\. Nothing was played"):
        replace(result, rows=(unknown,)).refuse("Nothing was played")
    for harmless in (replace(unknown, limit=None), replace(unknown, value=1.0)):
        replace(result, rows=(harmless,)).refuse()
    assert replace(result, rows=()).state == "unknown"


def test_switching_on_counts_and_has_no_bound_without_resistance():
    """At 1 kohm a step of 100 V drives 100 mA at first; a pole charges the film with C V 2 pi f."""
    result = ev.check(step("100 V"), FIG6)
    assert result.value("peak current") == pytest.approx(0.1, rel=1e-6)
    assert row(result, "peak current").state == "fail"
    found = ev.check(step("1 V"), FIG6, limits={"slew_rate": "1 GV/s"})
    assert "has no bound (a discontinuity)" in row(found, "slew rate").text
    bare = {"circuit.return_path.resistance": 0}
    result = ev.check(step("1 V"), FIG6, set=bare, limits={"current": "1 A"})
    assert row(result, "peak current").state == "fail"
    assert result.value("peak current") == result.value("slew rate") == math.inf
    assert json.dumps(result.to_dict(), allow_nan=False)
    result = ev.check(step("100 V"), FIG6, set=bare | amplified(bandwidth="1 kHz"))
    assert result.value("peak current") == pytest.approx(CAPACITANCE * 100 * 2 * math.pi * 1e3, rel=1e-3)


@pytest.mark.parametrize("resistance", [0.0, 1e4])
@pytest.mark.parametrize("stray", [0.0, 50e-12])
def test_a_saturating_amplifier_passes_discontinuities_on(resistance, stray):
    """Without a bandwidth or a largest current the plate's voltage is discontinuous where the limited target is."""
    path = {"circuit.return_path.resistance": resistance} | amplified(saturation=200, stray_capacitance=stray)
    result = ev.check(square(-300, 300), FIG6, set=path, limits={"current": "250 uA"})
    expected = 400 / resistance if resistance else math.inf
    assert result.value("peak body current") == pytest.approx(expected, rel=1e-5)
    assert result.value("peak current") == (math.inf if stray else pytest.approx(expected, rel=1e-5))
    assert row(result, "peak current").state == "fail"
    assert (result.value("rms current") is None) == (resistance == 0 or stray > 0)
    first = 200 / resistance if resistance else math.inf
    held = ev.check(square(300, 900), FIG6, set=path)
    assert held.value("peak body current") == pytest.approx(first, rel=1e-5)


def test_a_jump_up_to_the_saturation_is_the_part_below_it():
    """From 50 to 150 V behind 100 V the plate jumps by 50 V; from 150 to 250 V it does not jump."""
    path = {"circuit.return_path.resistance": 1e4, "time.duration": 9e-3} | amplified(saturation=100)
    for low, high, later in ((50, 150, 50), (150, 250, 0), (-150, -50, 50)):
        scenario = ev.load(FIG6, changes=path | {"drive": square(high, low)})
        expected = max(min(abs(low), 100), later) / 1e4
        assert ev.check(scenario).value("peak body current") == pytest.approx(expected, rel=1e-5)
        passed = discontinuities(scenario, end=9e-3)
        assert (passed[0], passed[1] > 0) == (abs(low), later > 0)


def test_a_discontinuity_charges_the_stray_capacitance_at_once():
    """The current of the amplifier has no bound, that through the finger is bounded by the series resistance."""
    set_up = {"circuit.return_path.resistance": 1e4} | amplified(stray_capacitance=50e-12)
    result = ev.check(square(-300, 300), FIG6, set=set_up)
    assert result.value("peak current") == math.inf
    assert result.value("peak body current") == pytest.approx(600 / 1e4, rel=1e-3)
    trace = ev.simulate(ev.load(FIG6, changes=set_up | {"drive": square(-300, 300)}), signals=["current"])
    words = "into the stray capacitance has no bound, and that through the finger is bounded only by"
    assert words in diagnostics(trace)["discontinuity"].text


@pytest.mark.parametrize("columns", ["time,voltage", "time [s],drive_voltage [V]", ""])
def test_a_drive_from_a_file_and_one_with_nan_or_without_voltage_refused(tmp_path, columns):
    path = tmp_path / "drive.csv"
    path.write_text(f"{columns}\n0,0\n0.001,300\n0.01,0\n".lstrip(), encoding="utf-8")
    result = ev.check(path, FIG6)
    assert (result.value("peak voltage"), result.duration) == (300, 0.01)
    assert result.value("rms voltage") == pytest.approx(300 / math.sqrt(3), rel=1e-9)
    np.save(tmp_path / "drive.npy", np.array([[0, 0], [1, math.nan], [2, 0]]))
    (tmp_path / "drive.csv").write_text("time,force\n0,0\n1,1\n", encoding="utf-8")
    for name in ("drive.npy", "drive.csv"):
        with pytest.raises(InputError, match=name.replace(".", r"\.")):
            ev.check(tmp_path / name, FIG6)
    with pytest.raises(InputError, match=r"scene\.toml: .* give the scenario alone"):
        ev.check(tmp_path / "scene.toml", FIG6)
    with pytest.raises(InputError, match="sample 1 is not a finite number"):
        sampled(np.arange(3.0), np.array([0, math.nan, 0]))


def test_a_computed_trace_is_a_drive_and_a_long_one_is_checked_to_its_end(tmp_path):
    trace = ev.simulate(FIG6, signals=["drive_voltage"])
    for name in ("trace.nc", "trace.csv", "trace.mat"):
        ev.save(trace, tmp_path / name)
        assert ev.check(tmp_path / name, FIG6).value("peak voltage") == 1000
    np.save(tmp_path / "drive.npy", np.array([[0, 0], [1, 10], [5, 10], [6, 800], [7, 0.0]]))
    found = ev.check(tmp_path / "drive.npy", FIG6, set={"time.duration": "1 s"})
    assert found.value("peak voltage") == 800
    in_part = "Checked up to 50 ms (time.duration) only; the drive lasts 272 ms"
    notes = [" ".join(ev.check(FIG6, set=set_).notes) for set_ in ({"time.duration": "50 ms"}, {})]
    assert in_part in notes[0]
    assert "Checked up to" not in notes[1]


def test_a_sheet_of_an_instrument_is_a_drive_if_its_times_are_in_seconds(tmp_path):
    for unit in ("s", "ms"):
        book = openpyxl.Workbook()
        for row in ([f"time [{unit}]", "voltage [V]"], [0.0, 0.0], [1.0, 300.0], [2.0, 0.0]):
            book.active.append(row)
        book.save(tmp_path / f"{unit}.xlsx")
    assert ev.check(tmp_path / "s.xlsx", FIG6).value("peak voltage") == 300
    with pytest.raises(InputError, match=r"ms\.xlsx: has times in 'ms'; write it as CSV"):
        ev.check(tmp_path / "ms.xlsx", FIG6)


@pytest.mark.parametrize("gain", [1.0, -3.0])
def test_the_slew_is_that_of_the_steepest_edge_and_in_a_periodic_state_of_the_whole_period(gain):
    """The fall of 1 ms lies beyond the 50 ms of output times, and has passed in every period before."""
    drive = ev.load(FIG6, changes={"drive.fall": "1 ms"}).drive
    assert (slew_of(drive, 1.0), slew_of(drive, 0.05)) == (pytest.approx(1e6), pytest.approx(SLOPE))
    drive = {"model": "Trapezium", "high": 100, "rise": 0.03, "hold": 0.1, "fall": 1e-3, "repeat": 0.3}
    changes = {"drive": drive, "time.duration": 0.05} | amplified(gain=gain)
    for state, expected in ((SETTLED, 100 / 1e-3), ({}, 100 / 0.03)):
        found = ev.check(ev.load(FIG6, changes=changes | state)).value("slew rate")
        assert found == pytest.approx(abs(gain) * expected)


def test_the_peak_current_at_a_corner_is_the_same_in_check_run_and_sweep():
    """At the end of the rise 233 pF take (C_film + 200 pF) dV/dt; a parabola over both sides of it gave 6.90 uA and 7.17 uA."""
    scenario = ev.load(FIG6, changes=amplified(stray_capacitance="200 pF"))
    checked = ev.check(scenario).value("peak current")
    assert checked == pytest.approx((32.96e-12 + 200e-12) * SLOPE, rel=2e-4)
    assert diagnostics(ev.run(scenario))["current"].value == checked
    swept = ev.sweep(scenario, {"drive.high": [500.0, 1000.0]}, quantity=["peak amplifier_current"])
    # 1e-12: the time before the corner is chosen differently
    assert max(diagnostics(swept)["current"].value, checked) == pytest.approx(checked, rel=1e-12)


@pytest.mark.parametrize(
    ("limit", "value", "unit"),
    [
        ("rms_voltage", 100 / math.sqrt(2), "V"),
        ("rms_current", 2 * math.pi * 1e3 * CAPACITANCE * 100 / math.sqrt(2), "A"),
        ("slew_rate", 2 * math.pi * 1e3 * 100, "V/s"),
    ],
)
def test_limits_of_root_mean_squares_and_of_the_slew_rate(limit, value, unit):
    """Film and skin that does not conduct under a sine in its steady state, by check, run and sweep."""
    name = limit.replace("_", " ")
    still = {"stack.stratum_corneum.material.conductivity": 0.0, "drive": SINE, "limits": {}} | SETTLED
    for own, gain in (({}, 1.0), (amplified(gain=-2.0), 2.0)):
        scenario, expected = ev.load("vezzoli_2014/fig6_static", changes=still | own), gain * value
        assert ev.check(scenario).value(name) == pytest.approx(expected, rel=1e-6)
        for factor, state, verdict in ((1.001, "pass", "ok"), (0.999, "fail", "warning")):
            declared = scenario.replace({f"limits.{limit}": factor * expected})
            found = row(ev.check(declared), name)
            assert (found.state, found.unit) == (state, unit)
            judged = diagnostics(ev.run(declared))[name]
            assert (judged.state, judged.value) == (verdict, pytest.approx(expected, rel=1e-6))
            swept = ev.sweep(declared, {"drive.phase": [0.0, 0.5]}, quantity=["peak drive_voltage"])
            assert diagnostics(swept)[name].state == verdict


def test_the_root_mean_square_of_a_current_without_a_bound_is_not_known():
    """Jumps without a series resistance: check, run and a plate's rows say so, and none compares a finite number."""
    limits = {"rms_current": "1 A", "rms_voltage": "1 kV"}
    changes = {"drive": square(-100, 100), "limits": limits, "circuit.return_path.resistance": 0.0}
    scenario = ev.load(FIG6, changes=changes)
    checked = ev.check(scenario)
    published = [each for each in checked.comparisons if each.quantity == "rms body current"]
    assert {(each.value, each.state) for each in published} == {(math.inf, "fail")}, "0.5 mA are exceeded"
    judged = [diagnostics(found) for found in (ev.run(scenario), ev.simulate(scenario))]
    over = {"drive.high": ["100 V"]}
    (plate,) = ev.plan_plate(scenario, over, limits=limits, minimise=["peak voltage"]).candidates
    planned = next(each for each in plate.rows if each.quantity == "rms current")
    for found in (row(checked, "rms current"), planned, *(each["rms current"] for each in judged)):
        assert (found.state, found.value) == ("unknown", None)
    assert [each["rms voltage"].value for each in judged] == [pytest.approx(100, rel=1e-6)] * 2


class TestCommandLine:
    FAILING = FIG6, "--set", "limits.voltage=900 V"
    VERDICT = "exceeded: 1 of 8 limits: peak voltage"
    CLEARED = "--set", "limits.voltage=1 kV", "--set", "stack.insulator.breakdown_field=100 MV/m"

    def run(self, *words):
        return CliRunner(env={"COLUMNS": "200"}).invoke(app, ["check", *words])

    def test_exit_code_verdict_numbers_and_page(self, tmp_path):
        open_one, passed = self.run(FIG6), self.run(FIG6, *self.CLEARED)
        failed = self.run(*self.FAILING, "-o", str(tmp_path / "check.json"))
        assert [each.exit_code for each in (passed, open_one, failed)] == [0, 5, 1]
        assert passed.output.startswith("within all limits (")
        assert open_one.output.startswith("not shown to be safe: peak voltage (")
        assert "limits.voltage is not declared; declare limits.voltage" in open_one.output
        assert self.VERDICT in failed.output
        content = json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))
        assert content["state"] == "fail"
        assert content["limits"][0]["margin"] == pytest.approx(0.9)
        path = tmp_path / "check.html"
        assert self.run(*self.FAILING, "-o", str(path)).exit_code == 1
        page = path.read_text(encoding="utf-8")
        assert self.VERDICT in page
        assert "not a claim of medical safety" in page
        assert self.run(FIG6, "-o", str(path)).exit_code == 5

    def test_a_drive_before_the_scenario_and_a_table(self, tmp_path):
        drive, table = tmp_path / "drive.csv", tmp_path / "check.csv"
        drive.write_text("time,voltage\n0,0\n0.001,300\n0.01,0\n", encoding="utf-8")
        for _ in range(2):
            assert self.run(str(drive), FIG6, "-o", str(table)).exit_code == 5, "our own table is replaced"
        lines = table.read_text(encoding="utf-8").splitlines()
        assert lines[2].startswith("kind,quantity,value,limit,unit,margin,state,source")
        assert lines[3].startswith("limit,peak voltage,300.0,,V,,unknown")
        for words in ([str(drive), FIG6, "-o", str(drive)], [FIG6, "-o", "check.xyz"]):
            assert isinstance(self.run(*words).exception, InputError), "an input is never replaced"

    def test_the_verdict_is_a_few_lines_and_all_the_rest_is_asked_for(self):
        short, full = self.run(FIG6).output, self.run(FIG6, "--all").output
        verdict, closest, _, undeclared, asked, meaning, warning, more = short.splitlines()
        least = min((each for each in ev.check(FIG6).rows if each.margin), key=lambda each: each.margin)
        assert verdict.startswith("not shown to be safe: peak voltage (")
        assert closest.startswith(f"closest limit: {least.quantity}, ")
        assert closest.endswith(f"limit/value {least.margin:.3g}, of uncertain standing")
        assert undeclared == "not compared: charge, stored energy, peak body current"
        assert asked.startswith("asked of an amplifier, ")
        assert warning.startswith("warning: the voltage across the stack reaches 1 kV, above 661 V")
        assert "no claim of medical safety" in meaning
        assert more == f"--all prints {len(full.splitlines()) - 7} more lines."
        for text in ("Comparison with published currents", "Values without a limit", verdict, closest):
            assert text in full
            assert (text in short) == (text in {verdict, closest})
        failed = self.run(*self.FAILING).output.splitlines()
        assert len(failed) == 7
        assert failed[1] == "closest limit: peak voltage, 1 kV of 900 V, limit/value 0.9"
        shown = self.run(FIG6, "--series-resistor").output
        assert "4 Mohm" in shown
        assert "250 mW" in shown
