"""Derivatives of predictions, and the search without the unknowns in which they are linear."""

import inspect

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.discovery import find_members
from electrovib.core.signals import make_trace
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import SteadyFriction
from electrovib.recordings.fit.identifiability import Stall
from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.recordings.fit.prediction import STEP, Prediction
from electrovib.recordings.fit.problem import Separated, WeightedProblem
from electrovib.recordings.fit.result import parameter_table
from electrovib.solve.mechanics.lateral import BEHIND_FRICTION, INDEPENDENT, proportional_to_friction
from electrovib.view.fitted import fit_sentences

TIMES = np.linspace(0, 10e-3, 150)
FREE = (
    "friction.coefficient",
    "contact.area",
    "stack.stratum_corneum.thickness",
    "rig.lateral.natural_frequency",
    "rig.lateral.damping_ratio",
)
READING = "lateral_force_measured"
STEADY, RELAXATIONS = {"model": "Coulomb", "coefficient": 0.5}, [{"share": 0.2, "time": "4 ms"}]
CREEP = {"friction": {"model": "Creep", "steady": STEADY, "relaxations": RELAXATIONS}}
POWER = {"friction": {"model": "PowerLaw", "coefficient": 0.6, "at_force": 1.0, "exponent": -0.2}}
PIEZO = {"natural_frequency": "2 kHz", "damping_ratio": 0.02, "time_constant": "10 s"}
RIG = {
    "model": "Tribometer",
    "lateral": {"model": "LateralSensor", "natural_frequency": "400 Hz", "damping_ratio": 0.1},
    "normal": {"model": "PiezoSensor"} | PIEZO,
}
DIGITISER = {"sampling_rate": 1e4, "bits": 8, "normal_range": 2, "lateral_range": 2, "seed": 1}


def chain(**changes):
    """Return a pulse on three layers with friction, a fingertip and a sensor behind the attraction."""
    given = {
        "drive": {"model": "Trapezium", "high": "100 V", "rise": "100 us", "hold": "4 ms", "fall": "100 us"},
        "time": {"model": "TimeGrid", "duration": "10 ms"},
        "rig": RIG,
        "finger": {"model": "MassSpringDamper", "mass": 1.5e-4, "stiffness": 1e3, "damping": 0.1},
    }
    return ev.load("bau_2010/sine").replace(given | changes)


def recorded(scenario, names=(READING,), *, seed=1, times=TIMES, zero=0.0):
    """Return signals with 1 % of noise."""
    rows = ev.prepare(scenario, free=[]).signals({}, names=names, time=times)
    rng = np.random.default_rng(seed)
    noisy = {
        name: (("time",), zero + rows[name] + 0.01 * np.abs(rows[name]).max() * rng.normal(size=times.size))
        for name in names
    }
    return make_trace(noisy, {"time": times}, {})


def central(prediction, values, name):
    """Return the derivative by central differences of two steps, extrapolated to the fourth order."""
    size = abs(values[name]) or 1.0

    def difference(step):
        ends = [prediction(dict(values) | {name: values[name] + side * step * size}) for side in (1, -1)]
        return (ends[0] - ends[1]) / (2 * step * size)

    return (4 * difference(1e-3) - difference(2e-3)) / 3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "free", "names"),
    [
        ({}, FREE, (READING,)),
        ({}, FREE[:3], ("electrostatic_force", "current", "lateral_force", "skin_speed")),
        (CREEP, ("friction.steady.coefficient", "contact.area"), ("lateral_force", READING)),
        (POWER, (FREE[0], "friction.exponent", "load.normal_force"), ("lateral_force", "skin_displacement")),
        ({}, ("drive.high", "circuit.return_path.resistance", "finger.mass"), ("current", "skin_speed")),
    ],
)
def test_derivatives_are_those_of_central_differences(changes, free, names):
    scenario = chain(**changes)
    measured = MeasuredTrace(trace=recorded(scenario, names), offsets=names[:1])
    prediction = Prediction(scenario, [measured], free=free)
    values = {name: each.start for name, each in prediction.free.items()}
    for factor in (1.0, 0.8):
        point = {name: factor * value for name, value in values.items()}
        found = prediction.derivatives(point)
        for name, column in zip(point, found.T, strict=True):
            expected = central(prediction, point, name)
            start = 0
            for each in prediction.columns[0]:
                part = slice(start, start + each.x.size)
                start += each.x.size
                scale = np.abs(expected[part]).max()
                rounding = 1e-13 * np.abs(each.y).max() / (STEP * abs(point[name]) or STEP)
                assert np.abs(column[part] - expected[part]).max() <= 3e-5 * scale + rounding, name


