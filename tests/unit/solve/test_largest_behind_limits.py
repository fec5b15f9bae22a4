"""Largest current behind an amplifier that saturates, against the closed form of a capacitor."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.constants import epsilon_0
from scipy.optimize import brentq

import electrovib as ev

STRAY, GAIN = 100e-12, 100.0
AREA = 1e-4
SLOW, FAST = 2 * np.pi * 100, 2 * np.pi * 500
DRIVE = {
    "model": "Sum",
    "drives": [
        {"model": "Sine", "amplitude": 5.0, "frequency": 100},
        {"model": "Sine", "amplitude": 1.0, "frequency": 500, "phase": np.pi},
    ],
}
RAMPS = {"model": "Trapezium", "high": 10.0, "rise": 2e-3, "hold": 1e-3, "fall": 0.5e-3}
CAPACITANCE = AREA * epsilon_0 / (90e-6 / 3.35 + 200e-6 / 1133)


def capacitor(drive, saturation, samples=57):
    """Two lossless layers behind an amplifier that saturates."""
    changes = {
        "drive": drive,
        "contact.area": AREA,
        "stack.insulator.thickness": 90e-6,
        "stack.insulator.material": {"model": "Constant", "permittivity": 3.35},
        "stack.stratum_corneum.thickness": 200e-6,
        "stack.stratum_corneum.material": {"model": "Constant", "permittivity": 1133.0},
        "circuit.return_path.resistance": 1.0,
        "circuit.amplifier": {"gain": GAIN, "saturation": saturation, "stray_capacitance": STRAY},
        "limits": {"current": 1.0, "voltage": 2e3},
        "time": {"duration": 4e-3, "samples": samples},
    }
    return ev.load("vezzoli_2014/fig6_static", changes=changes)


def largest(result):
    """The largest current of the plate and the stray capacitance that the diagnostics state."""
    return next(d["value"] for d in json.loads(result.attrs["validity"]) if d["name"] == "current")


def largest_before_saturation(saturation):
    """Largest slope of the drive up to the time at which it reaches the saturation, which it does while it grows."""

    def voltage(time):
        return GAIN * (5 * np.sin(SLOW * time) - np.sin(FAST * time))

    reached = brentq(lambda time: voltage(time) - saturation, 1e-5, 1e-3, xtol=1e-15)
    slope = GAIN * 5 * SLOW * (np.cos(SLOW * reached) - np.cos(FAST * reached))
    return (CAPACITANCE + STRAY) * slope


@pytest.mark.parametrize("saturation", [100.0, 200.0])
@pytest.mark.parametrize("samples", [57, 4001])
def test_the_largest_current_is_the_one_at_which_the_amplifier_saturates(saturation, samples):
    scenario = capacitor(DRIVE, saturation, samples)
    expected = largest_before_saturation(saturation)
    assert largest(ev.simulate(scenario)) == pytest.approx(expected, rel=1e-6)
    swept = ev.sweep(
        scenario, over={"circuit.amplifier.saturation": [saturation]}, quantities=["peak electrostatic_force"]
    )
    assert largest(swept) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("saturation", [800.0, 2e3])
def test_the_largest_current_of_a_ramp_is_that_before_its_end(saturation):
    """The largest voltage ends the rise at 800 V, and the drive does below 2 kV."""
    scenario = capacitor(RAMPS, saturation)
    expected = (CAPACITANCE + STRAY) * GAIN * 10 / 0.5e-3
    assert largest(ev.simulate(scenario)) == pytest.approx(expected, rel=1e-9)
    swept = ev.sweep(
        scenario, over={"circuit.amplifier.saturation": [saturation]}, quantities=["peak electrostatic_force"]
    )
    assert largest(swept) == pytest.approx(expected, rel=1e-9)


def test_a_sweep_states_the_largest_current_of_a_skin_that_conducts():
    """The current grows up to the end of the ramp, where it jumps: 38 % more would come from a parabola through both sides."""
    amplifier = {"saturation": 2e3, "stray_capacitance": STRAY}
    scenario = ev.load(
        "vezzoli_2014/fig6",
        changes={"circuit.amplifier": amplifier, "limits": {"current": 1.0}, "time.duration": 30e-3},
    ).replace({"drive.rise": 10e-3, "drive.hold": 10e-3, "drive.fall": 6e-3})
    expected = np.max(
        np.abs(ev.simulate(scenario, time=np.linspace(0, 30e-3, 30001)).amplifier_current.values)
    )
    assert largest(ev.simulate(scenario)) == pytest.approx(expected, rel=1e-6)
    swept = ev.sweep(
        scenario, over={"circuit.amplifier.saturation": [2e3]}, quantities=["peak electrostatic_force"]
    )
    assert largest(swept) == pytest.approx(expected, rel=1e-6)
