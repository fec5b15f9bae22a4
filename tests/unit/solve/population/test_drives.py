"""Drives of many fingers as straight pieces and sines: rises, periods, means, and what is settled."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve.population import population
from electrovib.solve.population.arrays import respond_to
from electrovib.solve.population.drive import parts_of
from electrovib.solve.population.fingers import _agree
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integrated

SQUARE = {"model": "Square", "high": 100.0, "low": -50.0, "frequency": 60.0}
SLOPE = (1000.001 - 1000.0) / 1.0
NONE = np.zeros(0)


def drive_of(model, **given):
    return read_model(Drive, {"model": model} | given)


def slow_ramp():
    return drive_of("Trapezium", low=1000.0, high=1000.001, rise=1.0, hold=1.0, fall=1.0)


def responded(transfer, terms, time, settled=False):
    """The response of one quantity."""
    return respond_to({"x": transfer}, terms, time, settled=settled)(slice(None))["x"]


def parts(model, **given):
    return parts_of(drive_of(model, **given), 1.0)


def test_currents_keep_their_digits_beside_a_large_voltage():
    """A capacitor behind a resistor passes slope/rate of a slow ramp, whatever the voltage it starts from."""
    time, rate = np.linspace(0.0, 0.9, 901), 1e6
    current = Transfer(rates=np.array([rate]), gains=np.array([-1.0]), direct=1.0, static=0.0)
    found = responded(current, [(1.0, slow_ramp().parts())], time)
    assert np.allclose(found[0, 2:], SLOPE / rate, rtol=1e-11, atol=0)


def test_corners_that_two_drives_share_up_to_rounding_agree(fingers):
    """Every third corner of one is a corner of the other."""
    drives = [SQUARE, SQUARE | {"frequency": 180.0}]
    member = ev.load("vezzoli_2014/fig6_gap").replace({"drive": {"model": "Sum", "drives": drives}})
    time = np.linspace(0.0, 0.2, 331)
    fingers.assert_together(member, ["stack.gap.thickness"], ["current", "field"], time=time)


@pytest.mark.parametrize(("delay", "cycles"), [(0.0, 2), (1e-3, 9), (0.0, 5)])
def test_sines_that_are_switched_within_the_outputs_agree(fingers, delay, cycles):
    burst = {"model": "Burst", "amplitude": 30.0, "frequency": 200.0, "delay": delay, "cycles": cycles}
    member, free = ev.load("vezzoli_2014/fig6_gap").replace({"drive": burst}), ["stack.gap.thickness"]
    names = ("electrostatic_force", "current", "drive_voltage")
    fingers.assert_together(member, [*free, "drive.amplitude"], names, time=np.linspace(0.0, 0.02, 41))


def test_a_drive_of_very_many_corners_and_one_of_a_formula_are_one_by_one():
    with pytest.raises(NotInArraysError, match="20000 corners"):
        parts("Square", high=1.0, low=0.0, frequency=11_000.0)
    with pytest.raises(NotInArraysError, match="neither"):
        parts("Chirp", amplitude=1.0, first=10.0, last=20.0, length=1.0)


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
    many = population(member, free, ["interface_field"], np.linspace(0, 0.02, 5))
    assert "mean" in many.method
    with pytest.raises(InputError, match="mean"):
        many.signals({free[0]: np.array([0.5, 0.7]), free[1]: np.array([-0.5, -0.5])})


def test_a_drive_with_a_mean_is_not_integrated_for_ever():
    """The integral of a periodic drive is periodic only without a mean."""
    charge = integrated(Transfer(rates=NONE, gains=NONE, direct=2.0))
    drives = (drive_of("Square", frequency=50.0, high=1.0, low=low) for low in (-1.0, 0.0))
    (even, uneven), time = (each.parts() for each in drives), np.linspace(0, 0.02, 41)
    found = responded(charge, [(np.array([[3.0]]), even)], time, settled=True)
    assert np.max(found) == pytest.approx(2 * 3 * 0.01 / 2, rel=1e-12)
    with pytest.raises(NotInArraysError, match="mean"):
        responded(charge, [(1.0, uneven)], time, settled=True)


@pytest.mark.parametrize("is_settled", [False, True])
def test_a_mode_that_one_finger_does_not_excite_responds_in_the_others(is_settled):
    rates = np.array([[3.0, 400.0], [5.0, 600.0], [7.0, 90.0]])
    gains = np.array([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0]])
    direct, free = np.array([[0.1], [0.2], [0.3]]), np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
    given = [(1.0, parts(**SQUARE))], np.linspace(0.0, 0.05, 41), is_settled
    found = responded(Transfer(rates=rates, gains=gains, direct=direct, free=free), *given)
    for each in range(3):
        own = {"gains": gains[each], "direct": float(direct[each, 0]), "free": free[each]}
        expected = responded(Transfer(rates=rates[each], **own), *given)[0]
        assert np.max(np.abs(found[each] - expected)) <= 1e-12 * np.max(np.abs(expected))


def test_fingers_agree_to_a_billionth_of_the_peak():
    expected = np.array([1.0, -2.0, 0.0])
    for other in ([1.0, -2.0, 0.0], [1.0, -2.0, 1e-9]):
        assert _agree(np.array(other), expected, 1e-9)
    for other in ([1.0, -2.0, 4e-9], [1.0, np.nan, 0.0], [1.0, -2.0]):
        assert not _agree(np.array(other), expected, 1e-9)
