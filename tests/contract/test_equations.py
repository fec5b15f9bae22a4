"""The printed equation is the code: both are evaluated at random points, and a changed equation is refused."""

from types import SimpleNamespace

import numpy as np
import pytest
from declared_equations import Evaluation, arguments_of, method_of, symbols, twisted

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.readback import Readback
from electrovib.physics.force import ForceLaw
from electrovib.physics.motion import Separation
from electrovib.physics.texture.base import RenderingPlate
from electrovib.physics.texture.profile import MeasuredTexture
from electrovib.physics.time_profile import TimeProfile
from electrovib.scenario import load
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors
from electrovib.studies.catalogue.items import everything

AGREEMENT = 1e-12
"""Relative: rounding of a dozen operations and of a complex power."""
SOLVED = 1e-5
"""Relative: error of a solution in time and of its derivative."""
REFUSAL = 1e-6
"""A change of the equation has to show at least this much."""
POINTS = 100
DECADES = {"frequency": (-1, 9), "gap": (-9, -4), "pressure": (0, 7), "strength": (-3, 2)}
"""Powers of ten between which an argument that cannot be negative is tried."""
ALONG = {"time", "periods", "position", "vectors"}
"""Arguments over which a result has zeros, so that it is compared relative to its largest value."""
RECORD = {"angle": 0.4, "scale": 3, "position_samples": [1e-3, 2e-3, 4e-3]}
MORE = {
    "Amplifier": {"saturation": 50},
    "AmplitudeModulation": {"offset": 20},
    "Burst": {"offset": 20, "delay": 0.01},
    "Chirp": {"offset": 20},
    "Circuit": {"source_resistance": 2000, "return_path": {"model": "Floating", "capacitance": 1e-10}},
    "ConstantSpeed": {"begin": 0.01, "across": 0.02},
    "CurrentSine": {"offset": 1e-4, "phase": 0.4},
    "Encoder": {"wraps_at": 65536},
    "Floating": {"leak": 1e9},
    "HeightProfile": {"angle": 0.4, "gain": 2},
    "LateralSensor": {"bandwidth": 300, "creep": {"share": 0.1, "time": 0.2}},
    "LuGre": {"bristle_damping": 1, "viscous_damping": 2},
    "Load": {"time_profile": {"model": "Press", "begin": 0.3, "rise": 1}},
    "Motion": {"speed": 0.03, "time_profile": {"model": "Press", "begin": 0.3, "rise": 1}},
    "OneOfTwoInAntiphase": {"supply": 100, "start": 0.3, "stop": 1.2},
    "Press": {"begin": 0.02},
    "PulseTrain": {"low": -20, "edge": 2e-4},
    "RecordedFrictionCoefficient": RECORD | {"baseline": 0.4},
    "RecordedFrictionForce": RECORD | {"baseline": 0.2},
    "Sine": {"offset": 20, "phase": 0.4},
    "Square": {"edge": 2e-3},
    "SquareRootModulation": {"offset": 20},
    "Swipe": {"begin": 0.1},
    "TouchAndLift": {"begin": 0.1},
    "Trapezium": {"low": 100, "delay": 0.02, "repeat": 0.5},
}
"""Parameters besides the example with which a model is tried too, so that each has an effect."""
WITHOUT = {
    "a table, linear or held between its rows": "Corner Corners GreyscalePicture Held RecordedPath Sampled Tabulated"
    " TabulatedAttraction",
    "names columns of a record, or selects rows of it": "EvenSamples KeepIncreasing Refuse TimeColumn TribometerChannels",
    "states where results are evaluated": "FrequencyGrid TimeGrid",
    "states limits that results are compared with": "Limits",
    "holds other models, channels, layers or sensors": "Perception Scenario Stack Tribometer",
    "heights of a draw, or of a map": "MeasuredHeights SelfAffine",
    "the compliance of two bodies, in its notes": "Coated",
    "solved on a grid together with its attraction": "RoughContact",
    "states that the finger is off the plate; the distance is the thickness of the gap": "HeldOff",
}
"""Why models declare no equation."""


