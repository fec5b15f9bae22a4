"""Files of instruments as Traces: columns, units, calibration, times and steps."""

import json
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.calibration_error import CalibrationError
from electrovib.recordings.fit import MeasuredTrace
from electrovib.recordings.importing import list_columns
from electrovib.recordings.importing.periods import average_periods, find_edges
from electrovib.recordings.importing.steps import resampled, shifted, trigger_time

SHARED = Path(__file__).parents[4] / "shared" / "data"
T = np.arange(0, 2, 1e-3)
NOISE = np.random.default_rng(3).normal(0, 1e-3, T.size)
FORCE = 0.2 + 0.05 * np.sin(2 * np.pi * 7 * T) + NOISE
GATE = np.where(T >= 0.5, 5.0, 0.0)


@pytest.fixture
def record(tmp_path):
    rows = np.column_stack([T * 1e3, FORCE / (4 / 9) + 1, GATE])
    np.savetxt(tmp_path / "a.csv", rows, fmt="%.9g", delimiter=",", comments="", header="t (ms),Ch1 (V),Ch2")
    return tmp_path / "a.csv"


def test_columns_are_calibrated_signals_with_their_origin(record):
    found = ev.import_file(
        record,
        {"lateral_force_measured": "Ch1", "drive_voltage": "Ch2 [kV]"},
        scale={"lateral_force_measured": "4/9 N/V"},
        offset={"lateral_force_measured": "1 V"},
    )
    np.testing.assert_allclose(found["time"], T, atol=1e-12)
    np.testing.assert_allclose(found["lateral_force_measured"], FORCE, atol=1e-8)
    np.testing.assert_allclose(found["drive_voltage"], 1e3 * GATE)
    assert found["drive_voltage"].attrs["units"] == "V"
    assert found.attrs["file"] == "a.csv"
    assert len(found.attrs["file_sha256"]) == 64
    assert found.attrs["reader"] == "text"
    assert json.loads(found.attrs["options"])["scale"] == {"lateral_force_measured": "4/9 N/V"}
    assert "multiplied by 4/9 N/V" in found.attrs["history"]
    states = {each["name"]: each["state"] for each in json.loads(found.attrs["validity"])}
    assert states["dropped samples"] == states["sensor range of lateral_force_measured"] == "ok"


@pytest.mark.parametrize(
    ("scale", "offset", "expected"),
    [
        ("4/9 N/V", None, FORCE + 4 / 9),
        ("444.4444444444444 mN/V", None, FORCE + 4 / 9),
        ("4/9 mN/mV", "1 V", FORCE),
        ("-4/9 N/V", "1000 mV", -FORCE),
        ("4/9 N/V", "444.4444444444444 mN", FORCE),
    ],
)
def test_scales_and_offsets(record, scale, offset, expected):
    found = ev.import_file(
        record,
        {"lateral_force_measured": "Ch1"},
        scale={"lateral_force_measured": scale},
        offset={"lateral_force_measured": offset} if offset else None,
    )
    np.testing.assert_allclose(found["lateral_force_measured"], expected, atol=1e-8)


