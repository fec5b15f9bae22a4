"""Synthetic recordings of a plate with a gap that conducts, whose parameters are known."""

import numpy as np
from scipy.signal import lfilter

import electrovib as ev
from electrovib.core.paths import value_at
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
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


SENSOR = {
    "normal": {"natural_frequency": "20 kHz", "damping_ratio": 1, "time_constant": "100 s"},
    "lateral": {"natural_frequency": "20 kHz", "damping_ratio": 1},
}


def rig(**lateral):
    """A tribometer whose lateral sensor differs from a quick one."""
    return {"rig": {"model": "Tribometer"} | SENSOR | {"lateral": SENSOR["lateral"] | lateral}}


PULSE = {
    "drive": {"model": "Trapezium", "high": "100 V", "rise": "36 ms", "hold": "100 ms", "fall": "36 ms"},
    "time": {"model": "TimeGrid", "duration": "300 ms"},
} | COULOMB
FALLING = {"model": "PowerLaw", "coefficient": 0.5, "at_force": "0.5 N", "exponent": -0.3}
SKIN = {
    "model": "ColeCole",
    "permittivity_high": 200.0,
    "terms": [{"strength": 3e4, "relaxation_time": "1.6 ms", "broadening": 0.3}],
    "conductivity": "1.8 uS/m",
}
SLOW = rig(natural_frequency="100 Hz", damping_ratio=0.7)
PULSES = {
    "friction that falls with load as Coulomb's": ({"friction": FALLING}, {}, 0.003),
    "skin that relaxes as one that does not": ({"stack.stratum_corneum.material": SKIN}, {}, 0.001),
    "leak left out": ({}, {LEAK: 0.0}, 0.003),
    "sensor of 100 Hz as a quick one": (rig(bandwidth="100 Hz"), rig(), 0.003),
    "rise of 36 ms as one of 30 ms": ({}, {"drive.rise": "30 ms"}, 0.003),
    "noise of a declared sensor": (SLOW, None, 0.01),
}
"""Lateral forces under a pulse of the founding paper's shape: what makes the recording, how a wrong model differs from a plate
with Coulomb's friction (None: no wrong one), and the noise over the largest change."""
MOMENTS = np.linspace(0, 0.3, 400)


def correlated(rng, count, memory):
    """Noise of variance 1, of which each sample has the part `memory` in common with the one before."""
    drawn = rng.normal(size=count + (400 if memory else 0))
    return lfilter([np.sqrt(1 - memory**2)], [1, -memory], drawn)[-count:]


def of_sensor(scenario, rng):
    """Noise of variance 1 at `MOMENTS`: that of the sliding finger through the declared sensor, and a tenth of white noise."""
    count = 8 * MOMENTS.size
    rates = np.fft.rfftfreq(count, MOMENTS[1])
    gain = np.abs(scenario.rig.lateral.gain(rates))
    passed = np.fft.irfft(np.fft.rfft(rng.normal(size=count)) * gain, count)
    return np.sqrt(0.9) * passed[: MOMENTS.size] / np.std(passed) + np.sqrt(0.1) * rng.normal(
        size=MOMENTS.size
    )


class PulseTwins:
    """Recordings of one of `PULSES`, and their fits by a right and a wrong model; even numbers state the noise."""

    def __init__(self, name):
        truth, wrong, self.noise = PULSES[name]
        self.right = plate(**(PULSE | truth))
        self.wrong = None if wrong is None else plate(**(PULSE | wrong))
        self.signal = "lateral_force_measured" if self.right.rig else "lateral_force"
        signals = ev.prepare(self.right, free=[GAP]).signals([3e-6], names=[self.signal], time=MOMENTS)
        self.exact, self.is_coloured = signals[self.signal], wrong is None

    def fit(self, number, *, wrong, memory=0.0):
        rng, noise = np.random.default_rng([15, number]), self.noise * float(np.ptp(self.exact))
        drawn = of_sensor(self.right, rng) if self.is_coloured else correlated(rng, MOMENTS.size, memory)
        trace = make_trace({self.signal: (("time",), self.exact + noise * drawn)}, {"time": MOMENTS}, {})
        model = self.wrong if wrong else self.right
        leak = (LEAK,) if value_at(model, LEAK) else ()
        recorded = MeasuredTrace(trace=trace, noise={} if number % 2 else {self.signal: noise})
        return fit_scenario(model, recorded, free=(GAP, "friction.coefficient", *leak))