SOLUTIONS = {
    "Amplifier": {"output'"},
    "Closing": {"gap'"},
    "Creep": {"friction", "part.friction'"},
    "FirstOrderLag": {"friction'"},
    "Relaxation": {"friction'"},
}
"""Equations in time, which are compared with solutions in place of methods."""


def values_for(name, model, random):
    """Draw an argument: in its range if it has one, else of either sign over 18 decades.

    So wide, because a parameter that only matters at high fields has to be seen.
    """
    if name in DECADES:
        return 10 ** random.uniform(*DECADES[name], POINTS)
    if name in ("position", "velocity", "vectors"):
        return places_for(name, model, random)
    special = {
        "counts": lambda: np.cumsum(random.integers(-999, 1000, POINTS)).astype(float),
        "direction": lambda: random.choice([-1.0, 1.0], POINTS),
        "force": lambda: random.uniform(-3, 3, POINTS),
        "full_scale": lambda: random.uniform(1, 2, POINTS),
        "periods": lambda: random.uniform(-20, 20, POINTS),
        "plate": lambda: RenderingPlate(normal_force=0.5, largest_added_friction=0.1),
        "time": lambda: np.sort(random.uniform(0, 2 * span(model), POINTS)),
    }
    if isinstance(model, Readback):
        special["voltage"] = lambda: random.uniform(0, 100, POINTS)
    if name in special:
        return special[name]()
    return random.choice([-1, 1], POINTS) * 10 ** random.uniform(-9, 9, POINTS)


def places_for(name, model, random):
    """Draw vectors: places on a record, which is 0 beyond its ends; speeds about that at which a direction counts."""
    if name == "position" and isinstance(model, MeasuredTexture):
        along, across = random.uniform(0, model.length, POINTS), random.uniform(-1, 1, POINTS)
        turned = np.exp(1j * model.angle) * (along + 1j * across)
        return np.stack([turned.real, turned.imag], axis=-1)
    return random.uniform(-3, 3, (POINTS, 2)) * getattr(model, "slow", 0.01)


def span(model):
    """Return a time over which a model shows its whole course [s]."""
    if isinstance(model, Drive):
        return max(model.duration, model.period or 0)
    if isinstance(model, TimeProfile):
        return model.corners()[-1][0] or 1.0
    if isinstance(model, Separation):
        return max(model.breaks(), default=1.0)
    return getattr(model, "duration", 1.0)


def difference(name, model, equations, random):
    """Return the largest relative difference between an equation and the method of that name."""
    method = method_of(model, name)
    given = {argument: values_for(argument, model, random) for argument in arguments_of(method)}
    printed = np.asarray(Evaluation(model, given, equations).value(name))
    coded = np.asarray(method(**given))
    size = np.abs(printed)
    if ALONG & set(given):
        size = np.max(size)
    with np.errstate(divide="ignore"):
        worst = np.abs(coded - printed) / np.where(coded == printed, 1.0, size)
    assert coded.shape == np.broadcast_shapes(coded.shape, printed.shape)
    return float(np.max(worst)) if np.all(np.isfinite(coded)) else np.inf


def disagreement(kind, equations, near_example, *, seed=0):
    """Return the largest relative difference between equations and methods, over parameters and arguments."""
    random, found = np.random.default_rng(seed), []
    for more in ({}, {}, {}, *([MORE[kind.__name__]] * 3 if kind.__name__ in MORE else ())):
        model = near_example(kind, random, more)
        absent = {field for field, value in model if value is None}
        if is_whole_law(kind):
            found.append(of_whole_law(model, equations, random))
            continue
        for name in equations:
            if method_of(model, name) is None:
                continue
            try:
                found.append(difference(name, model, equations, random))
            except TypeError:
                # an equation needs an optional parameter, and holds where that is given
                assert absent & symbols(equations[name]), name
    assert found, "no example has the parameters that the equation needs"
    return max(found)


def is_whole_law(kind):
    """Tell whether the equations of a force law state its amplitudes too, down to the layers."""
    return issubclass(kind, ForceLaw) and "E" in kind.equation