@pytest.mark.parametrize(
    ("columns", "options", "words"),
    [
        ({"lateral_forc": "Ch1"}, {}, "Did you mean 'lateral_force'"),
        ({"drive_voltage": "Ch3"}, {}, "no such column. Did you mean 'Ch"),
        ({"drive_voltage": "Ch2"}, {}, r"states no unit; write it behind the name: 'Ch2 \[V\]'"),
        ({"drive_voltage": "Ch2 [N]"}, {}, "a voltage is needed"),
        ({"lateral_force": "Ch1 (N)"}, {}, "states the unit 'V' for 'Ch1', not 'N'"),
        ({"lateral_force": "Ch1"}, {"scale": {"lateral_force": "4/9 V/N"}}, "a factor in N per unit"),
        ({"lateral_force": "Ch1"}, {"scale": {"lateral_force": "1 N/A"}}, "is in 'V', not in 'A'"),
        ({"lateral_force": "Ch1"}, {"scale": {"lateral_force": "0 N/V"}}, "other than 0"),
        ({"drive_voltage": "Ch1"}, {"scale": {"drive_volt": "2"}}, "not a signal that has a column"),
        ({"drive_voltage": "Ch1"}, {"resampel": "1 ms"}, "Did you mean 'resample'"),
        ({"drive_voltage": "Ch1"}, {"resample": "3 s"}, "below the length of the record"),
        ({"drive_voltage": "Ch1"}, {"crop": "3 s..4 s"}, "fewer than two samples remain"),
        ({"drive_voltage": "Ch1"}, {"baseline": {"drive_voltage": "5 s..6 s"}}, "no sample lies in it"),
        ({"drive_voltage": "Ch1"}, {"stamps": "keep"}, "refuse, keep_increasing"),
        ({}, {}, "not recognised as a spectrum"),
    ],
)
def test_mistakes_name_what_helps(record, columns, options, words):
    with pytest.raises(InputError, match=words):
        ev.import_file(record, columns, **options)


def test_steps_are_applied_in_their_order(record):
    found = ev.import_file(
        record,
        {"lateral_force_measured": "Ch1", "drive_voltage": "Ch2 [V]"},
        scale={"lateral_force_measured": "4/9 N/V"},
        shift={"drive_voltage": "100 ms"},
        trigger="drive_voltage",
        baseline={"lateral_force_measured": "..0 s"},
        crop="-0.2 s..0.8 s",
        resample="10 ms",
    )
    time = found["time"].values
    np.testing.assert_allclose(np.diff(time), 0.01)
    assert -0.2 <= time[0] < -0.19
    drive = found["drive_voltage"].values
    np.testing.assert_allclose(drive[time < -0.01], 0, atol=1e-12)
    np.testing.assert_allclose(drive[time > 0.01], 5)
    before = (T >= 0.1) & (T <= 0.5995)
    expected = FORCE - FORCE[before].mean()
    smooth = np.convolve(expected, np.ones(10) / 10, "same")
    np.testing.assert_allclose(
        found["lateral_force_measured"], np.interp(time, T - 0.5995, smooth), atol=3e-3
    )
    assert found.attrs["history"].count("\n") >= 8


def test_rounded_time_stamps_become_even_ones(tmp_path):
    stamps = np.floor(T * 250) / 250
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([stamps, FORCE]), delimiter=",", header="t [s],f [N]", comments=""
    )
    found = ev.import_file(tmp_path / "a.csv", {"lateral_force_measured": "f"})
    np.testing.assert_allclose(np.diff(found["time"]), stamps[-1] / (T.size - 1))
    assert "rounded to 4 ms" in found.attrs["history"]


def test_stamps_that_fall_are_refused_or_dropped(tmp_path):
    stamps = T.copy()
    stamps[[700, 701]] = stamps[[650, 699]]
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([stamps, FORCE]), delimiter=",", header="t [s],f [N]", comments=""
    )
    with pytest.raises(InputError, match="2 time stamps do not increase, the first at sample 700"):
        ev.import_file(tmp_path / "a.csv", {"lateral_force_measured": "f"})
    found = ev.import_file(tmp_path / "a.csv", {"lateral_force_measured": "f"}, stamps="keep_increasing")
    np.testing.assert_allclose(found["lateral_force_measured"], np.delete(FORCE, [700, 701]), rtol=1e-12)


def validity(found):
    return {each["name"]: each for each in json.loads(found.attrs["validity"])}


def test_faults_of_the_record_are_noticed(tmp_path):
    stamps = np.delete(T, slice(300, 305))
    railed = np.clip(np.delete(FORCE, slice(300, 305)), 0, 0.24)
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([stamps, railed]),
        delimiter=",",
        header="t [s],f [N]",
        comments="",
    )
    found = validity(ev.import_file(tmp_path / "a.csv", {"lateral_force_measured": "f"}))
    assert found["dropped samples"]["state"] == "warning"
    assert found["dropped samples"]["value"] == 5
    assert found["sensor range of lateral_force_measured"]["state"] == "warning"
    assert found["sensor range of lateral_force_measured"]["value"] == pytest.approx(np.mean(railed == 0.24))


