"""A measured drive: its values, its stamps, its files, and what is refused."""

from __future__ import annotations

import json
from contextlib import chdir

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.sampled import KeepIncreasing
from electrovib.scenario import read_part

TIME = np.array([5e-3, 6e-3, 8e-3, 9e-3])
VOLTAGE = np.array([0.0, 10.0, -10.0, 4.0])
KEEP = {"stamps": {"model": "KeepIncreasing"}}


def sampled(time=TIME, voltage=VOLTAGE, **changes):
    return read_part(Drive, {"model": "Sampled", "time_samples": time, "voltage_samples": voltage} | changes)


def refusal(**content):
    with pytest.raises(InputError) as caught:
        read_part(Drive, {"model": "Sampled"} | content)
    assert len(caught.value.problems) == 1
    return caught.value.problems[0]


def test_counts_from_the_first_sample_and_is_straight_between():
    drive = sampled()
    asked = [-1e-3, 0.0, 0.5e-3, 1e-3, 2e-3, 3e-3, 3.25e-3, 4e-3, 1.0, np.nan]
    wanted = [0.0, 0.0, 5.0, 10.0, 0.0, -10.0, -6.5, 4.0, 4.0, np.nan]
    # 5 ms + 1 ms - 5 ms is not 1 ms to the last digit, times a slope of 20 V/ms.
    assert drive.voltage(asked) == pytest.approx(wanted, abs=1e-10, nan_ok=True)
    assert drive.duration == pytest.approx(4e-3, rel=1e-12, abs=0)
    assert drive.time_stamps == pytest.approx(TIME - 5e-3, abs=0)
    assert drive.period is None
    assert drive.dropped == 0


def test_first_sample_is_a_jump_from_zero():
    drive = sampled(voltage=VOLTAGE + 7)
    assert drive.voltage([-1e-12, 0.0]) == pytest.approx([0, 7])
    (part,) = drive.parts()
    assert (part.before[0], part.after[0]) == (0, 7)
    assert np.array_equal(part.before[1:], part.after[1:])


# ------------------------------------------------------------------------------ stamps


@pytest.mark.parametrize(
    ("time", "words"),
    [
        ([0, 1e-3, 1e-3, 2e-3], "1 of 4 time stamps do not: sample 2 (0.001 s) repeats after 0.001 s"),
        ([0, 2e-3, 1e-3, 1e-3], "2 of 4 time stamps do not: sample 2 (0.001 s) goes back after 0.002 s"),
    ],
)
def test_stamps_that_do_not_increase_are_refused_with_the_remedy(time, words):
    said = refusal(time_samples=time, voltage_samples=VOLTAGE)
    assert words in said
    assert 'add stamps = { model = "KeepIncreasing" } to the drive' in said


@pytest.mark.parametrize(
    ("time", "kept"),
    [
        ([0, 1, 1, 2], [0, 1, 3]),
        ([0, 2, 1, 3], [0, 1, 3]),
        # A step back that lasts: nothing is kept until the stamps are later than all before.
        ([0, 3, 1, 2, 3, 4], [0, 1, 5]),
        ([0, 0, 0, 1], [0, 3]),
        ([0, 1, 2, 3], [0, 1, 2, 3]),
    ],
)
def test_keep_increasing_drops_what_is_not_later_than_all_before(time, kept):
    time = np.array(time, float) * 1e-3
    voltage = np.arange(len(time), dtype=float)
    drive = sampled(time, voltage, **KEEP)
    assert drive.dropped == len(time) - len(kept)
    assert np.array_equal(drive.time_stamps, time[kept])
    assert np.array_equal(drive.voltage(time[kept]), voltage[kept])


