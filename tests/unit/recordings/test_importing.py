"""Files of instruments as Traces: columns, units, calibration, times and steps."""

import json
import re
import tomllib

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.data.recorded import missing_numbers
from electrovib.recordings.importing.clock import _gaps
from electrovib.recordings.importing.import_file import list_columns
from electrovib.recordings.importing.notices import about_samples
from electrovib.recordings.importing.reduction import (
    ReductionSteps,
    average_periods,
    find_edges,
    reduced,
    resampled,
    shifted,
)
from electrovib.recordings.recording import at_extreme, at_rail

T = np.arange(0, 2, 1e-3)
NOISE = np.random.default_rng(3).normal(0, 1e-3, T.size)
FORCE = 0.2 + 0.05 * np.sin(2 * np.pi * 7 * T) + NOISE
GATE = np.where(T >= 0.5, 5.0, 0.0)
MEASURED = "lateral_force_measured"
SCALED = {"scale": {MEASURED: "4/9 N/V"}}


@pytest.fixture
def record(table):
    return table("t (ms),Ch1 (V),Ch2", T * 1e3, FORCE / (4 / 9) + 1, GATE)


def validity(found):
    return {each["name"]: each for each in json.loads(found.attrs["validity"])}


def test_columns_are_calibrated_signals_with_their_origin(record, tmp_path):
    columns = {MEASURED: "Ch1", "drive_voltage": "Ch2 [kV]"}
    found = ev.import_file(record, columns, offset={MEASURED: "1 V"}, **SCALED)
    np.testing.assert_allclose(found["time"], T, atol=1e-12)
    np.testing.assert_allclose(found[MEASURED], FORCE, atol=1e-8)
    np.testing.assert_allclose(found["drive_voltage"], 1e3 * GATE)
    assert found["drive_voltage"].attrs["units"] == "V"
    assert (found.attrs["file"], found.attrs["reader"]) == ("a.csv", "text")
    assert len(found.attrs["file_sha256"]) == 64
    assert json.loads(found.attrs["options"])["scale"] == {MEASURED: "4/9 N/V"}
    assert "multiplied by 4/9 N/V" in found.attrs["history"]
    for name in ("dropped samples", f"sensor range of {MEASURED}"):
        assert validity(found)[name]["state"] == "ok"
    for suffix in (".nc", ".mat"):
        ev.save(found, tmp_path / f"saved{suffix}")
        again = ev.open_trace(tmp_path / f"saved{suffix}")
        np.testing.assert_array_equal(again["drive_voltage"], found["drive_voltage"])
        assert again.attrs["history"] == found.attrs["history"]
    lines = "\n".join(list_columns(record))
    for words in (
        "reader 'text', 3 columns of 2000 samples",
        "t  [ms]",
        "the time",
        "--column drive_voltage=",
    ):
        assert words in lines


@pytest.mark.parametrize(
    ("scale", "offset", "expected"),
    [
        ("444.4444444444444 mN/V", None, FORCE + 4 / 9),
        ("4/9 mN/mV", "1 V", FORCE),
        ("-4/9 N/V", "1000 mV", -FORCE),
        ("4/9 N/V", "444.4444444444444 mN", FORCE),
    ],
)
def test_scales_and_offsets(record, scale, offset, expected):
    options = {"scale": {MEASURED: scale}} | ({"offset": {MEASURED: offset}} if offset else {})
    found = ev.import_file(record, {MEASURED: "Ch1"}, **options)
    np.testing.assert_allclose(found[MEASURED], expected, atol=1e-8)


def of_force(**options):
    return {"columns": {"lateral_force": "Ch1"}} | options