def of_whole_law(model, equations, random):
    """Return the largest relative difference of a law from its equations, from voltage and layers to the pressure."""
    scenario = load("vezzoli_2014/fig6").replace(
        {"stack": several_layers(random), "force": model, "circuit.return_path.resistance": 3e4}
    )
    frequency = 10 ** random.uniform(1, 6, POINTS)
    section, layers = phasors(scenario, frequency), scenario.stack.layers
    given = {
        "voltage": section.voltage,
        "frequency": frequency,
        "D_insulator": section["coating"].displacement,
        "D_skin": section["outer"].displacement,
        "insulator": [layers["film"], layers["coating"]],
        "skin": [layers["outer"], layers["inner"]],
        "solids": [layer for name, layer in layers.items() if name != "gap"],
    }
    printed = Evaluation(model, given, equations).value("pressure")
    coded = model.pressure(**model.amplitudes(section))
    return float(np.max(np.abs(coded - printed) / np.abs(printed)))


def several_layers(random):
    """Return two films, air, and two layers of skin that relax and conduct."""

    def near(value):
        return value * 3 ** random.uniform(-1, 1)

    def skin(time):
        numbers = {
            "permittivity_high": 40.0,
            "strength": 900.0,
            "conductivity": 1e-5,
            "relaxation_time": time,
        }
        return {"model": "Debye"} | {name: near(value) for name, value in numbers.items()}

    def film(permittivity):
        return {"model": "Constant", "permittivity": near(permittivity)}

    return {
        "film": {"thickness": near(60e-6), "role": "plate", "material": film(3.35)},
        "coating": {"thickness": near(5e-6), "role": "plate", "material": film(12.0)},
        "gap": {"thickness": near(3e-6), "material": {"model": "Constant", "permittivity": 1.0}},
        "outer": {"thickness": near(60e-6), "role": "finger", "material": skin(1e-4)},
        "inner": {"thickness": near(90e-6), "role": "finger", "material": skin(3e-6)},
    }


def of_methods(kind):
    """Return the equations of a model without those that are compared with solutions."""
    solved = SOLUTIONS.get(kind.__name__, {})
    return {name: text for name, text in kind.equation.items() if name not in solved}


def test_equations_hold_and_every_equation_is_compared(final_class, near_example):
    """With a method, or with a solution, or as a quantity that a compared equation uses."""
    equations = of_methods(final_class)
    assert set(final_class.equation) - set(equations) == set(SOLUTIONS.get(final_class.__name__, ()))
    if equations:
        assert disagreement(final_class, equations, near_example) < AGREEMENT
        model = near_example(final_class, np.random.default_rng(0))
        methods = {name for name in equations if method_of(model, name)}
        used = set().union(*(symbols(text) for text in equations.values()))
        assert methods
        assert set(equations) - methods <= used


def test_changed_equations_are_refused(final_class, near_example):
    """A factor, or a parameter, argument, constant or intermediate quantity that is multiplied by 1.001, or by 2 beside cases."""
    equations = of_methods(final_class)
    for name, text in equations.items():
        # the place of a limit between two cases is seen by few of the points
        factor = 2 if any(" if " in other for other in equations.values()) else 1.001
        changes = {"factor": f"({text})*(1 + 1e-5)" if text != "0" else "1e-5"}
        if method_of(near_example(final_class, np.random.default_rng(0)), name) is None:
            changes = {}
        changes |= {symbol: twisted(text, symbol, factor) for symbol in symbols(text)}
        for what, changed in changes.items():
            off = disagreement(final_class, equations | {name: changed}, near_example)
            assert off > REFUSAL, (name, what)


def test_every_model_has_an_equation_or_a_reason_for_none():
    """Of the models that have a page; a new one declares its equation, or its reason is added to the table above."""
    models = {item.thing for item in everything(own=True) if isinstance(item.thing, type)}
    found = {model.__name__ for model in models if not model.equation and "bench" not in model.__module__}
    assert found == set(" ".join(WITHOUT.values()).split())


