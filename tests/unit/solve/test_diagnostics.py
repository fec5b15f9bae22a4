"""Largest values between times, of one record and of a batch; when the times of a result are too far apart to show it."""

import json

import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.extremes import FEWEST
from electrovib.scenario import load
from electrovib.solve.diagnostics.assumptions import sampling
from electrovib.solve.diagnostics.peaks import REFINEMENTS, PeakRecord, crests, refined, resolved
from electrovib.solve.simulate import simulate

EVEN = np.arange(5.0)


def test_a_crest_between_uneven_times_is_that_of_the_parabola():
    times = np.array([0.0, 0.1, 0.19, 0.33, 0.5, 1.0])
    record = PeakRecord(times, {"one": 1 - (times - 0.3) ** 2, "other": -3 + (times - 0.21) ** 2})
    assert record.peaks() == pytest.approx({"one": 1.0, "other": 3.0}, rel=1e-12)


def test_a_crest_beside_two_close_times_is_resolved():
    """Of a rise and a fall: the parabola through a long and a short interval used to be cut, 0.3 % below the crest."""

    def rows(moments):
        return {"one": np.exp(-moments) - np.exp(-10 * moments)}

    times = np.array([0.0, 0.17, 0.229, 0.2848, 0.2864, 0.35, 1.0])
    crest = np.log(10) / 9
    record = resolved(PeakRecord(times, rows(times)), lambda moments: PeakRecord(moments, rows(moments)))
    assert record.peaks()["one"] == pytest.approx(float(rows(crest)["one"]), rel=1e-5)


@pytest.mark.parametrize("count", [1, 7])
def test_records_of_a_batch_are_refined_together_each_at_its_own_times(count):
    frequencies, times, asked = np.linspace(1.0, 2.0, count), np.linspace(0.0, 1.3, 14), []

    def rows(frequency, moments):
        turns = 2 * np.pi * frequency * moments
        return {"sine": np.sin(turns - 0.4), "larger": 5 * np.sin(turns - 1.1)}

    def look(cases, moments):
        asked.append(cases)
        return rows(frequencies[cases, None], moments)

    coarse = [PeakRecord(times, rows(each, times)) for each in frequencies]
    found = refined(coarse, look)
    assert 0 < len(asked) <= REFINEMENTS
    for record, start, frequency in zip(found, coarse, frequencies, strict=True):
        assert record.peaks() == pytest.approx({"sine": 1.0, "larger": 5.0}, rel=1e-4)
        assert np.all(np.diff(record.times) > 0)
        (alone,) = refined([start], lambda _, at, f=frequency: rows(f, at))
        assert record.peaks() == alone.peaks()


def test_records_of_different_lengths_have_the_crests_of_each_alone():
    rng, records = np.random.default_rng(2), []
    for count in (5, 40, 17, 3):
        rows = {"one": rng.normal(size=count), "other": np.linspace(-2, 1, count)}
        records.append(PeakRecord(np.sort(rng.random(count)), rows))
    for own, record in zip(crests(records), records, strict=True):
        (alone,) = crests([record])
        for mine, its in zip(own, alone, strict=True):
            np.testing.assert_array_equal(mine, its)
        assert own.places[1] == 0
        assert own.drops[1] == 0.0


def test_new_times_lie_between_the_neighbours_of_a_largest_value():
    times = np.array([0.0, 1.0, 2.0, 2.0 + 1e-16, 3.0, 4.0])
    wanted = PeakRecord(times, {"row": np.array([0.0, 0.1, 1.0, 1.0, 0.2, 0.0])}).unclear()
    assert wanted[0] > 1.0
    assert wanted[-1] < 3.0
    assert len(wanted) == 10  # 13 with both neighbours and the largest value itself


@pytest.mark.parametrize(
    ("times", "row", "peak"),
    [
        # both sides of a discontinuity are the largest that there is
        (np.append(0.5 + 1e-9 * np.arange(-1.0, 4.0), 1.0), [0.0, 0.6, 1.0, 0.7, 0.1, 0.0], 1.0),
        # a corner that is steep on one side only: the parabola through the three lies above it
        (EVEN, [0.98, 0.99, 1.0, 0.5, 0.0], 1.0),
        # a value beside unknown ones stands, and an unknown row stays unknown
        (EVEN, [0.1, 1.0, np.nan, 0.5, 0.5], 1.0),
        (EVEN, [0.0, 2.0, np.inf, 1.0, 1.0], 2.0),
        (EVEN, [np.nan] * 5, np.nan),
    ],
)
def test_where_there_is_no_crest_the_largest_value_stands(times, row, peak):
    np.testing.assert_equal(PeakRecord(times, {"row": np.array(row)}).peaks()["row"], peak)