@given(steps=st.lists(st.integers(-3, 3), min_size=1, max_size=30))
@settings(max_examples=60, deadline=None)
def test_kept_stamps_increase_and_reach_the_latest(steps):
    time = np.concatenate([[0], np.cumsum(steps)]).astype(float)
    kept = KeepIncreasing().keep(time)
    assert kept[0]
    assert np.all(np.diff(time[kept]) > 0)
    assert time[kept][-1] == time.max()
    assert np.array_equal(
        np.flatnonzero(kept), np.unique(np.searchsorted(np.maximum.accumulate(time), time[kept]))
    )


def test_nothing_left_to_drive_with():
    assert "fewer than 2 samples are left" in refusal(
        time_samples=[1, 1, 0], voltage_samples=[1, 2, 3], **KEEP
    )


# ------------------------------------------------------------------------------ what is refused


@pytest.mark.parametrize(
    ("time", "voltage", "words"),
    [
        ([], [], 'holds no samples: name the record, for instance file = "record.csv"'),
        ([0.0], [1.0], "at least 2 samples, not 1"),
        ([0, 1, 2], [0, 1], "3 time stamps but 2 voltages"),
        ([0, 1, 2], [0, np.nan, 2], "the voltage of sample 1 is not a finite number"),
        ([0, 1, np.inf], [0, 1, 2], "the time of sample 2 is not a finite number"),
        ([0, np.nan, np.nan], [0, 1, np.nan], "the time of sample 1 is not a finite number"),
    ],
)
def test_bad_samples(time, voltage, words):
    assert words in refusal(time_samples=time, voltage_samples=voltage)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,voltage\n0,0\n1,off\n2,0\n", "line 3, column 'voltage': 'off' is not a number"),
        ("time,voltage\n0,0\n1,nan\n2,0\n", "line 3, column 'voltage': nan is not a finite number"),
        ("time,voltage\n0,0\n", "only one row"),
        ("time,voltage\n", "no rows"),
        ("", "the file is empty"),
        ("time,volts\n0,0\n1,1\n", "no column 'voltage'. Did you mean 'volts'?"),
        ("time [V],voltage\n0,0\n1,1\n", "is in 'V', but a time is needed"),
        ("time,voltage\n0,0\n0,1\n", "repeats"),
    ],
)
def test_bad_files_are_told_in_one_line(tmp_path, text, words):
    (tmp_path / "record.csv").write_text(text, encoding="utf-8")
    with chdir(tmp_path):
        said = refusal(file="record.csv")
    assert words in said
    assert "\n" not in said


def test_missing_file_names_the_nearest(tmp_path):
    (tmp_path / "record.csv").write_text("time,voltage\n0,0\n1,1\n", encoding="utf-8")
    with chdir(tmp_path):
        said = refusal(file="recrod.csv")
    assert "there is no such file. Did you mean 'record.csv'?" in said


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"time_unit": "V"}, "time_unit = 'V': the column holds a time: expected a unit such as 's'"),
        ({"voltage_unit": "s"}, "voltage_unit = 's': the column holds a voltage"),
        ({"time_unit": "9**9**9"}, "time_unit = '9**9**9'"),
        ({"time_unit": "2 s"}, "time_unit = '2 s'"),
        ({"time_unit": ""}, "time_unit = ''"),
    ],
)
def test_units_are_of_the_right_kind(tmp_path, changes, words):
    (tmp_path / "record.csv").write_text("time,voltage\n0,0\n1,1\n", encoding="utf-8")
    with chdir(tmp_path):
        assert words in refusal(file="record.csv", **changes)


# ------------------------------------------------------------------------------ files


def write_csv(path):
    rows = [f"{t!r},{v!r}" for t, v in zip((TIME * 1e6).tolist(), (VOLTAGE / 1e3).tolist(), strict=True)]
    path.write_text("\n".join(["time [us],voltage [kV]", *rows]), encoding="utf-8")
    return {}


def write_npy(path):
    np.save(path, np.column_stack([VOLTAGE, np.zeros(4), TIME * 1e6]))
    return {"time_column": 2, "time_unit": "us", "voltage_column": 0}