def test_repeated_samples_and_aliasing_are_noticed(tmp_path):
    held = np.repeat(FORCE[::4], 4)
    square = 300.0 * (np.sin(2 * np.pi * 190.3 * T) > 0)
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([T, held, square]),
        delimiter=",",
        header="t [s],f [N],v [V]",
        comments="",
    )
    found = validity(ev.import_file(tmp_path / "a.csv", {"lateral_force_measured": "f"}))
    assert found["repeated samples"]["state"] == "warning"
    assert found["repeated samples"]["value"] == pytest.approx(0.75, abs=0.01)
    found = validity(ev.import_file(tmp_path / "a.csv", {"drive_voltage": "v"}))
    assert found["aliasing of drive_voltage"]["state"] == "warning"
    assert found["aliasing of drive_voltage"]["value"] == pytest.approx(190.3, abs=1)


def test_a_trace_is_saved_and_opened(record, tmp_path):
    found = ev.import_file(record, {"drive_voltage": "Ch1"})
    for suffix in (".nc", ".csv", ".mat"):
        ev.save(found, tmp_path / f"saved{suffix}")
        again = ev.open_trace(tmp_path / f"saved{suffix}")
        np.testing.assert_array_equal(again["drive_voltage"], found["drive_voltage"])
        assert again.attrs["history"] == found.attrs["history"]


def test_columns_are_listed(record):
    lines = "\n".join(list_columns(record))
    assert "reader 'text', 3 columns of 2000 samples" in lines
    assert "t  [ms]" in lines
    assert "the time" in lines
    assert "--column drive_voltage=" in lines


def test_interpolation_shift_and_trigger():
    time = np.array([0.0, 1, 2, 4])
    np.testing.assert_allclose(shifted(time, 3 * time, 0.5), [np.nan, 1.5, 4.5, 10.5])
    np.testing.assert_allclose(resampled(time, 3 * time, np.array([0.5, 1.0, 1.5])), [1.5, 3, 4.5])
    np.testing.assert_allclose(resampled(time, 3 * time, np.array([0.0, 2.0, 4.0])), [1.5, 6, 10.5])
    lost = np.array([0.0, np.nan, 6, 12])
    np.testing.assert_allclose(
        resampled(time, lost, np.array([0.0, 0.5, 1.5, 2.0, 2.5])), [0, np.nan, np.nan, 6, 7.5]
    )
    assert trigger_time(time, np.array([0.0, 0, 2, 2])) == pytest.approx(1.5)
    assert trigger_time(time, np.array([2.0, 2, 0, 0])) is None


GRID = np.geomspace(100, 1e5, 20)
EPS = 50 + 900 / (1 + 2j * np.pi * GRID * 1e-4) - 1j * 2e-6 / (2 * np.pi * GRID * 8.8541878188e-12)


def spectrum_file(folder, heading, *columns):
    np.savetxt(folder / "z.csv", np.column_stack(columns), delimiter=",", header=heading, comments="")
    return folder / "z.csv"


def test_an_impedance_is_a_trace_and_a_material(tmp_path):
    sample = 2e-4 / (2j * np.pi * GRID * 8.8541878188e-12 * 1e-4 * EPS)
    measured = 1 / (1 / (sample + 300) + 2j * np.pi * GRID * 3e-12)
    path = spectrum_file(tmp_path, "f [Hz],Z' [ohm],Z'' [ohm]", GRID, measured.real, measured.imag)
    np.testing.assert_allclose(ev.import_file(path)["impedance"], measured, rtol=1e-12)
    found = ev.import_material(
        path,
        area="1 cm2",
        thickness="200 um",
        series_resistance="300 ohm",
        parallel_capacitance="3 pF",
        conductivity="1 uS/m",
    )
    np.testing.assert_allclose(found.material.complex_permittivity(GRID), EPS, rtol=1e-6)
    assert found.thickness == 2e-4
    with pytest.raises(InputError, match=r"area: .* '1 cm2'"):
        ev.import_material(path, thickness="200 um")
    with pytest.raises(InputError, match="rows are those of no passive dielectric"):
        ev.import_material(path, area="1 cm2", thickness="200 um", series_resistance="1 Mohm")