def test_the_derivative_after_a_friction_coefficient_takes_no_difference(monkeypatch):
    scenario = chain()
    prediction = Prediction(scenario, [MeasuredTrace(trace=recorded(scenario))], free=FREE)
    values = {name: each.start for name, each in prediction.free.items()}
    found = prediction.derivatives(values, names=[FREE[0]])[:, 0]
    np.testing.assert_allclose(found, prediction(values | {FREE[0]: 1.0}), rtol=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        CREEP,
        POWER,
        {"rig": RIG | {"digitiser": DIGITISER}},
        {"drive": {"model": "Sine", "amplitude": "80 V", "frequency": "700 Hz"}},
    ],
    ids=str,
)
def test_signals_are_proportional_to_the_declared_parameter_or_independent_of_it(changes):
    scenario = chain(**changes)
    path = "friction.steady.coefficient" if "Creep" in str(changes) else "friction.coefficient"
    scaled = proportional_to_friction(scenario, path)
    assert scaled == (BEHIND_FRICTION if "rig" not in changes else frozenset())
    assert not proportional_to_friction(scenario, "contact.area")
    prepared, names = ev.prepare(scenario, free=[path]), sorted(BEHIND_FRICTION | INDEPENDENT - {"impedance"})
    absent = {"effective_voltage"} if "drive" in changes else {"effective_voltage", "capacitance"}
    names = [name for name in names if name not in absent]
    once, twice = (prepared.signals({path: value}, names=names, time=TIMES) for value in (0.4, 0.8))
    for name in names:
        if scaled:
            factor = 2.0 if name in scaled else 1.0
            np.testing.assert_allclose(twice[name], factor * once[name], rtol=1e-9)


@pytest.mark.parametrize(
    "kind", [each for each in find_members(SteadyFriction).values() if each.is_member], ids=str
)
def test_a_friction_has_the_declared_proportionality_and_linearity(kind):
    law = kind.model_validate(dict(kind.example))
    rng = np.random.default_rng(1)
    load, force, area = rng.uniform(0.1, 2, (3, 50))
    for name in law.proportional_to:
        doubled = law.replace({name: 2 * getattr(law, name)})
        np.testing.assert_allclose(
            doubled.lateral_force(load, force, area), 2 * law.lateral_force(load, force, area)
        )
    if law.is_linear:
        parts = law.lateral_force(load, 0 * force, area) + law.lateral_force(0 * load, force, area)
        np.testing.assert_allclose(law.lateral_force(load, force, area), parts)


@pytest.mark.parametrize(
    "law", [each for each in find_members(ForceLaw).values() if each.of_second_degree], ids=str
)
def test_a_law_of_second_degree_is_a_quadratic_form(law):
    pressure = law().pressure
    names = list(inspect.signature(pressure).parameters)
    rng = np.random.default_rng(1)
    one, other = rng.normal(size=(2, len(names), 20))

    def of(row):
        return pressure(**dict(zip(names, row, strict=True)))

    np.testing.assert_allclose(of(3.0 * one), 9 * of(one), atol=1e-30)
    np.testing.assert_allclose(of(one + other) + of(one - other), 2 * (of(one) + of(other)), atol=1e-25)


START = dict(zip(FREE, (0.6, 1.2e-4, 3e-4, 350.0, 0.15), strict=True))


