"""Synthetic recordings of a plate with a gap that conducts, whose parameters are known."""

import numpy as np

import electrovib as ev
from electrovib.core.signals import make_trace
from electrovib.recordings.fit import MeasuredTrace
from electrovib.recordings.fit.prediction import Prediction

GAP, LEAK, FILM = "stack.gap.thickness", "stack.gap.material.conductivity", "stack.insulator.thickness"
FREE = (GAP, LEAK, FILM)
TIMES = np.linspace(0, 30e-3, 60)
FREQUENCIES = np.geomspace(1, 1e5, 25)
SIGNALS = {"step": "electrostatic_force", "sweep": "mean_force", "impedance": "impedance"}


def plate(**changes):
    """A step of 100 V on an insulator of 1 um and a conducting gap of 3 um."""
    return ev.load("bau_2010/sine").replace(
        {
            "drive": {
                "model": "Trapezium",
                "high": "100 V",
                "rise": "10 us",
                "hold": "20 ms",
                "fall": "10 us",
            },
            "time": {"model": "TimeGrid", "duration": "30 ms"},
            LEAK: "2e-9 S/m",
        }
        | changes
    )


def empty(kind, *, times=TIMES, frequencies=FREQUENCIES):
    axis, x = ("time", times) if kind == "step" else ("frequency", frequencies)
    values = np.ones(x.size, complex if kind == "impedance" else float)
    return make_trace({SIGNALS[kind]: ((axis,), values)}, {axis: x}, {})


def exact(scenario, kind, **axes):
    """The prediction of a scenario for one kind of recording, as a Trace."""
    trace = empty(kind, **axes)
    prediction = Prediction(scenario, [MeasuredTrace(trace=trace)], free=[GAP])
    rows = prediction({GAP: prediction.free[GAP].start})
    size = trace[SIGNALS[kind]].size
    trace[SIGNALS[kind]].values[:] = rows if rows.size == size else rows[:size] + 1j * rows[size:]
    return trace


def noisy(trace, rng, *, noise=0.01):
    """Relative noise of an impedance, of each part; of a force over its largest value."""
    found = trace.copy(deep=True)
    for name in found.data_vars:
        y = found[name].values
        if np.iscomplexobj(y):
            y += noise * np.abs(y) * (rng.normal(size=y.size) + 1j * rng.normal(size=y.size))
        else:
            y += noise * np.abs(y).max() * rng.normal(size=y.size)
    return found


def truth(scenario):
    return {path: float(value) for path, value, _ in scenario.parameters() if path in FREE}


COEFFICIENT = "friction.coefficient"
LAGGING = {
    "motion.speed": "50 mm/s",
    "friction": {
        "model": "FirstOrderLag",
        "steady": {"model": "Coulomb", "coefficient": 0.5},
        "cut_off": "100 Hz",
    },
}
COULOMB = {"motion.speed": "50 mm/s", "friction": {"model": "Coulomb", "coefficient": 0.5}}
PAIRS = {
    "other law": ({}, {"force": {"model": "MaxwellStressInInsulator"}}, (GAP, LEAK)),
    "leak left out": ({}, {LEAK: 0.0}, (GAP, FILM)),
    "memory of friction": (LAGGING, COULOMB, (COEFFICIENT, GAP)),
    "other drive": ({}, {"drive.hold": "18 ms"}, (GAP, LEAK)),
}
"""What makes a recording, and a wrong model of it: changes of the plate, and the parameters that are fitted."""


def pair(name, *, wrong):
    """An exact recording, a right or a wrong model of it, and the parameters that are fitted."""
    truth_of, model, free = PAIRS[name]
    base = plate(**truth_of)
    free = tuple(
        "friction.steady.coefficient" if not wrong and each == COEFFICIENT else each for each in free
    )
    fitted = plate(**model) if wrong else base
    if truth_of:  # of friction
        values = ev.prepare(base, free=[GAP]).signals([3e-6], names=["lateral_force"], time=TIMES)[
            "lateral_force"
        ]
        return make_trace({"lateral_force": (("time",), values)}, {"time": TIMES}, {}), fitted, free
    return exact(base, "step"), fitted, free