def test_a_permittivity_without_loss_is_taken_for_what_it_is(tmp_path):
    found = ev.import_material(spectrum_file(tmp_path, "f,permittivity", GRID, EPS.real))
    assert "assumed to be 0" in found.diagnostics[0].text
    np.testing.assert_allclose(found.material.complex_permittivity(GRID), EPS.real, rtol=1e-12)
    with pytest.raises(InputError, match="area: the file holds a permittivity"):
        ev.import_material(tmp_path / "z.csv", area="1 cm2")


def test_the_written_material_goes_into_a_scenario(tmp_path):
    import tomllib

    path = spectrum_file(tmp_path, "f,permittivity,loss factor", GRID, EPS.real, -EPS.imag)
    found = ev.import_material(path, thickness="150 um")
    layer = tomllib.loads(found.to_toml("stratum_corneum"))["stack"]["stratum_corneum"]
    scenario = ev.load(
        "vezzoli_2014/fig6",
        changes={
            "stack.stratum_corneum.material": layer["material"],
            "stack.stratum_corneum.thickness": layer["thickness"],
        },
    )
    skin = scenario.stack.layers["stratum_corneum"]
    assert skin.thickness == 150e-6
    np.testing.assert_array_equal(
        skin.material.complex_permittivity(GRID), found.material.complex_permittivity(GRID)
    )


@pytest.mark.skipif(not SHARED.exists(), reason="needs shared/data, which is not part of the repository")
def test_a_real_spectrum_and_a_real_waveform():
    folder = SHARED / "skin_impedance"
    skin = ev.import_material(folder / "gabriel_measured_skin_dry.txt", thickness="1 mm")
    assert skin.material.frequency_samples.values.size == 156
    found = ev.import_file(SHARED / "oscilloscope" / "example.isf", {"drive_voltage": "Ch2"})
    assert found.sizes["time"] == 10_000


def test_very_uneven_and_very_large_numbers_need_no_memory(tmp_path):
    stamps = np.append(T[:-1], 1e12)
    huge = np.where(T < 1, -1e300, 1e300) * (1 + NOISE)
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([stamps, huge]), delimiter=",", header="t [s],v [V]", comments=""
    )
    found = validity(ev.import_file(tmp_path / "a.csv", {"drive_voltage": "v"}))
    assert "too uneven" in found["aliasing of drive_voltage"]["text"]
    with pytest.raises(InputError, match="at most 50000000 are allowed"):
        ev.import_file(tmp_path / "a.csv", {"drive_voltage": "v"}, resample="1 ms")
    np.savetxt(
        tmp_path / "b.csv", np.column_stack([T, huge]), delimiter=",", header="t [s],v [V]", comments=""
    )
    assert validity(ev.import_file(tmp_path / "b.csv", {"drive_voltage": "v"}))["aliasing of drive_voltage"]