SINE = {"model": "Sine", "amplitude": 1, "frequency": 100}
PULSE = {"model": "Trapezium", "high": 1, "rise": 0.01, "hold": 0.02, "fall": 0.01}
CHIRP = {"model": "Chirp", "amplitude": 1, "first": 10, "last": 1e3, "length": 0.2}
DRIVES = {
    "sine": (SINE, 100),
    "offset": ({"model": "Offset", "level": 1, "drive": SINE | {"frequency": 40}}, 40),
    "chirp": (CHIRP, 1e3),
    "square": ({"model": "Square", "high": 1, "frequency": 50}, 50),
    "pulse": (PULSE, 25),
}


def sampled(time, values):
    return {"model": "Sampled", "time_samples": time, "voltage_samples": values}


@pytest.mark.parametrize("name", DRIVES)
def test_eight_samples_a_cycle_are_enough_and_fewer_are_not(name):
    content, fastest = DRIVES[name]
    drive = read_model(Drive, content)
    span = 4 / fastest
    assert sampling(drive, np.linspace(0, span, 4 * FEWEST + 1)) == []
    (diagnostic,) = sampling(drive, np.linspace(0, span, 4 * FEWEST - 1))
    assert (diagnostic.name, diagnostic.state) == ("sampling", "warning")
    assert f"time.samples = {4 * FEWEST + 1} " in diagnostic.text


def test_a_sine_met_at_its_zeros_is_shown_by_default_and_not_in_silence_otherwise():
    """One second of 1 kHz at 2001 times: every one of them is a zero of the drive."""
    fine = load("vezzoli_2014/fig7").replace({"time.duration": 1.0})
    few = {"time.samples": 2001}, pytest.approx(0, abs=1e-7), "time.samples = 8001 would show it"
    for changes, largest, said in (({}, pytest.approx(100), ""), few):
        trace = simulate(fine.replace(changes))
        assert np.max(np.abs(trace.drive_voltage)) == largest
        told = {each["name"]: each["text"] for each in json.loads(trace.attrs["validity"])}
        assert said in told["sampling"] if said else "sampling" not in told


TRAIN = {"model": "PulseTrain", "high": 1, "width": 1e-5, "frequency": 60}
BESIDE = [CHIRP | {"last": 3e3, "length": 0.3}, TRAIN | {"width": 2e-4, "frequency": 50}]
NARROW = {
    "pulses that no time meets": TRAIN,
    "a pulse between two times": PULSE | {"delay": 0.0503, "rise": 1e-6, "hold": 8e-6, "fall": 1e-6},
    "pulses beside a chirp": {"model": "Sum", "drives": BESIDE},
}


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize("count", [50, 2001])
def test_the_advice_holds_when_it_is_followed(name, count):
    drive = read_model(Drive, NARROW[name])
    (diagnostic,) = sampling(drive, np.linspace(0, 0.3, count))
    assert diagnostic.value > diagnostic.limit == count
    assert f"time.samples = {diagnostic.value:.0f} would show it" in diagnostic.text
    assert sampling(drive, np.linspace(0, 0.3, int(diagnostic.value))) == []


def test_a_measured_drive_on_other_times_is_told_to_keep_its_own():
    time = np.linspace(0, 1, 40_001)
    record = sampled(time, np.sin(2 * np.pi * 1e3 * time))
    drive = read_model(Drive, {"model": "Offset", "level": 5, "drive": record})
    (diagnostic,) = sampling(drive, np.linspace(0, 1, 2001))
    assert "omit time.samples" in diagnostic.text
    assert sampling(drive, drive.time_stamps) == []
    assert sampling(drive, np.linspace(0, 1, 16_001)) == []


def test_where_no_even_times_would_do_numbers_are_advised():
    drive = read_model(Drive, TRAIN | {"width": 1e-8, "frequency": 1})
    (diagnostic,) = sampling(drive, np.linspace(0, 5, 2001))
    assert "request numbers with --quantity" in diagnostic.text


SQUARE = {"model": "Square", "high": 1, "low": -1, "frequency": 1}


@pytest.mark.parametrize(
    ("drive", "time"),
    [
        ({"model": "Step", "level": 5}, np.array([0.0, 1e3])),
        (SINE, np.array([3.0])),
        (sampled(np.arange(9.0), np.arange(9.0) % 2), np.arange(9.0)),  # measured, at its own stamps
        *[(SQUARE, np.linspace(0, 1, samples)) for samples in (9, 17, 2001)],  # edges between two times
    ],
)
def test_nothing_is_said_where_nothing_is_missed(drive, time):
    assert sampling(read_model(Drive, drive), time) == []
