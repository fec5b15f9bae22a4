"""Stick-slip of a slowly sliding fingertip: a constant attraction delays the slip, a modulated one delays it less."""

import numpy as np
from matplotlib.figure import Figure

import electrovib as ev

FINGER = {"model": "MassSpringDamper", "mass": "0.15 g", "stiffness": "1 kN/m", "damping": "0.02 N s/m"}
BRISTLES = {
    "model": "LuGre",
    "steady": {"model": "Coulomb", "coefficient": 0.5},
    "stiffness": "50 kN/m",
    "static_ratio": 1.5,
    "stribeck_speed": "10 mm/s",
    "bristle_damping": "0.5 N s/m",
}


def main() -> dict:
    """Return the Traces without and with a voltage."""
    base = ev.load("vezzoli_2014/fig6_static").replace(
        {
            "finger": FINGER,
            "friction": BRISTLES,
            "motion": {"speed": "10 mm/s", "time_profile": {"model": "Press", "rise": "5 ms"}},
            "force.model": "MaxwellStressInGap",
        }
    )
    drives = {
        "no voltage": {"model": "Step", "level": 0.0},
        "500 V held": {"model": "Step", "level": 500.0},
        "500 V, force at 100 Hz": {"model": "Sine", "amplitude": 500.0, "frequency": 50.0},
    }
    time = np.linspace(0, 0.2, 4001)
    return {label: ev.simulate(base.replace({"drive": drive}), time=time) for label, drive in drives.items()}


def draw(traces: dict) -> Figure:
    """Draw friction over time."""
    return ev.plot.lateral_force(traces).figure


if __name__ == "__main__":
    traces = main()
    for label, trace in traces.items():
        print(
            f"{label}: friction {float(trace.lateral_force.max()):.3f} N at most, {trace.attrs['friction_events']} reversals"
        )
    draw(traces).savefig("stick_slip.png")
