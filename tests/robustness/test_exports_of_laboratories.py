"""Exports of scopes, loggers and scripts, of known arrays, that lost a factor, a sign or a row: right, or asked for by name."""

import h5py
import numpy as np
import pytest
from scipy.io import savemat

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.importing.import_file import list_columns

ROWS = np.arange(60)
TIME = np.round(ROWS * 0.005, 6)
FORCE = np.round(0.3 + 0.1 * np.sin(ROWS / 7.3) + 0.01 * np.cos(ROWS * 2.1), 5)
VOLTAGE = np.round(90 * np.sin(ROWS / 5.1), 3)
MILLISECONDS = np.round(1e3 * TIME).astype(int)
MILLINEWTONS = np.round(1e3 * FORCE, 2)


def lines(*columns, separator=",", end=""):
    """Rows of text of some columns."""
    return "".join(separator.join(map(str, row)) + end + "\n" for row in zip(*columns, strict=True))


def imported(path, text, columns, **options):
    """Write a text and import columns of it."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return ev.import_file(path, columns, **options)


EXPORTS = {
    "a dash of Windows for the minus": (
        ("t [ms];F [mN];U [V]\n" + lines(MILLISECONDS, MILLINEWTONS, VOLTAGE, separator=";"))
        .replace("-", "\u2013").encode("cp1252"), {"lateral_force": "F", "drive_voltage": "U"},
    ),
    "a power of ten before the unit": (
        "Time [10^-3 s],Force [1e-3 N],U (×10⁻³ V)\n" + lines(MILLISECONDS, MILLINEWTONS, 1e3 * VOLTAGE),
        {"lateral_force": "Force", "drive_voltage": "U"},
    ),
    "units at the end of the names of a script": (
        "millis,force_mN,u_kV\n" + lines(MILLISECONDS, MILLINEWTONS, VOLTAGE / 1e3),
        {"lateral_force": "force_mN", "drive_voltage": "u_kV"},
    ),
    "time step and units in headings of Rigol": (
        "CH1V,CH2(mN),t0 =-0.1, tInc = 0.005,\n" + lines(VOLTAGE, MILLINEWTONS, end=",,"),
        {"drive_voltage": "CH1", "lateral_force": "CH2"}, -0.1,
    ),
    "a name less than there are units": (
        "HBM_CATMAN\t5.0\nTime 1 - default rate\tForce\tU\nSample rate: 200 Hz\n\tSensor 1\tSensor 2\ns\tmN\tV\n"
        + lines(TIME, MILLINEWTONS, VOLTAGE, separator="\t"), {"lateral_force": "Sensor 1", "drive_voltage": "Sensor 2"},
    ),
    "units of LabChart": (
        "Interval=\t5 ms\nChannelTitle=\tForce\tU\nRange=\t1 N\t100 V\nUnitName=\tmN\tV\n"
        + lines(TIME, MILLINEWTONS, VOLTAGE, separator="\t"), {"lateral_force": "Force", "drive_voltage": "U"},
    ),
    "numbers of samples above the samples": (
        "skin.acq\n2 channels\nsec,CH1,CH2,\n,60,60,\n" + lines(TIME, FORCE, VOLTAGE, end=","),
        {"lateral_force": "CH1 [N]", "drive_voltage": "CH2 [V]"}, 0.0, {"time": "sec [s]"},
    ),
    "a sampling rate in German": (
        "Abtastrate [Hz];200,0\nKraft [mN];Spannung [V]\n" + lines(MILLINEWTONS, VOLTAGE, separator=";").replace(".", ","),
        {"lateral_force": "Kraft", "drive_voltage": "Spannung"},
    ),
    "a mass of a load": (
        "Time (sec),Load (grams),u (V)\n" + lines(TIME, FORCE / 9.80665e-3, VOLTAGE),
        {"lateral_force": "Load", "drive_voltage": "u"},
    ),
}  # fmt: skip
"""Name to the text, the columns, the time of the first sample, and options."""


@pytest.mark.parametrize("name", EXPORTS)
def test_values_and_times_are_those_that_were_written(tmp_path, name):
    text, columns, *more = EXPORTS[name]
    trace = imported(tmp_path / "a.csv", text, columns, **(more[1] if len(more) > 1 else {}))
    np.testing.assert_allclose(trace.time, TIME + (more[0] if more else 0.0), atol=1e-9)
    np.testing.assert_allclose(trace.lateral_force, FORCE, atol=1e-5)
    np.testing.assert_allclose(trace.drive_voltage, VOLTAGE, atol=1e-9)


@pytest.mark.parametrize(
    ("headings", "columns", "said"),
    [
        ("Time (s),Load (MN),U (V)", {"normal_force": "Load (MN)"}, "states no unit"),
        ("Time (s),Force,U (MV)", {"drive_voltage": "U (MV)"}, "states no unit"),
        ("Time,Force,U\nS,MN,KV", {"lateral_force": "Force"}, "states no unit"),
        ("Time (s) x10^-3,Force (N),U (V)", {"lateral_force": "Force"}, "states no unit for 'Time"),
        ("Time (s),Force (N) x1e-3,U (V)", {"lateral_force": "Force (N) x1e-3"}, r"'Force \(N\) x1e-3 \[UNIT\]'"),
        ("Time (s),load_g,U (V)", {"lateral_force": "load_g"}, r"'load_g \[gf\]'"),
        ("Time (s),force_mN,U (V)", {"lateral_force": "force_mN [N]"}, "states the unit 'mN'"),
    ],
)  # fmt: skip
def test_a_factor_of_a_thousand_that_is_open_is_asked_for(tmp_path, headings, columns, said):
    with pytest.raises(InputError, match=said):
        imported(tmp_path / "a.csv", f"{headings}\n{lines(TIME, FORCE, VOLTAGE)}", columns)


def test_a_unit_in_capitals_is_taken_as_stated(tmp_path):
    text = "TIME (MS),LOAD (MN)\n" + lines(MILLISECONDS, MILLINEWTONS)
    trace = imported(tmp_path / "a.csv", text, {"normal_force": "LOAD (MN) [mN]"})
    np.testing.assert_allclose(trace.normal_force, FORCE, atol=1e-5)
    np.testing.assert_allclose(trace.time, TIME, atol=1e-9)


@pytest.mark.parametrize("factors", ["0.001,0.001", "1,0.5"])
def test_factors_above_the_numbers_are_refused_unless_they_are_one(tmp_path, factors):
    text = "Channel,Time,Force\nUnit,s,N\nScale factor,{}\nOffset,0,0\nData,,\n" + lines(
        [""] * len(ROWS), TIME, FORCE
    )
    with pytest.raises(InputError, match=f"'Scale factor,{factors}' stands above the numbers"):
        imported(tmp_path / "a.csv", text.format(factors), {"lateral_force": "Force"})
    trace = imported(tmp_path / "a.csv", text.format("1,1"), {"lateral_force": "Force"})
    np.testing.assert_allclose(trace.lateral_force, FORCE)


def test_the_overflow_of_catman_is_no_reading(tmp_path):
    force = [-1000000 if row in (5, 6) else each for row, each in enumerate(MILLINEWTONS)]
    trace = imported(
        tmp_path / "a.csv",
        "Time\tForce\ns\tmN\n" + lines(TIME, force, separator="\t"),
        {"lateral_force": "Force"},
    )
    np.testing.assert_allclose(trace.lateral_force, np.where(np.isin(ROWS, (5, 6)), np.nan, FORCE), atol=1e-5)


def test_a_column_of_units_is_that_of_the_readings_before_it(tmp_path):
    path = tmp_path / "a.csv"
    text = '"Index","Reading","Unit","Time (s)"\n' + lines(ROWS + 1, VOLTAGE / 1e9, ['"Amp"'] * 60, TIME)
    trace = imported(path, text, {"current": "Reading"})
    np.testing.assert_allclose(trace.current, VOLTAGE / 1e9)
    with pytest.raises(InputError, match="it is in 'A'"):
        imported(path, text, {"drive_voltage": "Reading"})
    mixed = text.replace('"Amp"', '"Volt"', 1)
    with pytest.raises(InputError, match="states no unit"):
        imported(path, mixed, {"current": "Reading"})


def test_a_counter_is_no_force(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("F/T Sequence,Fx,Fz,Time (s)\n" + lines(7 * ROWS, FORCE, 5 * FORCE, TIME))
    proposed = "\n".join(list_columns(path))
    assert 'lateral_force="Fx [N]" --column normal_force="Fz [N]"' in proposed


def test_times_behind_a_signal_that_are_later_are_named(tmp_path):
    path = tmp_path / "a.csv"
    text = "Time A (s),U (V),Time B (ms),F (N)\n" + lines(TIME, VOLTAGE, MILLISECONDS + 1, FORCE)
    trace = imported(path, text, {"lateral_force": "F", "drive_voltage": "U"})
    assert "they are 1 ms later than those of 'Time A'" in trace.attrs["history"]
    np.testing.assert_allclose(imported(path, text, {"lateral_force": "F"}, time="Time B").time, TIME + 0.001)
    beside = "Time A (s),Time B (ms),U (V),F (N)\n" + lines(TIME, MILLISECONDS + 1, VOLTAGE, FORCE)
    assert "are 1 ms later" not in imported(path, beside, {"lateral_force": "F"}).attrs["history"]


@pytest.mark.parametrize("of_group", [False, True])
def test_counts_with_a_factor_that_is_no_standard_have_no_unit(tmp_path, of_group):
    path, counts = tmp_path / "a.h5", np.round(VOLTAGE * 300).astype("i2")
    with h5py.File(path, "w") as file:
        group = file.create_group("ch1")
        group["u"] = counts
        group["u"].attrs["units"] = "V"
        (group if of_group else group["u"]).attrs["YInc" if of_group else "gain"] = 1 / 300
    with pytest.raises(InputError, match="states no unit"):
        ev.import_file(path, {"drive_voltage": "ch1/u"}, step="5 ms")
    assert "= 0.00333333: it is not applied to 'ch1/u'" in "\n".join(list_columns(path))
    trace = ev.import_file(
        path, {"drive_voltage": "ch1/u [V]"}, step="5 ms", scale={"drive_voltage": 1 / 300}
    )
    np.testing.assert_allclose(trace.drive_voltage, counts / 300)
    with h5py.File(path, "a") as file:
        file["ch1/u"].attrs["scale_factor"] = 1 / 300  # which is applied
        (file["ch1"] if of_group else file["ch1/u"]).attrs.pop("YInc" if of_group else "gain")
    trace = ev.import_file(path, {"drive_voltage": "ch1/u"}, step="5 ms")
    np.testing.assert_allclose(trace.drive_voltage, counts / 300)


def test_channels_of_labchart_one_behind_the_other_are_refused(tmp_path):
    path = tmp_path / "a.mat"
    ends = np.array([[60.0], [120.0]])
    savemat(path, {"data": np.append(FORCE, VOLTAGE)[None], "datastart": ends - 59, "dataend": ends})
    with pytest.raises(InputError, match=r"data\(datastart\(1\):dataend\(1\)\)"):
        ev.import_file(path, {"lateral_force": "data [N]"}, step="5 ms")


def test_stamps_of_tdms_are_times(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "a.tdms"
    stamps = np.datetime64("2026-11-28T10:00:00") + (1e6 * TIME).astype("m8[us]")
    with nptdms.TdmsWriter(str(path)) as file:
        force = nptdms.ChannelObject("G", "F", FORCE, {"unit_string": "N"})
        file.write_segment([nptdms.ChannelObject("G", "At", stamps), force])
    trace = ev.import_file(path, {"lateral_force": "G/F"})
    np.testing.assert_allclose(trace.time, TIME, atol=1e-9)
    np.testing.assert_allclose(trace.lateral_force, FORCE)


FREQUENCIES = np.logspace(2, 5, 31)
PART = 1 / (1 / 50e3 + 2j * np.pi * FREQUENCIES * 1e-9)


def test_a_spectrum_of_a_keysight_analyser(tmp_path):
    text = "!CSV A.01.01\n!Date: Sat\n\nBEGIN CH1_DATA\nFrequency(Hz),|Z|(Ohm)-data,theta-z(deg)-data\n"
    trace = imported(
        tmp_path / "a.csv", text + lines(FREQUENCIES, np.abs(PART), np.angle(PART, deg=True)) + "END\n", {}
    )
    np.testing.assert_allclose(trace.impedance, PART)
    assert '"warning"' not in trace.attrs["validity"]


@pytest.mark.parametrize(
    ("headings", "scale"), [("Z' (ohm),Z'' (ohm)", "imaginary"), ("|Z| (ohm),Phase (deg)", "phase")]
)
def test_a_capacitor_that_looks_like_a_coil_is_warned_of(tmp_path, headings, scale):
    columns = (PART.real, -PART.imag) if scale == "imaginary" else (np.abs(PART), -np.angle(PART, deg=True))
    text = f"Frequency (Hz),{headings}\n{lines(FREQUENCIES, *columns)}"
    trace = imported(tmp_path / "a.csv", text, {})
    assert "is above 0, as of a coil, at 100% of the frequencies" in trace.attrs["validity"]
    meanings = {"frequency": "Frequency", scale: headings.split(",")[1]}
    meanings |= {"real": "Z'"} if scale == "imaginary" else {"modulus": "|Z|"}
    trace = imported(tmp_path / "a.csv", text, meanings, scale={scale: -1})
    np.testing.assert_allclose(trace.impedance, PART)
    assert "coil" not in trace.attrs["validity"]
    resistor = f"Frequency (Hz),Z' (ohm),Z'' (ohm)\n{lines(FREQUENCIES, 1 + 0 * FREQUENCIES, np.sin(37 * FREQUENCIES))}"
    assert "coil" not in imported(tmp_path / "a.csv", resistor, {}).attrs["validity"]


@pytest.mark.parametrize(
    "rate", ["0.2,kS/s", "0.2,ksps", "0.2,kHz", "200,Samples/s", "200,S/s", "200,CH1", "200,250"]
)
def test_the_unit_of_a_rate_may_stand_in_the_next_field(tmp_path, rate):
    text = f"Sample Rate:,{rate}\nF [N],U [V]\n{lines(FORCE, VOLTAGE)}"
    trace = imported(tmp_path / "a.csv", text, {"lateral_force": "F"})
    np.testing.assert_allclose(trace.time, TIME, atol=1e-9)


@pytest.mark.parametrize("step", ["5000,us", "5,ms", "0.005,s", "0.005,"])
def test_the_unit_of_a_step_may_stand_in_the_next_field(tmp_path, step):
    text = f"Sample Interval,{step}\nF [N],U [V]\n{lines(FORCE, VOLTAGE)}"
    trace = imported(tmp_path / "a.csv", text, {"lateral_force": "F"})
    np.testing.assert_allclose(trace.time, TIME, atol=1e-9)


@pytest.mark.parametrize(("rate", "is_one"), [("200 Hz", True), ("199 Hz", True), ("100 Hz", False)])
def test_two_steps_of_a_preamble_that_contradict_each_other_are_named(tmp_path, rate, is_one):
    path = tmp_path / "a.csv"
    text = f"dt = 5 ms\nfs = {rate}\nF [N]\tU [V]\n" + lines(FORCE, VOLTAGE, separator="\t")
    if is_one:
        np.testing.assert_allclose(imported(path, text, {"lateral_force": "F"}).time, TIME, atol=1e-9)
        return
    with pytest.raises(InputError, match="neither times nor a time step"):
        imported(path, text, {"lateral_force": "F"})
    assert "the file states 5 ms by 'dt', 10 ms by 'fs'" in "\n".join(list_columns(path))
    assert imported(path, text, {"lateral_force": "F"}, step="5 ms").time[1] == 0.005


def test_days_of_a_spreadsheet_are_no_seconds(tmp_path):
    path = tmp_path / "a.csv"
    text = "Time,F [N]\n" + lines([f"{46354.4 + row / 86400:.10f}" for row in ROWS], FORCE)
    with pytest.raises(InputError, match="states no unit for 'Time'"):
        imported(path, text, {"lateral_force": "F"})
    trace = imported(path, text, {"lateral_force": "F"}, time="Time [day]")
    np.testing.assert_allclose(trace.time - trace.time[0], ROWS, atol=1e-4)
    started = "Time,F [N]\n" + lines(TIME + 20, FORCE)  # 68 lengths of the record after zero
    np.testing.assert_allclose(imported(path, started, {"lateral_force": "F"}).time, TIME + 20)


def test_a_rule_below_the_numbers_is_no_row(tmp_path):
    path = tmp_path / "a.csv"
    text = "Time [s],F [N]\n" + lines(TIME, FORCE) + "-----\nMax 0.4\n"
    np.testing.assert_allclose(imported(path, text, {"lateral_force": "F"}).lateral_force, FORCE)
    assert "2 lines, 62 to 63: no samples" in "\n".join(list_columns(path))