def of_drive(**options):
    return {"columns": {"drive_voltage": "Ch1"}} | options


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"columns": {"lateral_forc": "Ch1"}}, "Did you mean 'lateral_force'"),
        ({"columns": {"drive_voltage": "Ch3"}}, "no such column. Did you mean 'Ch"),
        ({"columns": {"drive_voltage": "Ch2"}}, r"states no unit; write it behind the name: 'Ch2 \[V\]'"),
        ({"columns": {"drive_voltage": "Ch2 [N]"}}, "a voltage is needed"),
        ({"columns": {"lateral_force": "Ch1 (N)"}}, "states the unit 'V' for 'Ch1', not 'N'"),
        ({"columns": {"time": "t", "current": "Ch1"}}, r"columns.time: .* chosen with --set time="),
        (of_force(scale={"lateral_force": "4/9 V/N"}), "a factor in N per unit"),
        (of_force(scale={"lateral_force": "1 N/A"}), "is in 'V', not in 'A'"),
        (of_force(scale={"lateral_force": "0 N/V"}), "other than 0"),
        (of_drive(scale={"drive_volt": "2"}), "not a signal that has a column"),
        (of_drive(resampel="1 ms"), "Did you mean 'resample'"),
        (of_drive(resample="3 s"), "below the length of the record"),
        (of_drive(crop="3 s..4 s"), "fewer than two samples remain"),
        (of_drive(baseline={"drive_voltage": "5 s..6 s"}), "no sample lies in it"),
        (of_drive(stamps="keep"), "refuse, keep_increasing"),
        ({"columns": {}}, "not recognised as a spectrum"),
    ],
)
def test_mistakes_name_what_helps(record, options, words):
    with pytest.raises(InputError, match=words):
        ev.import_file(record, **options)


def test_steps_are_applied_in_their_order(record):
    found = ev.import_file(
        record,
        {MEASURED: "Ch1", "drive_voltage": "Ch2 [V]"},
        shift={"drive_voltage": "100 ms"},
        trigger="drive_voltage",
        baseline={MEASURED: "..0 s"},
        crop="-0.2 s..0.8 s",
        resample="10 ms",
        **SCALED,
    )
    time = found["time"].values
    np.testing.assert_allclose(np.diff(time), 0.01)
    assert -0.2 <= time[0] < -0.19
    drive = found["drive_voltage"].values
    np.testing.assert_allclose(drive[time < -0.01], 0, atol=1e-12)
    np.testing.assert_allclose(drive[time > 0.01], 5)
    expected = FORCE - FORCE[(T >= 0.1) & (T <= 0.5995)].mean()
    smooth = np.convolve(expected, np.ones(10) / 10, "same")
    np.testing.assert_allclose(found[MEASURED], np.interp(time, T - 0.5995, smooth), atol=3e-3)
    assert found.attrs["history"].count("\n") >= 8


def test_rounded_time_stamps_become_even_and_falling_ones_are_refused_or_dropped(table):
    rounded = np.floor(T * 250) / 250
    found = ev.import_file(table("t [s],f [N]", rounded, FORCE), {MEASURED: "f"})
    np.testing.assert_allclose(np.diff(found["time"]), T[1] - T[0])
    assert "cut off at 4 ms" in found.attrs["history"]
    falling = T.copy()
    falling[[700, 701]] = falling[[650, 699]]
    path = table("t [s],f [N]", falling, FORCE)
    with pytest.raises(InputError, match="2 time stamps do not increase, the first at sample 700"):
        ev.import_file(path, {MEASURED: "f"})
    found = ev.import_file(path, {MEASURED: "f"}, stamps="keep_increasing")
    np.testing.assert_allclose(found[MEASURED], np.delete(FORCE, [700, 701]), rtol=1e-12)


GAP = np.s_[300:305]
RAILED = np.clip(np.delete(FORCE, GAP), 0, 0.24)
ROUNDED = np.round(np.random.default_rng(8).normal(0, 4.0, T.size) + 100)


def square(frequency):
    return 300.0 * (np.sin(2 * np.pi * frequency * T) > 0)


