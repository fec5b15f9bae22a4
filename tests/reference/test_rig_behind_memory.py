"""What a rig reads of a friction with memory does not depend on how many times are asked for, nor on the start."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.scenario import load
from electrovib.solve.simulate import simulate

COULOMB = {"model": "Coulomb", "coefficient": 0.5}
RIG = {
    "model": "Tribometer",
    "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
    "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
}
FRICTIONS = {
    "lag": {"model": "FirstOrderLag", "steady": COULOMB, "cut_off": 200.0},
    "creep": {"model": "Creep", "steady": COULOMB, "relaxations": [{"share": 0.3, "time": 5e-3}]},
    "bristles": {
        "model": "LuGre",
        "steady": COULOMB,
        "stiffness": 5e4,
        "static_ratio": 1.5,
        "stribeck_speed": 5e-3,
    },
}


@pytest.mark.parametrize("name", sorted(FRICTIONS))
def test_few_times_read_the_same_as_many(name):
    """Within the stated error; straight pieces between 26 times would be off by a third of the swing."""
    finger = {"model": "MassSpringDamper", "mass": 1.5e-4, "stiffness": 1e3, "damping": 0.2}
    changes = {"friction": FRICTIONS[name], "rig": RIG, "motion.speed": 0.03}
    changes |= {"finger": finger} if name == "bristles" else {}
    square = {"drive": {"model": "Square", "high": 600.0, "frequency": 40.0, "edge": 1e-3}}
    scenario = load("vezzoli_2014/fig6_gap").replace(changes | square)
    many = simulate(scenario, time=np.linspace(0, 0.1, 2001)).lateral_force_measured.values[::80]
    few = simulate(scenario, time=np.linspace(0, 0.1, 26))
    allowed = few.attrs["mechanics_error"] * np.max(np.abs(many))
    assert allowed < 0.02 * np.ptp(many)
    assert np.max(np.abs(few.lateral_force_measured.values - many)) <= allowed


@pytest.mark.parametrize("friction", [COULOMB, FRICTIONS["lag"]])
def test_the_sensors_are_in_the_periodic_state_too(friction):
    """Against a late period from rest: the slowest mode of the sensor falls by 157/s, so 0.25 s leave 1e-17."""
    turn = 1 / 240
    scenario = load("vezzoli_2014/fig6_gap").replace(
        {"rig": RIG, "friction": friction, "drive": {"model": "Sine", "amplitude": 500.0, "frequency": 240.0}}
    )
    settled = scenario.replace({"time.initial_state": {"model": "PeriodicState"}})
    read = simulate(settled, time=np.linspace(0, turn, 41)).lateral_force_measured.values
    late = simulate(scenario, time=np.append(0.0, 240 * turn + np.linspace(0, turn, 41)))
    late = late.lateral_force_measured.values[1:]
    # the gap of this scenario leaks with 8 ms: nothing of its beginning is left either
    assert np.max(np.abs(read - late)) < 1e-5 * np.max(np.abs(late))
    assert np.ptp(late) > 1e-3
