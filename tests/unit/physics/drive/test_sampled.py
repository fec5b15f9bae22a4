"""A measured drive: its values, its stamps, its files, a record of one of two electrodes, and what is refused."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.readback import OneOfTwoInAntiphase
from electrovib.physics.drive.sampled import KeepIncreasing
from electrovib.scenario import load, read_part

TIME = np.array([5e-3, 6e-3, 8e-3, 9e-3])
VOLTAGE = np.array([0.0, 10.0, -10.0, 4.0])
KEEP = {"stamps": {"model": "KeepIncreasing"}}


def read(**content):
    return read_part(Drive, {"model": "Sampled"} | content)


def sampled(time=TIME, voltage=VOLTAGE, **changes):
    return read(time_samples=time, voltage_samples=voltage, **changes)


def refusal(**content):
    with pytest.raises(InputError) as caught:
        read(**content)
    (problem,) = caught.value.problems
    assert "\n" not in problem
    return problem


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "record.csv").write_text("time,voltage\n0,0\n1,1\n", encoding="utf-8")
    return tmp_path


def test_counts_from_the_first_sample_and_is_straight_between():
    drive = sampled()
    asked = [-1e-3, 0.0, 0.5e-3, 1e-3, 2e-3, 3e-3, 3.25e-3, 4e-3, 1.0, np.nan]
    wanted = [0.0, 0.0, 5.0, 10.0, 0.0, -10.0, -6.5, 4.0, 4.0, np.nan]
    # 5 ms + 1 ms - 5 ms is not 1 ms to the last digit, times a slope of 20 V/ms.
    assert drive.voltage(asked) == pytest.approx(wanted, abs=1e-10, nan_ok=True)
    assert drive.duration == pytest.approx(4e-3, rel=1e-12, abs=0)
    assert drive.time_stamps == pytest.approx(TIME - 5e-3, abs=0)
    assert (drive.period, drive.dropped) == (None, 0)
    raised = sampled(voltage=VOLTAGE + 7)
    assert raised.voltage([-1e-12, 0.0]) == pytest.approx([0, 7])  # the first sample is a jump
    (part,) = raised.parts()
    assert (part.before[0], part.after[0]) == (0, 7)
    assert np.array_equal(part.before[1:], part.after[1:])


@pytest.mark.parametrize(
    ("time", "kept"),
    [
        ([0, 1, 1, 2], [0, 1, 3]),
        ([0, 2, 1, 3], [0, 1, 3]),
        ([0, 3, 1, 2, 3, 4], [0, 1, 5]),  # a step back that lasts: until the stamps are later than all before
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
    first_reached = np.searchsorted(np.maximum.accumulate(time), time[kept])
    assert np.array_equal(np.flatnonzero(kept), np.unique(first_reached))


RAMP = [0, 1, 2]
REMEDY = 'add stamps = { model = "KeepIncreasing" } to the drive'
BAD_SAMPLES = [
    ([], [], 'holds no samples: name the record, for instance file = "record.csv"'),
    ([0.0], [1.0], "at least 2 samples, not 1"),
    (RAMP, [0, 1], "3 time stamps but 2 voltages"),
    (RAMP, [0, np.nan, 2], "the voltage of sample 1 is not a finite number"),
    ([0, np.nan, np.nan], [0, 1, np.nan], "the time of sample 1 is not a finite number"),
    ([0, 1e-3, 1e-3, 2e-3], VOLTAGE, "1 of 4 time stamps do not: sample 2 (0.001 s) repeats after 0.001 s"),
    ([0, 2e-3, 1e-3, 1e-3], VOLTAGE, "2 of 4 time stamps do not: sample 2 (0.001 s) goes back after 0.002 s"),
    ([0, 1e-3, 1e-3, 2e-3], VOLTAGE, REMEDY),
    ([0, 1e-3, 2e-3], [0, 1e200, 0], "sample 1 is 1e+200 V, but a drive lies between -100 kV and 100 kV"),
    ([0, 1e-3, 2e-3], [0, 0, -100_001], "the voltage of sample 2 is -100001 V"),
    ([0, 1e-310, 2e-310], RAMP, "lasts 2e-310 s, but a drive lasts between 1 ns and 1 Ms"),
    ([0, 1, 1.1e6], RAMP, "the record lasts 1.1e+06 s"),
    ([0, 9e-25, 1e-3], RAMP, "samples 0 and 1 of those kept are less than 1e-24 s apart"),
]


@pytest.mark.parametrize(("time", "voltage", "words"), BAD_SAMPLES)
def test_bad_samples(time, voltage, words):
    assert words in refusal(time_samples=time, voltage_samples=voltage)


def test_nothing_left_to_drive_with():
    said = refusal(time_samples=[1, 1, 0], voltage_samples=RAMP, **KEEP)
    assert "fewer than 2 samples are left" in said


@pytest.mark.parametrize(
    ("time", "voltage"),
    [([0, 1e-9], [1e5, -1e5]), ([0, 1e6], [0, 1]), ([0, 1e-24, 1], [0, 1, 0]), ([1.7e9, 1.7e9 + 1], [0, 1])],
)
def test_records_at_the_ends_of_the_range(time, voltage):
    assert sampled(time=time, voltage=voltage).duration == pytest.approx(time[-1] - time[0])


@pytest.mark.parametrize(
    ("text", "changes", "words"),
    [
        ("time,voltage\n0,0\n1,off\n2,0\n", {}, "line 3, column 'voltage': 'off' is not a number"),
        ("time,volts\n0,0\n1,1\n", {}, "no column 'voltage'. Did you mean 'volts'?"),
        ("time,voltage\n0,0\n", {}, "only one row"),
        ("time,voltage\n0,0\n0,1\n", {}, "repeats"),
        (
            "time,voltage\n0,0\n1,1\n",
            {"time_unit": "V"},
            "time_unit = 'V': the column holds a time: expected a",
        ),
        ("time,voltage\n0,0\n1,1\n", {"voltage_unit": "s"}, "voltage_unit = 's': the column holds a voltage"),
        ("time,voltage\n0,0\n1,1\n", {"time_unit": "2 s"}, "time_unit = '2 s'"),
        ("time,voltage\n0,0\n1,1\n", {"file": "recrod.csv"}, "no such file. Did you mean 'record.csv'?"),
    ],
)
def test_a_bad_file_is_told_in_one_line(here, text, changes, words):
    """Of all faults that a file may have some that pass this door; tests/unit/data has them all."""
    (here / "record.csv").write_text(text, encoding="utf-8")
    assert words in refusal(**{"file": "record.csv"} | changes)


def test_a_column_is_a_name_or_a_number_and_its_numbers_then_travel_without_the_file(here):
    for name, columns in (
        ("a.csv", {}),
        ("a.npy", {"time_column": 2, "time_unit": "us", "voltage_column": 0}),
    ):
        rows = [f"{t!r},{v!r}" for t, v in zip((TIME * 1e6).tolist(), (VOLTAGE / 1e3).tolist(), strict=True)]
        (here / "a.csv").write_text("\n".join(["time [us],voltage [kV]", *rows]), encoding="utf-8")
        np.save(here / "a.npy", np.column_stack([VOLTAGE, np.zeros(4), TIME * 1e6]))
        drive = read(file=name, **columns)
        # A unit other than that of SI costs one rounding.
        assert drive.time_samples.values == pytest.approx(TIME, rel=1e-15, abs=0)
        assert drive.voltage_samples.values == pytest.approx(VOLTAGE, rel=1e-15, abs=0)
        (here / name).unlink()
        packed = json.dumps(drive.to_dict(), default=lambda samples: samples.packed())
        assert read_part(Drive, json.loads(packed)) == drive
    with pytest.raises(InputError, match="time_column"):
        read(file="record.csv", time_column=1.5)


MANY = np.arange(400) * 1e-3
ON = (MANY >= 0.1) & (MANY < 0.3)
HIGH = ON & (np.floor(MANY / 0.01 + 1e-6) % 2 == 0)
OFFSET = 2.0
"""Of the read-back [V]."""
ONE = np.where(HIGH, 300.0, 0.0) + OFFSET
LAST = MANY[np.flatnonzero(HIGH)[-1]]


def of_one(voltage=ONE, time=MANY, **readback):
    return sampled(time, voltage, readback={"model": "OneOfTwoInAntiphase"} | readback)


def test_plus_and_minus_the_supply_by_turns_without_pauses():
    driven = of_one().voltage(MANY)
    on = (MANY >= 0.1) & (MANY <= LAST)
    # the offset of the read-back drops out: both polarities are equally large
    np.testing.assert_array_equal(driven, np.where(on, np.where(HIGH, 300.0, -300.0), 0))
    np.testing.assert_array_equal(of_one(-ONE).voltage(MANY), -driven)
    np.testing.assert_array_equal(sampled(MANY, ONE).voltage(MANY), ONE)  # without it, the whole voltage
    assert np.mean((ONE - OFFSET)[ON] ** 2) == np.mean(driven[ON][:-10] ** 2) / 2
    edge = np.flatnonzero(HIGH)[10] - 1
    between = ONE.copy()
    between[edge] = 150 + OFFSET
    assert of_one(between).voltage(MANY)[edge] == 0
    for pulse in (np.where(ON, 300.0, 0.0), np.full(400, 300.0)):  # one pulse, and one that never ends
        np.testing.assert_array_equal(of_one(pulse).voltage(MANY), pulse)
    late = of_one(time=MANY + 7)
    np.testing.assert_array_equal(late.voltage(late.time_stamps), driven)
    given = of_one(time=MANY + 7, start="99.5 ms", stop=float(LAST) + 1e-6)
    np.testing.assert_array_equal(given.voltage(given.time_stamps), driven)


def test_supply_start_and_stop_are_taken_as_given():
    driven = of_one(supply="300 V", start="90 ms", stop="299.5 ms").voltage(MANY)
    # a supply that is given keeps the offset of the read-back, twice
    assert driven[89:92] == pytest.approx([0, -296, -296])
    assert driven[100] == pytest.approx(304)
    assert driven[298:301] == pytest.approx([-296, -296, 0])
    assert OneOfTwoInAntiphase().driving(MANY, ONE).min() == -300


@pytest.mark.parametrize(
    ("voltage", "readback", "words"),
    [
        (
            np.where(HIGH, 150.0, -150.0),
            {},
            "extends from -150 to 150 V, but the voltage of one of two electr",
        ),
        (0 * ONE, {}, "the record is 0 V throughout"),
        (ONE, {"start": "500 ms", "stop": "600 ms"}, "the drive is on at no sample"),
        (ONE, {"start": "200 ms", "stop": "100 ms"}, "start = 0.2 s has to lie before stop = 0.1 s"),
        (ONE, {"supply": 0}, "a supply of 0 V drives nothing"),
    ],
)
def test_what_cannot_be_one_of_two_electrodes_is_refused(voltage, readback, words):
    readback = {"model": "OneOfTwoInAntiphase"} | readback
    assert words in refusal(time_samples=MANY, voltage_samples=voltage, readback=readback)


@pytest.mark.parametrize("typed", ["time_samples", "voltage_samples"])
def test_a_file_beside_half_of_the_samples_is_refused(here, typed):
    """The column of the file took the place of the typed voltages without a word."""
    (here / "half.csv").write_text("time [s],voltage [V]\n0,0\n1,5\n2,3\n")
    with pytest.raises(InputError, match="time stamps but"):
        load("bau_2010/sine").replace({"drive": {"model": "Sampled", "file": "half.csv", typed: [0, 1, 2]}})