def write_netcdf(path):
    import xarray

    record = xarray.Dataset({"voltage": ("time", VOLTAGE, {"units": "V"})}, {"time": ("time", TIME)})
    record.to_netcdf(path, engine="h5netcdf")
    return {}


WRITERS = {"record.csv": write_csv, "record.npy": write_npy, "record.nc": write_netcdf}


@pytest.mark.parametrize("name", WRITERS)
def test_reads_the_same_record_from_every_kind_of_file(tmp_path, name):
    content = {"model": "Sampled", "file": name} | WRITERS[name](tmp_path / name)
    with chdir(tmp_path):
        drive = read_part(Drive, content)
    # A unit other than that of SI costs one rounding.
    assert drive.time_samples.values == pytest.approx(TIME, rel=1e-15, abs=0)
    assert drive.voltage_samples.values == pytest.approx(VOLTAGE, rel=1e-15, abs=0)
    assert drive.time_samples.values != pytest.approx(TIME * (1 + 3e-15), rel=1e-15, abs=0)


def test_record_travels_with_its_numbers_and_not_with_its_file(tmp_path):
    write_csv(tmp_path / "record.csv")
    with chdir(tmp_path):
        drive = read_part(Drive, {"model": "Sampled", "file": "record.csv"})
    (tmp_path / "record.csv").unlink()
    text = json.dumps(drive.to_dict(), default=lambda samples: samples.packed())
    again = read_part(Drive, json.loads(text))
    assert again == drive
    assert again.voltage_samples.values.tobytes() == drive.voltage_samples.values.tobytes()


def test_equality_and_hash_see_the_last_digit():
    voltage = VOLTAGE.copy()
    assert sampled() == sampled(voltage=voltage)
    voltage[1] = np.nextafter(voltage[1], 11)
    assert sampled() != sampled(voltage=voltage)
    assert sampled().digest() != sampled(voltage=voltage).digest()


def test_samples_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        sampled().voltage_samples.values[0] = 1.0


# ------------------------------------------------------------------ the range of the other drives


@pytest.mark.parametrize(
    ("time", "voltage", "words"),
    [
        ([0, 1e-3, 2e-3], [0, 1e200, 0], "the voltage of sample 1 is 1e+200 V, but a drive lies between -100 kV and 100 kV"),
        ([0, 1e-3, 2e-3], [0, 0, -100_001], "the voltage of sample 2 is -100001 V"),
        ([0, 1e-310, 2e-310], [0, 1, 0], "the record lasts 2e-310 s, but a drive lasts between 1 ns and 1 Ms"),
        ([0, 1e-10, 9e-10], [0, 1, 0], "the record lasts 9e-10 s"),
        ([0, 1, 1.1e6], [0, 1, 0], "the record lasts 1.1e+06 s"),
        ([-1.7e308, 0, 1.7e308], [0, 1, 0], "the record lasts inf s"),
        ([0, 1e-3, 2e-3, 2e-3], [0, 1, 2, 3], "must increase"),
        ([0, 9e-25, 1e-3], [0, 1, 0], "samples 0 and 1 of those kept are less than 1e-24 s apart"),
    ],
)  # fmt: skip
def test_records_out_of_the_range_of_drives(time, voltage, words):
    assert words in refusal(time_samples=time, voltage_samples=voltage)


@pytest.mark.parametrize(
    ("time", "voltage"),
    [([0, 1e-9], [1e5, -1e5]), ([0, 1e6], [0, 1]), ([0, 1e-24, 1], [0, 1, 0]), ([1.7e9, 1.7e9 + 1], [0, 1])],
)
def test_records_at_the_ends_of_the_range(time, voltage):
    assert sampled(time=time, voltage=voltage).duration == pytest.approx(time[-1] - time[0])


def test_a_column_is_a_name_or_a_whole_number(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "d.csv").write_text("time,voltage\n0,0\n1,10\n", encoding="utf-8")
    with pytest.raises(InputError, match="time_column"):
        read_part(Drive, {"model": "Sampled", "file": "d.csv", "time_column": 1.5})