@pytest.mark.parametrize(
    ("time", "values", "name", "state", "value", "words"),
    [
        (np.delete(T, GAP), RAILED, "dropped samples", "warning", 5, ""),
        (np.delete(T, GAP), RAILED, "sensor range of", "warning", pytest.approx(np.mean(RAILED == 0.24)), ""),
        (T, np.repeat(FORCE[::4], 4), "repeated samples", "warning", pytest.approx(0.75, abs=0.01), ""),
        (T, square(190.3), "aliasing of", "warning", pytest.approx(190.3, abs=1), ""),
        (T, square(80.3) + NOISE, "aliasing of", "warning", None, "every 6.2"),
        (np.append(T[:-1], 1e12), FORCE, "aliasing of", "unknown", None, "too uneven"),
        (T, np.where(T < 1, -1e300, 1e300) * (1 + NOISE), "aliasing of", "ok", None, ""),
        # of normal noise of 4 steps 1/(2 sqrt(pi) 4) = 7.05 % repeat, as is observed and explained
        (T, ROUNDED, "repeated samples", "ok", None, r"[678]\.\d+ ?% .* [67]\.\d+ ?%"),
    ],
    ids=["dropped", "rail", "held", "aliased", "edges between", "uneven", "large", "quantised noise"],
)
def test_faults_of_the_record_are_noticed_and_others_are_not(table, time, values, name, state, value, words):
    found = validity(ev.import_file(table("t [s],u [V]", time, values), {"drive_voltage": "u"}))
    (said,) = (each for key, each in found.items() if key.startswith(name))
    assert said["state"] == state
    assert value is None or said["value"] == value
    assert re.search(words, said["text"])


def test_a_record_of_many_samples_once_resampled_needs_no_memory(table):
    path = table("t [s],v [V]", np.append(T[:-1], 1e12), FORCE)
    with pytest.raises(InputError, match="at most 50000000 are allowed"):
        ev.import_file(path, {"drive_voltage": "v"}, resample="1 ms")


def test_interpolation_shift_and_trigger():
    time = np.array([0.0, 1, 2, 4])
    np.testing.assert_allclose(shifted(time, 3 * time, 0.5), [np.nan, 1.5, 4.5, 10.5])
    np.testing.assert_allclose(resampled(time, 3 * time, np.array([0.5, 1.0, 1.5])), [1.5, 3, 4.5])
    np.testing.assert_allclose(resampled(time, 3 * time, np.array([0.0, 2.0, 4.0])), [1.5, 6, 10.5])
    lost = np.array([0.0, np.nan, 6, 12])
    found = resampled(time, lost, np.array([0.0, 0.5, 1.5, 2.0, 2.5]))
    np.testing.assert_allclose(found, [0, np.nan, np.nan, 6, 7.5])
    assert find_edges(time, np.array([0.0, 0, 2, 2])).rising == pytest.approx(1.5)
    assert find_edges(time, np.array([2.0, 2, 0, 0])).rising.size == 0


GRID = np.geomspace(100, 1e5, 20)
EPS = 50 + 900 / (1 + 2j * np.pi * GRID * 1e-4) - 1j * 2e-6 / (2 * np.pi * GRID * 8.8541878188e-12)


def test_an_impedance_is_a_trace_and_a_material(table):
    sample = 2e-4 / (2j * np.pi * GRID * 8.8541878188e-12 * 1e-4 * EPS)
    measured = 1 / (1 / (sample + 300) + 2j * np.pi * GRID * 3e-12)
    path = table("f [Hz],Z' [ohm],Z'' [ohm]", GRID, measured.real, measured.imag)
    np.testing.assert_allclose(ev.import_file(path)["impedance"], measured, rtol=1e-12)
    fixture = {"series_resistance": "300 ohm", "parallel_capacitance": "3 pF"}
    recipe = ev.SpectrumRecipe(area="1 cm2", thickness="200 um", **fixture)
    found = ev.import_material(path, recipe, conductivity="1 uS/m")
    np.testing.assert_allclose(found.material.complex_permittivity(GRID), EPS, rtol=1e-6)
    assert found.thickness == 2e-4
    with pytest.raises(InputError, match=r"area: .* '1 cm2'"):
        ev.import_material(path, ev.SpectrumRecipe(thickness="200 um"))
    with pytest.raises(InputError, match=r"(?s)area: .*\nthickness: .* '200 um'"):
        ev.import_material(path)
    for stated in ({"area": "0 m2", "thickness": "1 mm"}, {"area": "1 cm2", "thickness": 0.0}):
        with pytest.raises(InputError, match="expected more than 0, in m"):
            ev.import_material(path, ev.SpectrumRecipe(**stated))
    with pytest.raises(InputError, match="rows are those of no passive dielectric"):
        ev.import_material(
            path, ev.SpectrumRecipe(area="1 cm2", thickness="200 um", series_resistance="1 Mohm")
        )