def minimum(prediction, *, separated, monkeypatch):
    """Return the minimum of the weighted squares with or without separation."""
    noise = [0.01 * np.abs(each.y).max() for group in prediction.columns for each in group]
    with monkeypatch.context() as patched:
        if not separated:
            patched.setattr(Separated, "is_useful", property(lambda _: False))
        return WeightedProblem(prediction, noise).minimum(prediction.free, known=True)


@pytest.mark.parametrize("case", ["alone", "zero", "sessions", "with a force", "bound"])
def test_the_separated_search_has_the_minimum_and_covariance_of_the_joint_one(monkeypatch, case):
    scenario, free, varying = chain(), FREE, ()
    measured = [MeasuredTrace(trace=recorded(scenario), name="a")]
    if case == "zero":
        measured = [MeasuredTrace(trace=recorded(scenario, zero=0.05), offsets=(READING,))]
        free = FREE[:1] + FREE[3:]  # area, friction and zero together are not determined
    elif case == "sessions":
        other = scenario.replace({"friction.coefficient": 0.7})
        measured = [
            MeasuredTrace(trace=recorded(each, seed=seed), name=name, session=name)
            for seed, (name, each) in enumerate({"a": scenario, "b": other}.items())
        ]
        varying = FREE[:1]
    elif case == "with a force":
        measured = [MeasuredTrace(trace=recorded(scenario, (READING, "electrostatic_force")))]
    elif case == "bound":
        trace = recorded(scenario, (READING, "electrostatic_force"))
        trace[READING].values[:] *= -1  # a negative friction: the coefficient ends at 0
        measured, free = [MeasuredTrace(trace=trace)], FREE[:2]
    start = {name: START[name] for name in free}
    prediction = Prediction(scenario, measured, free=free, varying=varying, start=start)
    apart, joint = (minimum(prediction, separated=each, monkeypatch=monkeypatch) for each in (True, False))
    assert list(apart.values) == list(joint.values)
    assert apart.on_bound == joint.on_bound
    deviations = joint.standard_deviations
    for name, value in joint.values.items():
        assert apart.values[name] == pytest.approx(value, rel=1e-8, abs=1e-3 * deviations[name])
    assert apart.sum_of_squares == pytest.approx(joint.sum_of_squares, rel=1e-8)
    if case != "bound":
        np.testing.assert_allclose(apart.covariance, joint.covariance, rtol=3e-5)
        assert apart.evaluations <= joint.evaluations + 2  # it may end a step later


LINKED = {"5": FREE, "4": FREE[:2] + FREE[3:]}
"""Friction, contact area and the zero of the sensor together: the likelihood rises by 1e-6 a step for thousands of steps."""


def linked(names):
    """Return a scenario, its recording with a zero, and the settings of a fit that is ended after 3000 evaluations."""
    scenario, count = chain(), []
    measured = MeasuredTrace(trace=recorded(scenario, zero=0.05), offsets=(READING,))
    free = LINKED[names]
    settings = {
        "free": free,
        "start": {name: START[name] for name in free},
        "progress": lambda number, _: count.append(number) or len(count) > 3000,
    }
    return scenario, measured, settings, count


@pytest.mark.parametrize("names", ["4", pytest.param("5", marks=pytest.mark.slow)])
def test_a_search_along_an_undetermined_combination_is_ended_and_names_it(names):
    scenario, measured, settings, count = linked(names)
    found = fit_scenario(scenario, measured, **settings)
    assert found.estimate.stalled
    assert not found.estimate.converged
    assert found.estimate.evaluations <= len(count) < 300
    (worst,) = found.undetermined
    sign = np.sign(worst.exponents[FREE[0]])
    assert worst.exponents == pytest.approx({FREE[0]: sign, FREE[1]: -sign}, abs=0.05)
    near = {FREE[0]: FreeParameter(start=0.5, lower=0.499, upper=0.501)}
    joint = found.problem.minimum(found.problem.prediction.free | near, known=False)
    assert found.estimate.sum_of_squares < 1.001 * joint.sum_of_squares
    assert "further steps made" in " ".join(fit_sentences(found, ()))