def test_edges_and_averages_over_periods(tmp_path):
    time = np.arange(0, 2.03, 1e-3)
    gate = np.where((time * 4) % 1 < 0.25, 5.0, 0.0)
    force = 3 * np.exp(-((time * 4) % 1)) + np.random.default_rng(1).normal(0, 0.1, time.size)
    edges = find_edges(time, gate)
    np.testing.assert_allclose(edges.rising, 0.25 * np.arange(1, 9) - 5e-4)
    np.testing.assert_allclose(edges.falling, 0.25 * np.arange(8) + 0.0625, atol=1e-3)
    whole = average_periods(time, {"gate": gate, "force": force}, "gate")
    assert (whole.periods, whole.time.size) == (7, 250)
    assert whole.period == pytest.approx(0.25)
    np.testing.assert_allclose(
        whole.means["force"][2:-2], 3 * np.exp(-4 * (whole.time - 5e-4))[2:-2], atol=0.15
    )
    assert np.sqrt(np.mean(whole.standard_errors["force"][2:-2] ** 2)) == pytest.approx(
        0.1 / np.sqrt(14), rel=0.15
    )
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([time, gate, force]),
        delimiter=",",
        header="t [s],g [V],f [N]",
        comments="",
    )
    columns = {"drive_voltage": "g", "lateral_force_measured": "f"}
    found = ev.import_file(tmp_path / "a.csv", columns, average="drive_voltage")
    assert found.sizes["time"] == 250
    assert "averaged over 7 periods of drive_voltage, 250 ms" in found.attrs["history"]
    with pytest.raises(InputError, match="whole periods between rising edges"):
        ev.import_file(tmp_path / "a.csv", columns, average="drive_voltage", crop="0 s..0.6 s")
    with pytest.raises(InputError, match="its periods differ"):
        average_periods(time, {"f": np.sin(2 * np.pi * (3 * time + time**2))}, "f")


def test_quantised_noise_is_not_taken_for_repeated_samples(tmp_path):
    random = np.random.default_rng(8)
    rounded = np.round(random.normal(0, 4.0, (T.size, 1)) + 100)
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([T, rounded]), delimiter=",", header="t [s],v [mV]", comments=""
    )
    found = validity(ev.import_file(tmp_path / "a.csv", {"drive_voltage": "v"}))["repeated samples"]
    assert found["state"] == "ok"
    seen, explained = (float(part.split()[-1]) for part in found["text"].split("%")[:2])
    assert seen == pytest.approx(7.05, abs=1.5)  # 1/(2 sqrt(pi) 4)
    assert explained == pytest.approx(7.05, abs=1)


def test_edges_between_samples_are_said_to_alias(tmp_path):
    square = 300.0 * (np.sin(2 * np.pi * 80.3 * T) > 0) + NOISE
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([T, square]), delimiter=",", header="t [s],v [V]", comments=""
    )
    found = validity(ev.import_file(tmp_path / "a.csv", {"drive_voltage": "v"}))["aliasing of drive_voltage"]
    assert found["state"] == "warning"
    assert "every 6.2" in found["text"]


CALIBRATION = "reading [mV];F [N]\n" + "\n".join(f"{1e3 * (0.1 + 0.4 * f + e):.6g};{f}" for f, e in
                                                zip((0, 1, 2, 3, 4), (2e-3, -1e-3, 1e-3, -3e-3, 1e-3), strict=True))  # fmt: skip


def calibrated(tmp_path, **options):
    (tmp_path / "cal.csv").write_text(CALIBRATION, encoding="utf-8")
    rows = "\n".join(f"{at * 1e-3:.3f},{0.1 + 0.4 * (at % 4):.4f}" for at in range(40))
    (tmp_path / "a.csv").write_text("t [s],u [V]\n" + rows, encoding="utf-8")
    columns = {"lateral_force_measured": "u"}
    files = {"lateral_force_measured": tmp_path / "cal.csv"}
    return ev.import_file(tmp_path / "a.csv", columns, calibration=files, **options)


def error_of(trace):
    return MeasuredTrace(trace=trace).calibration_of("lateral_force_measured")


def test_the_covariance_of_a_calibration_goes_with_the_signal(tmp_path):
    trace = calibrated(tmp_path)
    readings, known = 0.1 + 0.4 * np.arange(5) + [2e-3, -1e-3, 1e-3, -3e-3, 1e-3], np.arange(5.0)
    line = ev.calibrate(readings, known)
    force = trace["lateral_force_measured"].values
    np.testing.assert_allclose(force[:4], line.value(0.1 + 0.4 * np.arange(4)), rtol=1e-9)
    found = error_of(trace)
    # the variance of each value by zero and scale is that by the line, at every reading
    by_parts = found.zero**2 + 2 * force * found.covariance + (force * found.gain) ** 2
    by_line = line.standard_uncertainty(0.1 + 0.4 * (np.arange(40) % 4)) ** 2
    np.testing.assert_allclose(by_parts, by_line, rtol=1e-9)
    assert found.gain == pytest.approx(np.sqrt(line.covariance[1, 1]) / line.sensitivity)
    ev.save(trace, tmp_path / "a.nc")
    assert error_of(ev.open_trace(tmp_path / "a.nc")) == found


