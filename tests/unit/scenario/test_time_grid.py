"""Output times: evenly spaced, or the time stamps of a measured drive."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.scenario.grids import FORMULA_SAMPLES, TimeGrid

STAMPS = np.array([0.0, 1e-3, 3e-3, 7e-3, 10e-3])
RECORD = {"model": "Sampled", "time_samples": STAMPS, "voltage_samples": [0, 1, -1, 2, 0]}
SINE = {"model": "Sine", "amplitude": 1, "frequency": 100}
WRAPPED = {
    "alone": RECORD,
    "offset": {"model": "Offset", "drive": RECORD, "level": 5},
    "sum": {"model": "Sum", "drives": [{"model": "Step", "level": 1}, RECORD]},
    "nested": {"model": "Sum", "drives": [{"model": "Offset", "drive": RECORD, "level": 5}]},
    "current": {
        "model": "CurrentAmplifier",
        "sense_resistance": 1e3,
        "command": {"model": "Offset", "drive": RECORD, "level": 1},
    },
}


def drive(content):
    return read_model(Drive, content)


@pytest.mark.parametrize("name", WRAPPED)
def test_a_measured_drive_keeps_its_stamps_inside_other_drives(name):
    wrapped = drive(WRAPPED[name])
    np.testing.assert_array_equal(wrapped.time_stamps, STAMPS)
    grid = TimeGrid().times(wrapped)
    np.testing.assert_array_equal(grid[: len(STAMPS)], STAMPS)
    assert grid[-1] == wrapped.duration


def test_two_records_give_the_stamps_of_both():
    other = {
        "model": "Sampled",
        "time_samples": [0, 2e-3, 3e-3 * (1 + 1e-16), 4e-3],
        "voltage_samples": [0] * 4,
    }
    both = drive({"model": "Sum", "drives": [RECORD, other]})
    np.testing.assert_array_equal(TimeGrid().times(both), np.array([0, 1, 2, 3, 4, 7, 10]) * 1e-3)


def test_stamps_that_only_rounding_tells_apart_are_one():
    late = STAMPS * (1 + 4e-16)
    both = drive({"model": "Sum", "drives": [RECORD, RECORD | {"time_samples": late}]})
    assert len(both.time_stamps) > len(STAMPS)
    assert len(TimeGrid().times(both)) == len(STAMPS)


def test_formulas_have_no_stamps():
    both = drive({"model": "Sum", "drives": [SINE, SINE]})
    assert both.time_stamps is None
    assert drive({"model": "Offset", "drive": SINE, "level": 1}).time_stamps is None
    np.testing.assert_array_equal(TimeGrid().times(both), np.linspace(0, both.duration, FORMULA_SAMPLES))


def test_a_shorter_duration_takes_the_stamps_up_to_it():
    np.testing.assert_array_equal(TimeGrid(duration=3e-3).times(drive(RECORD)), STAMPS[:3])
    np.testing.assert_allclose(
        TimeGrid(duration=5e-3).times(drive(RECORD)), [0, 1e-3, 3e-3, 5e-3], rtol=1e-12
    )


def test_a_longer_duration_goes_on_after_the_record():
    grid = TimeGrid(duration=30e-3).times(drive(RECORD))
    np.testing.assert_array_equal(grid[:5], STAMPS)
    np.testing.assert_allclose(grid[4:], np.linspace(10e-3, 30e-3, FORMULA_SAMPLES), rtol=1e-12)
    longer = drive(
        {
            "model": "Sum",
            "drives": [RECORD, {"model": "Chirp", "amplitude": 1, "first": 1, "last": 9, "length": 0.1}],
        }
    )
    assert TimeGrid().times(longer)[-1] == pytest.approx(0.1)


def test_samples_say_otherwise():
    np.testing.assert_array_equal(TimeGrid(samples=7).times(drive(RECORD)), np.linspace(0, 10e-3, 7))
    np.testing.assert_array_equal(
        TimeGrid(samples=7, duration=2e-3).times(drive(RECORD)), np.linspace(0, 2e-3, 7)
    )


def test_a_measured_kilohertz_keeps_its_mean_pull_when_a_duration_is_given():
    """89 598 time stamps of a drive of 1 kHz: 2001 even times would alias it and change the mean."""
    time = np.linspace(0.0, 1.0, 89_598)
    record = {
        "model": "Sampled",
        "time_samples": time,
        "voltage_samples": 100 * np.sin(2 * np.pi * 1e3 * time),
    }
    sine = {"model": "Sine", "amplitude": 100, "frequency": 1e3}
    scenario = ev.load("vezzoli_2014/fig2").replace(
        {"drive": sine, "time.initial_state": {"model": "PeriodicState"}}
    )
    exact = float(ev.sweep(scenario, {}, quantities=["mean electrostatic_force"])["mean electrostatic_force"])
    measured = scenario.replace({"drive": record, "time": {"duration": 1.0}})
    trace = ev.simulate(measured)
    assert trace.sizes["time"] == len(time)
    assert float(trace.electrostatic_force.mean()) == pytest.approx(exact, rel=2e-3)
    told = ev.sweep(measured, {}, quantities=["mean electrostatic_force"])["mean electrostatic_force"]
    assert float(told) == pytest.approx(exact, rel=2e-3)


def test_samples_dropped_from_a_record_inside_another_drive_are_told():
    record = RECORD | {"time_samples": [0, 1e-3, 1e-3, 2e-3, 3e-3], "stamps": {"model": "KeepIncreasing"}}
    scenario = ev.load("vezzoli_2014/fig6").replace(
        {"drive": {"model": "Offset", "drive": record, "level": 5}}
    )
    assert ev.simulate(scenario).attrs["dropped_samples"] == 1