def test_a_permittivity_with_or_without_loss_goes_into_a_scenario(table):
    path = table("f,permittivity", GRID, EPS.real)
    found = ev.import_material(path)
    assert "assumed to be 0" in found.diagnostics[0].text
    np.testing.assert_allclose(found.material.complex_permittivity(GRID), EPS.real, rtol=1e-12)
    with pytest.raises(InputError, match="area: the file holds a permittivity"):
        ev.import_material(path, ev.SpectrumRecipe(area="1 cm2"))
    path = table("f,permittivity,loss factor", GRID, EPS.real, -EPS.imag)
    found = ev.import_material(path, ev.SpectrumRecipe(thickness="150 um"))
    layer = tomllib.loads(found.to_toml("stratum_corneum"))["stack"]["stratum_corneum"]
    changes = {f"stack.stratum_corneum.{name}": layer[name] for name in ("material", "thickness")}
    skin = ev.load("vezzoli_2014/fig6", changes=changes).stack.layers["stratum_corneum"]
    assert skin.thickness == 150e-6
    known = found.material.complex_permittivity(GRID)
    np.testing.assert_array_equal(skin.material.complex_permittivity(GRID), known)


def test_edges_and_averages_over_periods(table):
    time = np.arange(0, 2.03, 1e-3)
    gate = np.where((time * 4) % 1 < 0.25, 5.0, 0.0)
    force = 3 * np.exp(-((time * 4) % 1)) + np.random.default_rng(1).normal(0, 0.1, time.size)
    edges = find_edges(time, gate)
    np.testing.assert_allclose(edges.rising, 0.25 * np.arange(1, 9) - 5e-4)
    np.testing.assert_allclose(edges.falling, 0.25 * np.arange(8) + 0.0625, atol=1e-3)
    grid, means, errors, lengths = average_periods(time, {"gate": gate, "force": force}, "gate")
    assert (lengths.size, grid.size) == (7, 250)
    assert lengths.mean() == pytest.approx(0.25)
    inside = np.s_[2:-2]
    expected = 3 * np.exp(-4 * (grid - 5e-4))
    np.testing.assert_allclose(means["force"][inside], expected[inside], atol=0.15)
    error = np.sqrt(np.mean(errors["force"][inside] ** 2))
    assert error == pytest.approx(0.1 / np.sqrt(14), rel=0.15)
    path, columns = table("t [s],g [V],f [N]", time, gate, force), {"drive_voltage": "g", MEASURED: "f"}
    found = ev.import_file(path, columns, average="drive_voltage")
    assert found.sizes["time"] == 250
    assert "averaged over 7 periods of drive_voltage, 250 ms" in found.attrs["history"]
    with pytest.raises(InputError, match="whole periods between rising edges"):
        ev.import_file(path, columns, average="drive_voltage", crop="0 s..0.6 s")
    with pytest.raises(InputError, match="its periods differ"):
        average_periods(time, {"f": np.sin(2 * np.pi * (3 * time + time**2))}, "f")


def test_the_spread_of_periods_is_stated():
    time = np.arange(0, 4, 1e-3)
    gate = np.searchsorted([0.5, 1.45, 2.55, 3.5], time, side="right") - np.searchsorted(
        [1.0, 2.0, 3.0, 3.8], time, side="right"
    )
    _, _, words = reduced(time, {"drive_voltage": gate * 5.0}, ReductionSteps(average="drive_voltage"))
    assert "3 periods of drive_voltage, 1 s on average with a standard deviation of 86.6 ms" in words[0]


