"""Output times: evenly spaced, or the time stamps of a measured drive."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.scenario.grids import FORMULA_SAMPLES, TimeGrid
from electrovib.solve.diagnostics.assumptions import sampling

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


def assert_resolved(grid, stamps, end):
    """All stamps up to the end are among the times, and none of these are farther apart than 2001 even ones."""
    assert set(stamps[stamps <= end]) <= set(grid)
    steps = np.diff(grid)
    assert (grid[0], grid[-1]) == (0.0, end)
    assert 0 < steps.min() <= steps.max() <= end / (FORMULA_SAMPLES - 1) * (1 + 1e-9)


@pytest.mark.parametrize("name", WRAPPED)
def test_a_measured_drive_keeps_its_stamps_inside_other_drives(name):
    wrapped = drive(WRAPPED[name])
    np.testing.assert_array_equal(wrapped.time_stamps, STAMPS)
    assert_resolved(TimeGrid().times(wrapped), STAMPS, wrapped.duration)


def test_two_records_give_the_stamps_of_both():
    other = {
        "model": "Sampled",
        "time_samples": [0, 2e-3, 3e-3 * (1 + 1e-16), 4e-3],
        "voltage_samples": [0] * 4,
    }
    both = drive({"model": "Sum", "drives": [RECORD, other]})
    assert_resolved(TimeGrid().times(both), np.array([0, 1, 2, 3, 4, 7, 10]) * 1e-3, 10e-3)


def test_stamps_that_only_rounding_tells_apart_are_one():
    late = STAMPS * (1 + 4e-16)
    both = drive({"model": "Sum", "drives": [RECORD, RECORD | {"time_samples": late}]})
    assert len(both.time_stamps) > len(STAMPS)
    np.testing.assert_array_equal(TimeGrid().times(both), TimeGrid().times(drive(RECORD)))


def test_formulas_have_no_stamps():
    both = drive({"model": "Sum", "drives": [SINE, SINE]})
    assert both.time_stamps is None
    assert drive({"model": "Offset", "drive": SINE, "level": 1}).time_stamps is None
    np.testing.assert_array_equal(TimeGrid().times(both), np.linspace(0, both.duration, FORMULA_SAMPLES))


@pytest.mark.parametrize("end", [3e-3, 5e-3, 30e-3])
def test_another_duration_keeps_the_stamps_up_to_it(end):
    assert_resolved(TimeGrid(duration=end).times(drive(RECORD)), STAMPS, end)


def test_after_a_record_that_is_longer_than_the_rest_times_go_on_as_closely():
    longer = drive(
        {
            "model": "Sum",
            "drives": [RECORD, {"model": "Chirp", "amplitude": 1, "first": 1, "last": 9, "length": 0.1}],
        }
    )
    assert TimeGrid().times(longer)[-1] == pytest.approx(0.1)


def test_a_short_pulse_in_a_long_record_is_resolved_within_itself():
    stamps = np.array([0.0, 1e-6, 2e-6, 3e-6, 1.0])
    grid = TimeGrid().times(drive(RECORD | {"time_samples": stamps}))
    assert_resolved(grid, stamps, 1.0)
    assert np.count_nonzero((grid > 0) & (grid < 1e-6)) == (FORMULA_SAMPLES - 1) // 4 - 1


def test_many_stamps_are_the_times_themselves_and_gaps_between_them_are_filled():
    stamps = np.linspace(0, 1, 5000)
    record = {"model": "Sampled", "time_samples": stamps, "voltage_samples": np.sin(stamps)}
    np.testing.assert_array_equal(TimeGrid().times(drive(record)), stamps)
    kept = stamps[(stamps < 0.2) | (stamps > 0.7)]
    grid = TimeGrid().times(drive(record | {"time_samples": kept, "voltage_samples": np.sin(kept)}))
    assert_resolved(grid, kept, 1.0)
    assert len(grid) == len(kept) + 1000


@pytest.mark.parametrize(
    ("content", "end", "count"),
    [
        (SINE | {"frequency": 1e3}, 1.0, 8001),
        (SINE | {"frequency": 2.5e3}, 1.0, 20_001),
        (
            SINE | {"frequency": 2.6e3},
            1.0,
            FORMULA_SAMPLES,
        ),  # more than are taken unasked; a diagnostic says so
        ({"model": "PulseTrain", "high": 1, "width": 1e-4, "frequency": 10}, 0.5, 8001),
    ],
)
def test_a_formula_gets_as_many_times_as_show_it(content, end, count):
    grid = TimeGrid(duration=end)
    assert len(grid.times(drive(content))) == grid.count(drive(content)) == count
    assert bool(sampling(drive(content), grid.times(drive(content)))) == (count == FORMULA_SAMPLES)


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
