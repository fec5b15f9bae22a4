"""Output times: evenly spaced, or the time stamps of a measured drive."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.scenario.grids import FORMULA_SAMPLES, TimeGrid
from electrovib.solve.diagnostics.assumptions import sampling

STAMPS = np.array([0.0, 1e-3, 3e-3, 7e-3, 10e-3])
SINE = {"model": "Sine", "amplitude": 1, "frequency": 100}


def record(at=STAMPS, voltage=None, **more):
    voltage = np.sin(np.arange(len(at))) if voltage is None else voltage
    return {"model": "Sampled", "time_samples": at, "voltage_samples": voltage} | more


def offset(inner):
    return {"model": "Offset", "drive": inner, "level": 5}


def together(*drives):
    return {"model": "Sum", "drives": list(drives)}


def times(content, **grid):
    return TimeGrid(**grid).times(read_model(Drive, content))


def assert_resolved(grid, stamps, end):
    """All stamps up to the end are among the times, and none of these are farther apart than 2001 even ones."""
    assert set(stamps[stamps <= end]) <= set(grid)
    steps = np.diff(grid)
    assert (grid[0], grid[-1]) == (0.0, end)
    assert 0 < steps.min() <= steps.max() <= end / (FORMULA_SAMPLES - 1) * (1 + 1e-9)


@pytest.mark.parametrize(
    "content",
    [
        record(),
        together({"model": "Step", "level": 1}, record()),
        together(offset(record())),
        {"model": "CurrentAmplifier", "sense_resistance": 1e3, "command": offset(record())},
    ],
)
def test_a_measured_drive_keeps_its_stamps_inside_other_drives(content):
    wrapped = read_model(Drive, content)
    np.testing.assert_array_equal(wrapped.time_stamps, STAMPS)
    assert_resolved(times(content), STAMPS, wrapped.duration)
    for end in (3e-3, 5e-3, 30e-3):
        assert_resolved(times(content, duration=end), STAMPS, end)


def test_two_records_give_the_stamps_of_both_but_for_rounding():
    other = [0, 2e-3, 3e-3 * (1 + 1e-16), 4e-3]
    assert_resolved(times(together(record(), record(other))), np.array([0, 1, 2, 3, 4, 7, 10]) * 1e-3, 10e-3)
    both = together(record(), record(STAMPS * (1 + 4e-16)))
    assert len(read_model(Drive, both).time_stamps) > len(STAMPS)
    np.testing.assert_array_equal(times(both), times(record()))


def test_formulas_have_no_stamps_and_times_go_on_after_a_record():
    both = together(SINE, offset(SINE))
    assert read_model(Drive, both).time_stamps is None
    np.testing.assert_array_equal(times(both), np.linspace(0, 0.05, FORMULA_SAMPLES))
    chirp = {"model": "Chirp", "amplitude": 1, "first": 1, "last": 9, "length": 0.1}
    assert times(together(record(), chirp))[-1] == pytest.approx(0.1)
    for more in ({}, {"duration": 2e-3}):  # samples say otherwise
        expected = np.linspace(0, more.get("duration", 10e-3), 7)
        np.testing.assert_array_equal(times(record(), samples=7, **more), expected)


def test_a_short_pulse_in_a_long_record_is_resolved_within_itself():
    stamps = np.array([0.0, 1e-6, 2e-6, 3e-6, 1.0])
    grid = times(record(stamps))
    assert_resolved(grid, stamps, 1.0)
    assert np.count_nonzero((grid > 0) & (grid < 1e-6)) == (FORMULA_SAMPLES - 1) // 4 - 1


def test_many_stamps_are_the_times_themselves_and_gaps_between_them_are_filled():
    stamps = np.linspace(0, 1, 5000)
    np.testing.assert_array_equal(times(record(stamps)), stamps)
    kept = stamps[(stamps < 0.2) | (stamps > 0.7)]
    grid = times(record(kept))
    assert_resolved(grid, kept, 1.0)
    assert len(grid) == len(kept) + 1000


@pytest.mark.parametrize(
    ("content", "end", "count"),
    [
        (SINE | {"frequency": 1e3}, 1.0, 8001),
        (SINE | {"frequency": 2.5e3}, 1.0, 20_001),
        # more than are taken unasked; a diagnostic says so
        (SINE | {"frequency": 2.6e3}, 1.0, FORMULA_SAMPLES),
        ({"model": "PulseTrain", "high": 1, "width": 1e-4, "frequency": 10}, 0.5, 8001),
    ],
)
def test_a_formula_gets_as_many_times_as_show_it(content, end, count):
    grid, drive = TimeGrid(duration=end), read_model(Drive, content)
    assert len(grid.times(drive)) == grid.count(drive) == count
    assert bool(sampling(drive, grid.times(drive))) == (count == FORMULA_SAMPLES)


def test_a_measured_kilohertz_keeps_its_mean_pull_when_a_duration_is_given():
    """89 598 time stamps of a drive of 1 kHz: 2001 even times would alias it and change the mean."""
    stamps, mean = np.linspace(0.0, 1.0, 89_598), "mean electrostatic_force"
    sine = {
        "drive": SINE | {"amplitude": 100, "frequency": 1e3},
        "time.initial_state": {"model": "PeriodicState"},
    }
    scenario = ev.load("vezzoli_2014/fig2", changes=sine)
    exact = float(ev.sweep(scenario, {}, quantity=[mean])[mean])
    voltage = 100 * np.sin(2 * np.pi * 1e3 * stamps)
    measured = scenario.replace({"drive": record(stamps, voltage), "time": {"duration": 1.0}})
    trace = ev.simulate(measured)
    assert trace.sizes["time"] == len(stamps)
    assert float(trace.electrostatic_force.mean()) == pytest.approx(exact, rel=2e-3)
    assert float(ev.sweep(measured, {}, quantity=[mean])[mean]) == pytest.approx(exact, rel=2e-3)


def test_samples_dropped_from_a_record_inside_another_drive_are_told():
    inner = record([0, 1e-3, 1e-3, 2e-3, 3e-3], stamps={"model": "KeepIncreasing"})
    found = ev.simulate(ev.load("vezzoli_2014/fig6", changes={"drive": offset(inner)}))
    assert found.attrs["dropped_samples"] == 1


@pytest.mark.parametrize(
    ("first", "last", "count"), [(1.1, 1.105, 3), (7.7, 7.75, 21), (1000.1, 1000.105, 4)]
)
def test_the_rounded_length_of_a_record_is_its_end(first, last, count):
    """1.105 - 1.1 lies below 0.005 by more than the rounding of 0.005 itself."""
    stamps = np.linspace(first, last, count)
    own, length = read_model(Drive, record(stamps)), round(last - first, 6)
    assert own.duration != length
    np.testing.assert_array_equal(times(record(stamps), duration=length), times(record(stamps)))
    longer = times(record(stamps), duration=length * (1 + 1e-8))
    assert longer[-1] == length * (1 + 1e-8) > own.duration


def test_no_time_is_divided_below_its_rounding():
    """Stamps of two clocks that differ by the rounding of one of them, in a record of few."""
    at = np.array([1.1, 1.1025, 1.105])
    both = together(record(at), record(at - 1.1 + 1e-17 * np.arange(3)), record([0.0, 0.005]))
    grid = times(both)
    assert np.min(np.diff(read_model(Drive, both).time_stamps)) < 1e-15
    assert np.all(np.diff(grid) > 0)
    assert np.max(np.diff(grid)) <= grid[-1] / (FORMULA_SAMPLES - 1) * (1 + 1e-9)


MEMORIES = {
    "lag": {
        "friction": {
            "model": "FirstOrderLag",
            "cut_off": 100.0,
            "steady": {"model": "Coulomb", "coefficient": 0.5},
        }
    },
    "creep": {
        "friction": {
            "model": "Creep",
            "relaxations": [{"share": 0.2, "time": 1e-3}],
            "steady": {"model": "Coulomb", "coefficient": 0.5},
        }
    },
    "fingertip": {
        "finger": {"model": "MassSpringDamper", "mass": 1e-4, "stiffness": 1e3, "damping": 1.0},
        "motion.speed": 0.04,
    },
}


@pytest.mark.parametrize("memory", MEMORIES.values(), ids=MEMORIES.keys())
def test_a_record_is_run_over_its_own_length_behind_a_memory(memory):
    """Its voltage begins with a step, and its clock at 1.1 s."""
    at = np.linspace(1.1, 1.105, 6)
    drive = record(at, 100 * np.cos(np.arange(6)))
    late, early = (
        ev.simulate(ev.load("vezzoli_2014/fig6", changes={"drive": each, "time.duration": 0.005} | memory))
        for each in (drive, drive | {"time_samples": at - 1.1})
    )
    np.testing.assert_allclose(late.lateral_force, early.lateral_force, rtol=1e-9)