@pytest.mark.parametrize(("noise", "state"), [(1.0, "warning"), (0.3, "unknown"), (0.0, "unknown")])
def test_a_rail_beside_a_long_zero_is_noticed(table, noise, state):
    """The zero before and after the contact is read more often than the rail, which was not noticed then."""
    time, rng = np.linspace(0, 1, 841), np.random.default_rng(3)
    pressed = 900 * np.clip(np.sin(np.pi * (time - 0.2) / 0.6), 0, None) * (time < 0.8)
    force = np.minimum(np.round(pressed + noise * rng.normal(size=841)), 749.0)
    found = ev.import_file(table("t (s),Fz (N)", time, force), {"normal_force": "Fz"})
    said = validity(found)["sensor range of normal_force"]
    assert said["state"] == state
    # without noise the zero is an extreme that repeats too
    ends = (force == 749) | ((force == 0) & (noise == 0))
    assert f"{np.mean(ends):.2%} of the samples" in said["text"]


def test_what_is_constant_or_has_two_levels_is_no_rail():
    rng = np.random.default_rng(0)
    sine = np.round(100 * np.sin(20 * np.linspace(0, 1, 4000)))
    noisy = np.round(sine + rng.normal(size=4000))
    # readings without noise, with less noise than a step, and slow ones stand still without being at a rail
    for values in (sine, noisy, np.sign(sine), np.zeros(50), np.arange(100.0), rng.normal(size=4000)):
        assert not at_extreme(values).any()
        assert not at_rail(values).any()
    clipped = np.minimum(np.round(sine + rng.normal(size=4000)), 70)
    np.testing.assert_array_equal(at_rail(clipped), clipped == 70)
    both = np.clip(rng.normal(size=5000) + np.linspace(-8, 8, 5000), -3, 3)
    assert np.count_nonzero(at_rail(both)) > 2500


FINE = np.where((T > 0.4) & (T < 0.9), -7.0 - (np.arange(T.size) % 2) * 1e-2, FORCE)
FLICKER = np.where((T > 0.4) & (T < 0.9), -7.0 - (np.arange(T.size) % 3 == 0) * 1e-4, np.round(FORCE, 4))
STUCK = np.where((T > 1) & (T < 1.2), 0.2345, FORCE)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (FLICKER, "the sensor of Fz is at its rail, or in a dead band, for 24.95% of the samples"),
        (FINE, "the sensor of Fz is at its rail, or in a dead band, for 24.95% of the samples"),
        (-FLICKER, "the sensor of Fz is at its rail, or in a dead band, for 24.95% of the samples"),
        (STUCK, "Fz stands still from sample 1001 to 1199 and has noise elsewhere"),
        (np.where((T > 1) & (T < 1.2), -0.4, FORCE), "at its rail, or in a dead band, for 9.95%"),
        (FORCE, ""),
        (np.round(FORCE, 2), ""),  # its noise is below its resolution
        (np.where(T < 1, 0.0, np.sin(90 * T)), ""),  # of a generator
        (np.repeat(FORCE[::10], 10), ""),  # read ten times for each update
    ],
    ids=[
        "flickers",
        "flickers among fine readings",
        "flickers above",
        "stuck",
        "rail",
        "good",
        "coarse",
        "generator",
        "repeated",
    ],
)
def test_faults_of_a_sensor_are_named_without_an_import_too(table, values, words):
    path = table("t [s],Fz [N]", T, values)
    listed = [line for line in list_columns(path) if line.startswith("warning: ")]
    assert len(listed) == bool(words)
    assert not words or words in listed[0]
    warned = [
        each
        for each in validity(ev.import_file(path, {"normal_force": "Fz"})).values()
        if each["state"] == "warning"
    ]
    texts = [each["text"] for each in warned if each["name"].startswith(("sensor", "stuck"))]
    assert len(texts) == bool(words)


