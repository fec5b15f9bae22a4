"""Parts of scenarios as they stand in a file, in one line each, and what the comparisons measure by."""

import json

import numpy as np
from hypothesis import strategies as st

EPS0 = 8.8541878128e-12
AREA = 1e-4
"""Contact of the finger of Vezzoli et al. 2014 [m2]."""


def model(name, **parameters):
    return {"model": name, **parameters}


def step(level):
    return model("Step", level=level)


def sine(amplitude, frequency, **more):
    return model("Sine", amplitude=amplitude, frequency=frequency, **more)


def square(high, frequency, **more):
    return model("Square", high=high, frequency=frequency, **more)


def trapezium(high, rise, hold, fall, **more):
    return model("Trapezium", high=high, rise=rise, hold=hold, fall=fall, **more)


def swipe(begin, rise, hold, fall):
    return model("Swipe", begin=begin, rise=rise, hold=hold, fall=fall)


def constant(permittivity=1560.0, conductivity=0.0):
    return model("Constant", permittivity=permittivity, conductivity=conductivity)


def debye(high, strength, time, conductivity=0.0):
    return model(
        "Debye", permittivity_high=high, strength=strength, relaxation_time=time, conductivity=conductivity
    )


def prony(debye_sum, conductivity=0.0):
    pairs = zip(debye_sum.strengths, debye_sum.relaxation_times, strict=True)
    terms = [{"strength": strength, "relaxation_time": time} for strength, time in pairs]
    return model("Prony", permittivity_high=debye_sum.high, terms=terms, conductivity=conductivity)


def layer(thickness, material, **more):
    return {"thickness": thickness, "material": material, **more}


def grounded(resistance=0.0):
    return model("Grounded", resistance=resistance)


def floating(**more):
    return model("Floating", capacitance=150e-12, **more)


def polarity(positive, negative):
    return model("PolarityConduction", conductivity_positive=positive, conductivity_negative=negative)


SETTLED = {"time.initial_state": model("PeriodicState")}
COULOMB = model("Coulomb", coefficient=0.5)
FINGER = model("MassSpringDamper", mass=1.5e-4, stiffness=1e3, damping=1.0)


def lag(cut_off, **more):
    return model("FirstOrderLag", steady=COULOMB, cut_off=cut_off, **more)


def creep(share, time):
    return model("Creep", steady=COULOMB, relaxations=[{"share": share, "time": time}])


def lugre(stiffness, static_ratio=1.5, stribeck_speed=5e-3, **more):
    own = {"stiffness": stiffness, "static_ratio": static_ratio, "stribeck_speed": stribeck_speed}
    return model("LuGre", steady=COULOMB, **own, **more)


def tribometer(lateral, normal=None, **more):
    """A rig whose normal sensor keeps what it reads unless another is given."""
    kept = {"natural_frequency": 2e3, "damping_ratio": 0.5, "time_constant": 1e4}
    return model("Tribometer", normal=normal or kept, lateral=lateral, **more)


def diagnostics(trace):
    return {each["name"]: each for each in json.loads(trace.attrs["validity"])}


def largest(values):
    return float(np.max(np.abs(values)))


def apart(found, expected):
    """Largest difference over the largest expected value."""
    return largest(np.asarray(found) - np.asarray(expected)) / largest(expected)


def powers(low, high):
    """Numbers of any size between two powers of ten."""
    return st.floats(low, high).map(lambda power: 10.0**power)
