"""Drives of many fingers as straight pieces and sines: rises, periods, means, and what is settled."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.pieces import SLACK
from electrovib.solve.population import population
from electrovib.solve.population.arrays import _agree
from electrovib.solve.population.response import excitation, respond, settled_state
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integrated

_SPEC = importlib.util.spec_from_file_location("fingers_of", Path(__file__).with_name("fingers_of.py"))
fingers_of = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(fingers_of)
difference, times_of = fingers_of.difference, fingers_of.times_of

EQUAL = 1e-12
GAP = "vezzoli_2014/fig6_gap"
CURRENT = "kim_2015/current"
PERIODIC = {"time.initial_state": {"model": "PeriodicState"}}
SQUARE = {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}
PULSES = {"model": "PulseTrain", "high": 40.0, "width": 2e-3, "frequency": 120.0, "edge": 1e-3}


def drive_of(**given):
    return read_model(Drive, given)


def test_a_rise_keeps_its_digits_beside_a_large_voltage():
    """A slope of 1e-3 V/s at 1 kV rises by 1e-9 V in a step: the difference of the voltages would have four digits."""
    drive = drive_of(model="Trapezium", low=1000.0, high=1000.001, rise=1.0, hold=1.0, fall=1.0)
    time = np.linspace(0.0, 0.9, 900_001)[::1000]
    found = excitation(drive, time, settled=False)
    steps = np.diff(found.moments.time)
    slope = (1000.001 - 1000.0) / 1.0
    assert np.allclose(found.rises[:-1][steps > 0], slope * steps[steps > 0], rtol=1e-12, atol=0)
    assert found.rises[-1] == 0


def test_a_current_keeps_its_digits_beside_a_large_voltage():
    """A capacitor behind a resistor passes slope/rate of a slow ramp, whatever the voltage it starts from."""
    drive = drive_of(model="Trapezium", low=1000.0, high=1000.001, rise=1.0, hold=1.0, fall=1.0)
    time, rate = np.linspace(0.0, 0.9, 901), 1e6
    current = Transfer(rates=np.array([rate]), gains=np.array([-1.0]), direct=1.0, static=0.0)
    found = respond({"current": current}, [(1.0, excitation(drive, time, settled=False))])["current"]
    assert np.allclose(found[0, 2:], (1000.001 - 1000.0) / rate, rtol=1e-11, atol=0)


def test_rises_add_up_to_the_voltage_over_jumps_too():
    time = np.linspace(0.0, 0.05, 83)
    found = excitation(drive_of(**SQUARE), time, settled=False)
    assert np.any(np.diff(found.moments.time) == 0)
    assert np.allclose(found.voltage[0] + np.cumsum(found.rises)[:-1], found.voltage[1:], rtol=0, atol=1e-10)
    drive = drive_of(**SQUARE)
    assert np.array_equal(found.values(), drive.voltage(time))


def test_a_slope_begins_at_the_corner_that_stands_for_two():
    """Of two corners that nearly agree the earlier one is kept, where the slope of the other has not begun."""
    ramp = {"model": "Trapezium", "high": 100.0, "rise": 0.01, "hold": 0.01, "fall": 0.01}
    delays = (1e-3, 1e-3 * (1 + 1.5 * SLACK))
    drives = [drive_of(**ramp, delay=delay) for delay in delays]
    drive = drive_of(model="Sum", drives=[each.model_dump() | {"model": "Trapezium"} for each in drives])
    found = excitation(drive, np.array([0.0, 0.02, 0.05]), settled=False)
    assert np.allclose(found.voltage[0] + np.cumsum(found.rises)[:-1], found.voltage[1:], rtol=0, atol=1e-9)


def test_a_capacitor_alone_takes_a_current_in_proportion_to_the_slope():
    drive = drive_of(model="Trapezium", high=100.0, rise=0.01, hold=0.01, fall=0.02)
    time = np.array([0.0, 0.005, 0.01, 0.015, 0.025, 0.035, 0.05])
    capacitor = Transfer(rates=np.zeros(0), gains=np.zeros(0), slope=np.array([[2e-9], [3e-9]]), static=0.0)
    found = respond({"current": capacitor}, [(1.0, excitation(drive, time, settled=False))])["current"]
    slopes = np.array([1e4, 1e4, 0.0, 0.0, -5e3, -5e3, 0.0])
    assert np.allclose(found, np.array([[2e-9], [3e-9]]) * slopes, rtol=1e-12, atol=0)


def test_corners_that_two_drives_share_up_to_rounding_are_one():
    """Every third corner of one is a corner of the other; as two corners they would be two jumps of both."""
    drives = [SQUARE, SQUARE | {"frequency": 180.0}]
    member = ev.load(GAP).replace({"drive": {"model": "Sum", "drives": drives}})
    time = np.linspace(0.0, 0.2, 331)
    moments = excitation(member.drive, time, settled=False).moments
    gaps = np.diff(moments.time)
    assert not np.any((gaps > 0) & (gaps < 1e-12))
    found, method = difference(member, ["stack.gap.thickness"], ["current", "field"], time=time)
    assert method.startswith("together"), method
    assert found < 1e-10


@pytest.mark.parametrize(("delay", "cycles"), [(0.0, 2), (1e-3, 9)])
def test_a_sine_that_is_switched_within_the_outputs_is_no_sum_of_steady_sines(delay, cycles):
    burst = drive_of(model="Burst", amplitude=3.0, frequency=200.0, cycles=cycles, delay=delay)
    with pytest.raises(NotInArraysError, match="switched within"):
        excitation(burst, np.linspace(0.0, 0.02, 41), settled=False)


def test_a_burst_that_outlasts_the_outputs_is_a_sine():
    burst = drive_of(model="Burst", amplitude=3.0, frequency=200.0, cycles=5)
    time = np.linspace(0.0, 0.02, 41)
    assert np.allclose(
        excitation(burst, time, settled=False).values(), burst.voltage(time), rtol=0, atol=1e-13
    )


@pytest.mark.parametrize("offset", [0.0, 7.0])
def test_a_settled_drive_has_its_mean_and_otherwise_its_integral(offset):
    high, low = 30.0 + offset, -30.0 + offset
    drive = drive_of(model="Square", high=high, low=low, frequency=50.0)
    time = np.linspace(0.0, 0.04, 81)
    found = excitation(drive, time, settled=True)
    assert found.mean == pytest.approx(offset, rel=1e-14)
    if not offset:  # a triangle of height 30 V times half a period
        assert np.max(found.integral) == pytest.approx(30.0 * 0.01 / 2, rel=1e-12)
        assert np.max(np.abs(np.diff(found.integral))) == pytest.approx(30.0 * 5e-4, rel=1e-9)
    else:
        assert not np.any(found.integral)
    ((lengths, begins, ends),) = found.periods()
    assert lengths.sum() == pytest.approx(0.02, rel=1e-14)
    assert begins @ lengths == pytest.approx(offset * 0.02, abs=1e-12)
    assert np.array_equal(begins, ends)


def test_the_settled_state_is_that_after_many_periods():
    """From rest, each period of a ramp and a rest adds what the decay over the period has left."""
    rates, lengths = np.array([[0.3, 40.0, 900.0]]), np.array([0.01, 0.03])
    begins, ends = np.array([0.0, 5.0]), np.array([5.0, 2.0])
    state, steps = np.zeros(3), 2000
    for _ in range(40):  # of 0.04 s: the slowest mode has decayed to 0.62, and its rest is added below
        for length, begin, end in zip(lengths, begins, ends, strict=True):
            h = length / steps
            middles = begin + (end - begin) * (np.arange(steps) + 0.5) / steps
            weights = np.exp(-np.outer(length - (np.arange(steps) + 0.5) * h, rates[0])) * h
            state = np.exp(-rates[0] * length) * state + rates[0] * (middles @ weights)
    decayed = np.exp(-rates[0] * 40 * lengths.sum())
    assert np.allclose(settled_state(rates, lengths, begins, ends)[0], state / (1 - decayed), rtol=1e-5)


@pytest.mark.parametrize(
    ("scenario", "changes", "free", "names"),
    [
        (GAP, {"drive": SQUARE} | PERIODIC, ("drive.high", "drive.low", "stack.gap.thickness"), ("current",)),
        (
            GAP,
            {"drive": {"model": "Sum", "drives": [SQUARE, PULSES]}} | PERIODIC,
            ("drive.drives.0.high", "drive.drives.1.high", "stack.gap.thickness"),
            ("current", "field", "electrostatic_force"),
        ),
        (
            GAP,
            {
                "drive": {
                    "model": "Sum",
                    "drives": [
                        SQUARE,
                        {"model": "Step", "level": 20.0},
                        {"model": "Sine", "amplitude": 5.0, "frequency": 120.0},
                    ],
                }
            }
            | PERIODIC,
            ("drive.drives.0.low", "drive.drives.1.level", "drive.drives.2.amplitude", "stack.gap.thickness"),
            ("current", "displacement", "drive_voltage"),
        ),
        (  # from rest, without resistance
            GAP,
            {
                "circuit.source_resistance": 0.0,
                "circuit.return_path": {"model": "Grounded", "resistance": 0.0},
            },
            ("stack.gap.thickness", "drive.high"),
            ("current", "field"),
        ),
        (  # whose corners come after the last output
            GAP,
            {"drive": SQUARE | {"frequency": 5.0}} | PERIODIC,
            ("drive.frequency", "stack.gap.thickness"),
            ("current", "field"),
        ),
        (
            CURRENT,
            {},
            ("drive.amplitude", "stack.gap.thickness", "stack.insulator.thickness"),
            ("electrostatic_force", "interface_field", "field", "stack_voltage"),
        ),
        (
            CURRENT,
            {"stack.insulator.initial_charge": 1e-6},
            ("stack.insulator.initial_charge", "stack.gap.thickness", "contact.area"),
            ("electrostatic_force", "field", "displacement"),
        ),
    ],
)
def test_settled_drives_agree_with_one_by_one(scenario, changes, free, names):
    member = ev.load(scenario).replace(changes)
    found, method = difference(member, free, names, time=np.linspace(0.0, 0.04, 61))
    assert method.startswith("together"), method
    assert found < (1e-10 if "current" in names else EQUAL)


def test_a_current_with_a_mean_has_no_periodic_state_in_arrays():
    """Two offsets that cancel beside the scenario, but not for every finger."""
    sines = [
        {"model": "Sine", "amplitude": amplitude, "offset": offset, "frequency": 50.0}
        for amplitude, offset in ((1.0, 0.0), (0.0, 0.5), (0.0, -0.5))
    ]
    drive = {
        "model": "CurrentAmplifier",
        "sense_resistance": 1e6,
        "command": {"model": "Sum", "drives": sines},
    }
    free = ["drive.command.drives.1.offset", "drive.command.drives.2.offset"]
    member, time = ev.load(CURRENT).replace({"drive": drive}), np.linspace(0, 0.02, 5)
    many = population(member, free, ["interface_field"], time)
    assert "mean" in many.method
    with pytest.raises(InputError, match="mean"):
        many.signals({free[0]: np.array([0.5, 0.7]), free[1]: np.array([-0.5, -0.5])})


def test_a_drive_with_a_mean_is_not_integrated_for_ever():
    """The integral of a periodic drive is periodic only without a mean."""
    time, charge = (
        np.linspace(0.0, 0.02, 41),
        integrated(Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=2.0)),
    )
    square = {"model": "Square", "frequency": 50.0}
    even = excitation(drive_of(**square, high=1.0, low=-1.0), time, settled=True)
    found = respond({"charge": charge}, [(np.array([[3.0]]), even)])["charge"]
    assert np.max(found) == pytest.approx(2 * 3 * 0.01 / 2, rel=1e-12)
    with pytest.raises(NotInArraysError, match="mean"):
        respond(
            {"charge": charge}, [(1.0, excitation(drive_of(**square, high=1.0, low=0.0), time, settled=True))]
        )


@pytest.mark.parametrize("is_settled", [False, True])
def test_a_mode_that_one_finger_does_not_excite_responds_in_the_others(is_settled):
    rates, gains = (
        np.array([[3.0, 400.0], [5.0, 600.0], [7.0, 90.0]]),
        np.array([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0]]),
    )
    direct, free = np.array([[0.1], [0.2], [0.3]]), np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
    drive = excitation(drive_of(**SQUARE), np.linspace(0.0, 0.05, 41), settled=is_settled)
    many = Transfer(rates=rates, gains=gains, direct=direct, free=free)
    found = respond({"x": many}, [(1.0, drive)])["x"]
    for finger in range(3):
        one = Transfer(
            rates=rates[finger], gains=gains[finger], direct=float(direct[finger, 0]), free=free[finger]
        )
        expected = respond({"x": one}, [(1.0, drive)])["x"][0]
        assert np.max(np.abs(found[finger] - expected)) <= EQUAL * np.max(np.abs(expected))


@pytest.mark.parametrize(
    ("other", "agrees"),
    [
        ([1.0, -2.0, 0.0], True),
        ([1.0, -2.0, 1e-9], True),
        ([1.0, -2.0, 4e-9], False),
        ([1.0, np.nan, 0.0], False),
        ([1.0, -2.0], False),
    ],
)
def test_fingers_agree_to_a_billionth_of_the_peak(other, agrees):
    assert _agree(np.array(other), np.array([1.0, -2.0, 0.0]), 1e-9) == agrees