@pytest.fixture(scope="module")
def base():
    """A finger on a film, with a gap, under a sine."""
    changes = {
        "stack.gap": {"thickness": 20e-6, "material": {"model": "Constant", "permittivity": 1.0}},
        "drive": {"model": "Sine", "amplitude": 200, "offset": 50, "frequency": 50},
        "force.model": "MaxwellStressInGap",
        "load.normal_force": 0.02,
        "motion.speed": 0.05,
        "time": {"duration": 0.01, "samples": 126},
    }
    return load("vezzoli_2014/fig6_static").replace(changes)


def amplifier(base):
    scenario = base.replace({"circuit.amplifier": {"gain": 1.2, "bandwidth": 300}})
    trace = simulate(scenario)
    known = {"voltage": trace.drive_voltage, "output": trace.plate_voltage}
    return scenario.circuit.amplifier, known, {"output'": "output"}


def closing(base):
    surface = {"model": "LinearSpring", "stiffness": 1e8, "free_gap": 20e-6}
    scenario = base.replace({"contact.surface": surface, "contact.closing": {"damping": 2e5}})
    trace = simulate(scenario)
    known = {
        "gap": trace.gap,
        "repulsion": scenario.contact.surface.pressure(trace.gap.values),
        "load_pressure": 0.02 / scenario.contact.area,
        "attraction": VACUUM_PERMITTIVITY * trace.field.sel(layer="gap") ** 2 / 2,
    }
    return scenario.contact.closing, known, {"gap'": "gap"}


def followed(base, friction):
    """Return the friction law, its force and that of the steady law [N]."""
    steady = {"model": "Coulomb", "coefficient": 0.5}
    scenario = base.replace({"friction": friction | {"steady": steady}})
    force, slow = simulate(base.replace({"friction": steady})), simulate(scenario)
    return scenario.friction, slow.lateral_force, force.lateral_force


def first_order_lag(base):
    given = {"model": "FirstOrderLag", "cut_off": 100, "at_speed": 0.04, "renewal_length": 70e-6}
    law, friction, steady = followed(base, given)
    return law, {"friction": friction, "steady_friction": steady, "speed": 0.05}, {"friction'": "friction"}


PARTS = ({"share": 0.3, "time": 2e-3}, {"share": 0.2, "time": 9e-3})


def relaxation(base):
    law, friction, steady = followed(base, {"model": "Creep", "relaxations": [PARTS[0] | {"share": 1}]})
    return law.relaxations[0], {"friction": friction, "steady_friction": steady}, {"friction'": "friction"}


def creep(base):
    law, friction, steady = followed(base, {"model": "Creep", "relaxations": PARTS})
    alone = []
    for part in PARTS:
        slow = followed(base, {"model": "Creep", "relaxations": [part | {"share": 1}]})[1]
        alone.append(SimpleNamespace(friction=slow.values, **part))
    known = {"friction": friction, "steady_friction": steady, "relaxations": alone, "part": alone[0]}
    return law, known, {"friction": None, "part.friction'": "part.friction"}


@pytest.mark.parametrize("solved", [amplifier, closing, creep, first_order_lag, relaxation])
def test_equations_in_time_hold_for_solutions(base, solved):
    """And equations that are changed do not: the derivative is that of a polynomial through nine values."""
    model, known, states = solved(base)
    assert set(states) == SOLUTIONS[type(model).__name__]
    known = {name: getattr(value, "values", value) for name, value in known.items()}

    def off(name, equations):
        right = Evaluation(model, known, equations).value(name)
        state = Evaluation(model, known, {"state": states[name] or name}).value("state")
        left = state if states[name] is None else derivative(state, step=0.01 / 125)
        inside = slice(None) if states[name] is None else slice(4, -4)
        return np.max(np.abs(left - right[inside])) / np.max(np.abs(left))

    for name in states:
        text = model.equation[name]
        assert off(name, model.equation) < SOLVED, name
        for symbol in symbols(text):
            changed = {**model.equation, name: twisted(text, symbol, 1.01)}
            assert off(name, changed) > 30 * SOLVED, (name, symbol)


def derivative(values, *, step):
    """Return the rate of change at evenly spaced values, but for the first and the last four."""
    weights = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840
    return np.convolve(values, weights[::-1], "valid") / step