def test_a_baseline_removes_the_uncertainty_of_the_zero(tmp_path):
    one = error_of(calibrated(tmp_path))
    for option in (
        {"baseline": {"lateral_force_measured": "0 s..5 ms"}},
        {"detrend": ["lateral_force_measured"]},
    ):
        two = error_of(calibrated(tmp_path, **option))
        assert two == CalibrationError(gain=one.gain)
        assert one.zero > 0


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        (
            "a [V];b [N];c [V]\n0;1;2\n1;2;3\n2;3;4\n",
            {},
            "expected two columns, the reading and the known value",
        ),
        ("a;b [N]\n0;1\n1;2\n2;3\n", {}, "column 'a' needs a unit that is known"),
        ("a [V];b [m]\n0;1\n1;2\n2;3\n", {}, "column 'b' needs a unit of N in its heading"),
        ("a [V];b [N]\n0;1\n0;2\n0;3\n", {}, "all readings are equal"),
        (
            "a [V];b [N]\n0;1\n1;2\n2;3\n",
            {"scale": {"lateral_force_measured": "1 N/V"}},
            "a scale is given too",
        ),
    ],
)
def test_what_is_no_calibration_is_refused(tmp_path, monkeypatch, text, options, words):
    monkeypatch.setitem(globals(), "CALIBRATION", text)
    with pytest.raises(InputError, match=words):
        calibrated(tmp_path, **options)


def test_a_column_for_the_time_is_answered_with_its_option(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,f\n0,1\n1,2\n", encoding="utf-8")
    with pytest.raises(
        InputError, match=r"columns.time: 'time' is not a signal over time. .* chosen with --set time="
    ):
        ev.import_file(path, columns={"time": "t", "lateral_force_measured": "f"})


@pytest.mark.parametrize(("noise", "state"), [(1.0, "warning"), (0.3, "unknown"), (0.0, "unknown")])
def test_a_rail_beside_a_long_zero_is_noticed(tmp_path, noise, state):
    """The zero before and after the contact is read more often than the rail, which was not noticed then."""
    time, rng = np.linspace(0, 1, 841), np.random.default_rng(3)
    pressed = 900 * np.clip(np.sin(np.pi * (time - 0.2) / 0.6), 0, None) * (time < 0.8)
    force = np.minimum(np.round(pressed + noise * rng.normal(size=841)), 749.0)
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([time, force]), delimiter=",", header="t (s),Fz (N)", comments=""
    )
    found = ev.import_file(tmp_path / "a.csv", {"normal_force": "Fz"})
    (said,) = [
        each for each in json.loads(found.attrs["validity"]) if each["name"].startswith("sensor range")
    ]
    assert said["state"] == state
    ends = (force == 749) | (
        (force == 0) & (noise == 0)
    )  # without noise the zero is an extreme that repeats too
    assert f"{np.mean(ends):.2%} of the samples" in said["text"]


def test_what_is_constant_or_has_two_levels_is_no_rail():
    from electrovib.recordings.rail import at_extreme, at_rail

    rng, time = np.random.default_rng(0), np.linspace(0, 1, 4000)
    sine = np.round(100 * np.sin(20 * time))
    for values in (
        sine,
        np.round(sine + rng.normal(size=4000)),
        np.sign(sine),
        np.zeros(50),
        rng.normal(size=4000),
    ):
        assert not at_extreme(values).any()
        assert not at_rail(values).any()
    clipped = np.minimum(np.round(sine + rng.normal(size=4000)), 70)
    np.testing.assert_array_equal(at_rail(clipped), clipped == 70)
