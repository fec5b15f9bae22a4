"""Drives of many fingers as straight pieces and sines: rises, periods, means, and what is settled."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import SLACK
from electrovib.solve.population import Population
from electrovib.solve.population.arrays import respond
from electrovib.solve.population.drive import piecewise_drive
from electrovib.solve.population.fingers import _agree
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integrated

SQUARE = {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}
TRAPEZIUM = {"model": "Trapezium", "high": 100.0, "rise": 0.01, "hold": 0.01, "fall": 0.02}
SLOPE = (1000.001 - 1000.0) / 1.0
NONE = np.zeros(0)


def drive_of(model, **given):
    return read_model(Drive, {"model": model} | given)


def slow_ramp():
    return drive_of("Trapezium", low=1000.0, high=1000.001, rise=1.0, hold=1.0, fall=1.0)


def assert_adds_up(found):
    """Rises add up to the voltage, over jumps and corners too."""
    expected = found.voltage[1:]
    assert np.allclose(found.voltage[0] + np.cumsum(found.rises)[:-1], expected, rtol=0, atol=1e-10)


def test_rises_and_currents_keep_their_digits_beside_a_large_voltage():
    """A slope of 1e-3 V/s at 1 kV rises by 1e-9 V in a step: the difference of the voltages would have four digits.

    A capacitor behind a resistor passes slope/rate of a slow ramp, whatever the voltage it starts from.
    """
    found = piecewise_drive(slow_ramp(), np.linspace(0.0, 0.9, 900_001)[::1000], settled=False)
    steps = np.diff(found.timing.time)
    assert np.allclose(found.rises[:-1][steps > 0], SLOPE * steps[steps > 0], rtol=1e-12, atol=0)
    assert found.rises[-1] == 0
    time, rate = np.linspace(0.0, 0.9, 901), 1e6
    current = Transfer(rates=np.array([rate]), gains=np.array([-1.0]), direct=1.0, static=0.0)
    found = respond({"current": current}, [(1.0, piecewise_drive(slow_ramp(), time, settled=False))])[
        "current"
    ]
    assert np.allclose(found[0, 2:], SLOPE / rate, rtol=1e-11, atol=0)


def test_rises_add_up_to_the_voltage_over_jumps_and_nearly_equal_corners():
    """Of two corners that nearly agree the earlier one is kept, where the slope of the other has not begun."""
    time, drive = np.linspace(0.0, 0.05, 83), drive_of(**SQUARE)
    found = piecewise_drive(drive, time, settled=False)
    assert np.any(np.diff(found.timing.time) == 0)
    assert_adds_up(found)
    assert np.array_equal(found.values(), drive.voltage(time))
    drives = [TRAPEZIUM | {"delay": delay} for delay in (1e-3, 1e-3 * (1 + 1.5 * SLACK))]
    assert_adds_up(
        piecewise_drive(drive_of("Sum", drives=drives), np.array([0.0, 0.02, 0.05]), settled=False)
    )


def test_corners_that_two_drives_share_up_to_rounding_are_one(fingers):
    """Every third corner of one is a corner of the other; as two corners they would be two jumps of both."""
    drives = [SQUARE, SQUARE | {"frequency": 180.0}]
    member = ev.load("vezzoli_2014/fig6_gap").replace({"drive": {"model": "Sum", "drives": drives}})
    time = np.linspace(0.0, 0.2, 331)
    gaps = np.diff(piecewise_drive(member.drive, time, settled=False).timing.time)
    assert not np.any((gaps > 0) & (gaps < 1e-12))
    fingers.assert_together(member, ["stack.gap.thickness"], ["current", "field"], time=time)


def test_a_burst_that_outlasts_the_outputs_is_a_sine_and_one_that_is_switched_within_is_none():
    time, burst = np.linspace(0.0, 0.02, 41), {"amplitude": 3.0, "frequency": 200.0}
    whole = drive_of("Burst", **burst, cycles=5)
    assert np.allclose(
        piecewise_drive(whole, time, settled=False).values(), whole.voltage(time), rtol=0, atol=1e-13
    )
    for delay, cycles in ((0.0, 2), (1e-3, 9)):
        with pytest.raises(NotInArraysError, match="switched within"):
            piecewise_drive(drive_of("Burst", **burst, cycles=cycles, delay=delay), time, settled=False)


def test_a_current_with_a_mean_has_no_periodic_state_in_arrays():
    """Two offsets that cancel beside the scenario, but not for every finger."""
    sines = [
        {"model": "Sine", "amplitude": amplitude, "offset": offset, "frequency": 50.0}
        for amplitude, offset in ((1.0, 0.0), (0.0, 0.5), (0.0, -0.5))
    ]
    command = {"command": {"model": "Sum", "drives": sines}}
    drive = {"model": "CurrentAmplifier", "sense_resistance": 1e6} | command
    free = ["drive.command.drives.1.offset", "drive.command.drives.2.offset"]
    member = ev.load("kim_2015/current").replace({"drive": drive})
    many = Population(member, free, ["interface_field"], np.linspace(0, 0.02, 5))
    assert "mean" in many.method
    with pytest.raises(InputError, match="mean"):
        many.signals({free[0]: np.array([0.5, 0.7]), free[1]: np.array([-0.5, -0.5])})


def test_a_drive_with_a_mean_is_not_integrated_for_ever():
    """The integral of a periodic drive is periodic only without a mean."""
    charge = integrated(Transfer(rates=NONE, gains=NONE, direct=2.0))
    drives = (drive_of("Square", frequency=50.0, high=1.0, low=low) for low in (-1.0, 0.0))
    even, uneven = (piecewise_drive(each, np.linspace(0, 0.02, 41), settled=True) for each in drives)
    found = respond({"charge": charge}, [(np.array([[3.0]]), even)])["charge"]
    assert np.max(found) == pytest.approx(2 * 3 * 0.01 / 2, rel=1e-12)
    with pytest.raises(NotInArraysError, match="mean"):
        respond({"charge": charge}, [(1.0, uneven)])


@pytest.mark.parametrize("is_settled", [False, True])
def test_a_mode_that_one_finger_does_not_excite_responds_in_the_others(is_settled):
    rates = np.array([[3.0, 400.0], [5.0, 600.0], [7.0, 90.0]])
    gains = np.array([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0]])
    direct, free = np.array([[0.1], [0.2], [0.3]]), np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
    drive = piecewise_drive(drive_of(**SQUARE), np.linspace(0.0, 0.05, 41), settled=is_settled)
    found = respond({"x": Transfer(rates=rates, gains=gains, direct=direct, free=free)}, [(1.0, drive)])["x"]
    for each in range(3):
        own = {"gains": gains[each], "direct": float(direct[each, 0]), "free": free[each]}
        expected = respond({"x": Transfer(rates=rates[each], **own)}, [(1.0, drive)])["x"][0]
        assert np.max(np.abs(found[each] - expected)) <= 1e-12 * np.max(np.abs(expected))


def test_fingers_agree_to_a_billionth_of_the_peak():
    expected = np.array([1.0, -2.0, 0.0])
    for other in ([1.0, -2.0, 0.0], [1.0, -2.0, 1e-9]):
        assert _agree(np.array(other), expected, 1e-9)
    for other in ([1.0, -2.0, 4e-9], [1.0, np.nan, 0.0], [1.0, -2.0]):
        assert not _agree(np.array(other), expected, 1e-9)
