"""The largest voltage and the largest current of a drive count as the same numbers wherever they are needed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.constants import epsilon_0
from scipy.optimize import brentq

import electrovib as ev
from electrovib.core.diagnostics import diagnostics_of

PULSE = {
    "model": "Trapezium",
    "high": 100.0,
    "rise": 0.0,
    "hold": 8e-6,
    "fall": 0.0,
    "delay": 20.03e-3,
    "repeat": 0.1,
}
HELD = {"model": "Step", "level": "100 V"}


@pytest.mark.parametrize(
    ("short", "held"),
    [(PULSE, HELD), ({"model": "Offset", "drive": PULSE, "level": "50 V"}, HELD | {"level": "150 V"})],
    ids=["pulse", "pulse on an offset"],
)
def test_a_short_pulse_counts_everywhere(short, held):
    """8 us at 20.03 ms fall between any even times; it is held against the same voltage for ever."""
    spring = {"model": "LinearSpring", "stiffness": "1 TPa/m", "free_gap": "2 um"}
    stack = {
        "stack.insulator.thickness": 1e-6,
        "stack.gap.thickness": 2e-6,
        "stack.gap.material.conductivity": 0.0,
    }
    scenario = ev.load("vezzoli_2014/fig6_gap", changes=stack | {"contact.surface": spring})
    one, other = (scenario.replace({"drive": drive}) for drive in (short, held))
    assert ev.equilibrium(one).voltage == ev.equilibrium(other).voltage
    assert ev.equilibrium(one).force == ev.equilibrium(other).force
    assert ev.equilibrium(one).force[0] > 0.05
    assert ev.simulate(one).mean_force.values.tolist() == ev.simulate(other).mean_force.values.tolist()
    statics = [[entry.static for entry in ev.compare(each).entries] for each in (one, other)]
    assert statics[0] == statics[1]


STRAY, GAIN = 100e-12, 100.0
LOAD = 1e-4 * epsilon_0 / (90e-6 / 3.35 + 200e-6 / 1133) + STRAY
"""Of two lossless layers, plate and cable [F]."""
SLOW, FAST = 2 * np.pi * 100, 2 * np.pi * 500
TONES = [
    {"model": "Sine", "amplitude": 5.0, "frequency": 100},
    {"model": "Sine", "amplitude": 1.0, "frequency": 500, "phase": np.pi},
]
RAMPS = {"model": "Trapezium", "high": 10.0, "rise": 2e-3, "hold": 1e-3, "fall": 0.5e-3}


def slope_where_it_saturates(saturation):
    """Slope of the drive at the time at which it reaches the saturation, which it does while the slope grows."""
    reached = brentq(
        lambda time: GAIN * (5 * np.sin(SLOW * time) - np.sin(FAST * time)) - saturation,
        1e-5,
        1e-3,
        xtol=1e-15,
    )
    return 5 * SLOW * (np.cos(SLOW * reached) - np.cos(FAST * reached))


def check_largest_current(scenario, expected, rel):
    """Of the plate and the stray capacitance, as a run and a sweep state it."""
    swept = {"circuit.amplifier.saturation": [scenario.circuit.amplifier.saturation]}
    for result in (
        ev.simulate(scenario),
        ev.sweep(scenario, over=swept, quantities=["peak electrostatic_force"]),
    ):
        found = next(each.value for each in diagnostics_of(result) if each.name == "current")
        assert found == pytest.approx(expected, rel=rel)


@pytest.mark.parametrize(
    ("drive", "slope", "saturation"),
    [
        ({"model": "Sum", "drives": TONES}, slope_where_it_saturates(saturation), saturation)
        for saturation in (100.0, 200.0)
    ]
    # the largest voltage ends the rise at 800 V, and the drive does below 2 kV
    + [(RAMPS, 10 / 0.5e-3, saturation) for saturation in (800.0, 2e3)],
)
@pytest.mark.parametrize("samples", [57, pytest.param(4001, marks=pytest.mark.slow)])
def test_the_largest_current_is_that_at_which_the_amplifier_saturates(drive, slope, saturation, samples):
    """Of a capacitor."""
    skin = {"model": "Constant", "permittivity": 1133.0}
    amplifier = {"gain": GAIN, "saturation": saturation, "stray_capacitance": STRAY}
    changes = {
        "drive": drive,
        "stack.stratum_corneum.material": skin,
        "circuit": {"amplifier": amplifier, "return_path": {"model": "Grounded", "resistance": 1.0}},
        "limits": {"current": 1.0, "voltage": 2e3},
        "time": {"duration": 4e-3, "samples": samples},
    }
    scenario = ev.load("vezzoli_2014/fig6_static", changes=changes)
    check_largest_current(scenario, LOAD * GAIN * slope, 1e-6 if drive != RAMPS else 1e-9)


def test_a_sweep_states_the_largest_current_of_a_skin_that_conducts():
    """The current grows up to the end of the ramp, where it jumps: 38 % more would come from a parabola through both sides."""
    amplifier = {
        "circuit.amplifier": {"saturation": 2e3, "stray_capacitance": STRAY},
        "limits": {"current": 1.0},
    }
    ramps = {"drive.rise": 10e-3, "drive.hold": 10e-3, "drive.fall": 6e-3, "time.duration": 30e-3}
    scenario = ev.load("vezzoli_2014/fig6", changes=amplifier | ramps)
    trace = ev.simulate(scenario, time=np.linspace(0, 30e-3, 30001))
    check_largest_current(scenario, float(np.max(np.abs(trace.amplifier_current))), 1e-6)
