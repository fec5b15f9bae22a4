"""Drives that prescribe a current: any voltage drive over a resistance, and never mixed with voltages."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.current import CurrentAmplifier, CurrentSine
from electrovib.physics.drive.sines import Sine

VOLTAGES = {name: kind for name, kind in find_members(Drive).items() if kind.quantity == "voltage"}


@pytest.mark.parametrize("name", VOLTAGES)
def test_the_current_follows_the_command(name):
    command = read_model(VOLTAGES[name], dict(VOLTAGES[name].example))
    drive = CurrentAmplifier(command=command, sense_resistance=2e4)
    times = (np.arange(400) + 1 / np.sqrt(2)) / 400 * command.duration
    scale = np.max(np.abs(command.voltage(times))) / 2e4
    np.testing.assert_allclose(
        drive.voltage(times), command.voltage(times) / 2e4, rtol=1e-14, atol=1e-15 * scale
    )
    steepest = np.max(np.abs(command.slope(times))) / 2e4
    np.testing.assert_allclose(
        drive.slope(times), command.slope(times) / 2e4, rtol=1e-14, atol=1e-15 * steepest
    )
    assert (drive.period, drive.duration) == (command.period, command.duration)
    np.testing.assert_array_equal(drive.time_stamps, command.time_stamps)


def test_a_current_sine_is_a_sine_in_amperes():
    times = np.linspace(0, 1e-3, 101)
    drive = CurrentSine(amplitude=1e-3, frequency=2e3, phase=0.3)
    same = Sine(amplitude=1e-3, frequency=2e3, phase=0.3)
    np.testing.assert_array_equal(drive.voltage(times), same.voltage(times))
    assert drive.quantity == "current"
    assert same.quantity == "voltage"
    assert (drive.period, drive.duration) == (same.period, same.duration)


def test_quantities_are_known():
    assert {kind.quantity for kind in find_members(Drive).values()} == {"voltage", "current"}


@pytest.mark.parametrize(
    "outer",
    [
        {"model": "Sum", "drives": [{"model": "Sine", "amplitude": 1, "frequency": 50}, None]},
        {"model": "Offset", "level": 1, "drive": None},
        {"model": "CurrentAmplifier", "sense_resistance": 1e3, "command": None},
    ],
    ids=lambda outer: outer["model"],
)
def test_a_current_inside_another_drive_is_refused(outer):
    inner = {"model": "CurrentSine", "amplitude": 1e-3, "frequency": 1e3}
    filled = {
        key: inner if value is None else [inner if item is None else item for item in value]
        if isinstance(value, list)
        else value
        for key, value in outer.items()
    }  # fmt: skip
    with pytest.raises(InputError, match="CurrentAmplifier"):
        read_model(Drive, filled)


def test_volts_are_no_amperes():
    with pytest.raises(InputError, match="expected a current"):
        read_model(CurrentSine, {"amplitude": "1 V", "frequency": 50})
