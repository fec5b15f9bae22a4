"""When the times of a result are too far apart to show it."""

import json

import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.shown import FEWEST
from electrovib.scenario import load
from electrovib.solve.diagnostics.assumptions import sampling
from electrovib.solve.simulate import simulate

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
    for scenario, largest, said in (
        (fine, pytest.approx(100), ""),
        (
            fine.replace({"time.samples": 2001}),
            pytest.approx(0, abs=1e-7),
            "time.samples = 8001 would show it",
        ),
    ):
        trace = simulate(scenario)
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