def test_two_readings_at_an_end_that_are_not_much_more_often_than_two_others_are_no_rail():
    others = np.concatenate([[10.0], np.tile([30.0, 31.0], 75), np.arange(32.0, 200.0)])
    for times, is_rail in ((200, False), (300, True)):
        assert at_extreme(np.concatenate([np.tile([0.0, 1.0], times), others])).any() is np.bool_(is_rail)


def test_a_rest_with_noise_of_a_few_steps_is_no_rail():
    rng = np.random.default_rng(0)
    touched = np.where(T < 0.8, 0, 30 + 100 * np.abs(np.sin(8 * T)))
    for noise in (0.3, 0.5, 1.0):
        assert not at_rail(np.round(touched + rng.normal(size=T.size) * np.where(T < 0.8, noise, 3))).any()


@pytest.mark.parametrize(
    ("number", "times", "lost"),
    [(9.9e37, 1, 1), (-9.9e37, 3, 3), (9.91e37, 2, 2), (np.float32(9.9e37), 2, 2), (199.999e99, 2, 2), (-999, 5, 5),
     (-9999, 3, 3), (1e39, 2, 2), (-999, 1, 0), (-999, 1500, 0), (9.9e36, 2, 0), (999, 5, 0)],
)  # fmt: skip
@pytest.mark.parametrize("suffix", [".npy", ".csv"])
def test_numbers_that_stand_for_no_reading_are_missing_and_counted(
    table, tmp_path, number, times, lost, suffix
):
    values = FORCE.copy()
    values[100 : 100 + times] = number
    path = table("t [s],Fz [N]", T, values)
    if suffix == ".npy":
        fields = np.zeros(T.size, [("t [s]", "f8"), ("Fz [N]", "f8")])
        fields["t [s]"], fields["Fz [N]"] = T, values
        path = tmp_path / "a.npy"
        np.save(path, fields)
    found = ev.import_file(path, {"normal_force": "Fz"})
    missing = np.isnan(found.normal_force.values)
    assert np.count_nonzero(missing) == lost
    np.testing.assert_allclose(found.normal_force.values[~missing], values[~missing], rtol=1e-9)
    (account,) = [each for each in json.loads(found.attrs["columns_of_file"])["read"] if each["name"] == "Fz"]
    assert account["missing"] == lost
    said = [line for line in list_columns(path) if "not read: " in line]
    assert [f"{lost} of 2000 samples of 'Fz': missing" in line for line in said] == [True] * bool(lost)
    assert (f"{lost} of 2000 samples of normal_force are no numbers" in found.attrs["validity"]) is bool(lost)


def test_nines_within_the_range_of_the_others_are_readings(table):
    wide = np.where(T < 0.1, -999.0, 900 * np.sin(20 * T))
    found = ev.import_file(table("t [s],u [V]", T, wide), {"drive_voltage": "u"})
    np.testing.assert_allclose(found.drive_voltage, wide, rtol=1e-8)


def test_large_numbers_among_others_that_are_large_are_readings():
    large = np.array([1e36, 9.9e37, 2e38, 1e39])
    assert missing_numbers(large)[1] == {9.9e37: 1}
    assert missing_numbers(1e3 * large)[1] == {}


LONG = 2**17 + 2**16
LONG_NOISE = np.random.default_rng(5).normal(size=LONG)
"""A record that is longer than the samples by which repetition and bandwidth are judged."""


def judged(values, time=None):
    time = np.arange(values.size) * 1e-4 if time is None else time
    return {each.name: each for each in about_samples(time, {"Fz": values})}