@pytest.mark.slow
def test_the_table_of_an_undetermined_fit_takes_no_long_search():
    scenario, measured, settings, count = linked("5")
    rows = {row.name: row for row in parameter_table(fit_scenario(scenario, measured, **settings))}
    # 800 of them for the profile of the zero; 7,000 before it ended at an undetermined combination
    assert len(count) < 3000
    zero = f"recording: zero of {READING}"
    assert [rows[name].state for name in (*FREE[:2], zero)] == ["not", "not", "not"]
    assert rows[zero].note.startswith(f"a change of it is hidden by changes of {FREE[0]}, {FREE[1]}, which")
    for name, value, _ in scenario.parameters():
        if name in FREE:
            assert rows[name].lower < float(value) < rows[name].upper
    assert rows[zero].lower < 0.05 < rows[zero].upper
    # the limits that the declared ranges of the others leave: friction up to 100, and the same product
    assert rows[FREE[0]].upper == 100
    assert rows[FREE[1]].lower == pytest.approx(4.8e-7, rel=0.02)


def test_a_profile_keeps_linear_unknowns_within_their_bounds():
    """At a tenth of the smallest area that they allow, friction is at its bound and the zero the best for it."""
    scenario, measured, *_ = linked("4")
    prediction = Prediction(scenario, [measured], free=FREE[:2])
    prediction.free[FREE[0]] = FreeParameter(start=0.5, lower=0.0, upper=2.0)
    problem = WeightedProblem(prediction, [1.0])
    area, zero = 1e-6, f"recording: zero of {READING}"
    found = problem.rise(FREE[1], area, {FREE[0]: 0.5, zero: 0.0}, prediction.free)
    held = problem.residual({FREE[0]: 2.0, FREE[1]: area, zero: 0.0})
    separated = Separated(problem, prediction.free, {}, within_bounds=True)
    step = 1e-4 * area
    ends = [np.sum(separated.residual({FREE[1]: area + side * step}) ** 2) for side in (1, -1)]
    slope = 2 * separated.residual({FREE[1]: area}) @ separated.derivatives({FREE[1]: area})
    assert slope == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-3)
    assert found == pytest.approx(float(np.sum((held - held.mean()) ** 2)), rel=1e-9)


def test_a_stall_needs_an_undetermined_combination_and_no_gain():
    slopes = 1e3 * np.column_stack([np.linspace(1, 2, 50)] * 2)
    values = {"a": 1.0, "b": 2.0}

    def steps_until(squares, derivatives, variance=1.0):
        stall = Stall(variance)
        for number, each in enumerate(squares):
            residual = np.full(50, np.sqrt(each / 50))
            if stall.is_reached(values, residual, derivatives):
                return number
        return None

    flat, falling = np.full(80, 50.0), 50 - 2.4e-4 * np.arange(80)
    determined = 1e3 * np.column_stack([np.linspace(1, 2, 50), np.linspace(1, 2, 50) ** 2])
    assert steps_until(flat, slopes) == 50
    assert steps_until(flat, determined) is None
    assert steps_until(falling, slopes) is None  # 0.012 variances in 50 steps
    assert steps_until(falling, slopes, variance=2.0) == 50
    assert steps_until(falling, slopes, variance=None) is None
    assert steps_until(2e3 + falling, slopes, variance=None) == 50
    assert steps_until(np.append(60 - np.arange(10), flat), slopes) == 60
    # 0.1 standard deviations of the logarithm in the weakest combination: determined, with that variance
    weak = determined * np.array([1, 0]) + 0.0
    weak[:, 1] = 1.0 * np.sin(np.linspace(0, 30, 50))
    assert steps_until(flat, weak) is None
    assert steps_until(flat, weak, variance=1e4) == 50