@pytest.mark.parametrize("first", [0, LONG // 2, LONG - 2000])
def test_a_rail_and_a_stuck_sensor_are_found_anywhere_in_a_long_record(first):
    rail, still = LONG_NOISE.copy(), LONG_NOISE.copy()
    rail[first : first + 1000] = 6.0
    still[first : first + 1000] = 0.25
    assert judged(rail)["sensor range of Fz"].value == pytest.approx(1000 / LONG, rel=1e-12)
    assert judged(still)["stuck Fz"].value == 1000


@pytest.mark.parametrize("before", range(17))
def test_a_run_of_equal_readings_is_found_across_the_blocks_of_a_walk(before):
    still, first = LONG_NOISE.copy(), 2**17 - before
    still[first - 1 : first + 31 : 2] = np.nan  # between equal readings
    still[first : first + 32 : 2] = 0.25
    assert judged(still)["stuck Fz"].value == 16


@pytest.mark.parametrize("end", [-6.0, 6.0])
@pytest.mark.parametrize("stop", [2**17, 2 * LONG])
def test_an_end_of_the_range_that_repeats_in_one_block_or_a_few_times_in_each_is_found(stop, end):
    rail = np.tile(LONG_NOISE, 2)
    rail[: stop : stop // 12] = end
    share = np.count_nonzero(rail == end) / rail.size
    assert judged(rail)["sensor range of Fz"].value == pytest.approx(share, rel=1e-12)


@pytest.mark.parametrize("dropped", [0, 1, 2**17 - 1, 2**17, LONG - 2])
def test_a_missing_sample_is_found_in_every_block_of_the_times(dropped):
    time = np.delete(np.arange(LONG + 1) * 1e-4, dropped + 1)
    (found,) = _gaps(time)
    assert (found.state, found.value) == ("warning", 1.0)


@pytest.mark.parametrize(("first", "said"), [(0, 0), (LONG - LONG // 4, 65536)])
def test_bandwidth_of_a_long_record_is_judged_where_the_signal_moves_most_and_says_so(first, said):
    quiet = 1e-3 * LONG_NOISE
    quiet[first : first + LONG // 4] += np.sin(2 * np.pi * 0.3 * np.arange(LONG // 4))
    text = judged(quiet)["aliasing of Fz"].text
    assert "has 3.3 samples a period" in text
    assert text.endswith(f"; judged on 131072 of 196608 samples, from sample {said} on")


def test_repetition_in_a_long_record_is_judged_in_its_middle_and_says_so():
    repeated = judged(np.repeat(LONG_NOISE[: LONG // 2], 2))["repeated samples"]
    assert (repeated.state, repeated.value) == ("warning", pytest.approx(0.5, abs=1e-4))
    assert repeated.text.endswith("; judged on 131072 of 196608 samples, from sample 32768 on")
    assert not any("judged on" in each.text for each in judged(LONG_NOISE[: 2**17]).values())


def test_a_long_record_that_is_missing_where_it_would_be_judged_is_judged_on_the_rest():
    values = np.full(LONG, np.nan)
    values[-2000:] = LONG_NOISE[-2000:]
    assert judged(values)["aliasing of Fz"].text.startswith("0.2")


@pytest.mark.parametrize("size", [1e-250, 1e250])
def test_numbers_whose_squares_are_no_numbers_are_judged_as_others_are(size):
    values, scale = LONG_NOISE[:4000], 2.0 ** np.round(np.log2(size))
    assert {name: each.text for name, each in judged(scale * values).items()} == {
        name: each.text for name, each in judged(values).items()
    }


@pytest.mark.parametrize("repeats", [4, 5])
def test_an_end_that_flickers_repeats_from_five_samples_on_beside_five_a_step_away(repeats):
    values = np.concatenate([np.repeat([8.0, 7.99], repeats), np.linspace(-7.9, 7.9, 400)])
    found = (values > 7.95) & (repeats > 4)
    np.testing.assert_array_equal(at_extreme(values), found)
    np.testing.assert_array_equal(at_extreme(-values), found)


def test_a_column_that_is_not_read_is_refused_with_its_reason(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],F [N],note\n0,1,good\n1,2,bad\n2,4,good\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"= note: the file has no such column.* Not read: words"):
        ev.import_file(tmp_path / "a.csv", {"drive_voltage": "note"})
