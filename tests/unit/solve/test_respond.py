"""The solver follows from the models, says why, and refuses what does not go together."""

import json

import numpy as np
import pytest

from electrovib.core.errors import InputError, NotCausalError
from electrovib.scenario import load
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

FOUNDING = load("vezzoli_2014/fig6_gap")
LEAK = {"model": "PolarityConduction", "conductivity_positive": 5e-6, "conductivity_negative": 2e-6}
LEAKY = {"stack.stratum_corneum.leak": LEAK, "stack.stratum_corneum.material.conductivity": 0.0}
CURRENT = {"drive": {"model": "CurrentSine", "amplitude": 1e-5, "frequency": 1e3}}
SETTLED = {"time.initial_state.model": "PeriodicState"}
LAW = {"force.model": "Vezzoli2014PerFrequency"}
SHORT = np.linspace(0, 5e-3, 51)


@pytest.mark.parametrize(
    ("changes", "solver", "words"),
    [
        ({}, "transient", "voltage drive"),
        (LEAKY, "nonlinear branch", "layer 'stratum_corneum' leaks by PolarityConduction"),
        (CURRENT, "current drive", "blocking layers integrate the current, from rest"),
        (CURRENT | SETTLED, "current drive", "from the periodic state, exact (harmonics of the drive: 1)"),
        (CURRENT | LEAKY, "nonlinear branch", "from rest"),
    ],
    ids=["voltage", "leak", "current", "settled current", "current with a leak"],
)
def test_the_solver_and_its_reason_are_told(changes, solver, words):
    trace = simulate(FOUNDING.replace(changes), time=SHORT)
    assert trace.attrs["solver"] == solver
    assert words in trace.attrs["solver_reason"]
    assert ("step_error" in trace.attrs) == (solver == "nonlinear branch")
    assert ("drive_current" in trace) == ("drive" in changes)
    assert all(np.all(np.isfinite(signal.values)) for signal in trace.data_vars.values())
    assert trace.attrs["transfer_error"] < 1e-12  # these layers are finite sums: nothing was reduced


def test_a_prescribed_current_is_the_current_and_gains_are_per_volt():
    """The mean force is that of the drive; its diagnostics say what is not known of it."""
    blocking = {"stack.gap.material.conductivity": 0.0}
    trace = simulate(
        FOUNDING.replace(CURRENT | blocking | {"circuit.return_path.resistance": 2e6}), time=SHORT
    )
    current = trace.drive_current.values
    np.testing.assert_allclose(trace.current.values, current, rtol=1e-15)
    dropped = trace.drive_voltage.values - trace.stack_voltage.values
    np.testing.assert_allclose(dropped, 2e6 * current, rtol=0, atol=1e-12 * 20)
    assert trace["drive_current"].attrs["units"] == "A"
    diagnostics = {each["name"]: each for each in json.loads(trace.attrs["validity"])}
    assert diagnostics["current drive"]["state"] == "unknown"
    assert "area" in diagnostics["current drive"]["text"]
    assert diagnostics["current"]["state"] == "ok"
    trace, voltage = (simulate(FOUNDING.replace(blocking | each), time=SHORT) for each in (CURRENT, {}))
    for name in ("impedance", "field_gain", "permittivity"):
        np.testing.assert_array_equal(trace[name].values, voltage[name].values)
    expected = (1e-5) ** 2 / (4 * 8.8541878128e-12 * 1e-4 * (2 * np.pi * trace.frequency.values) ** 2)
    np.testing.assert_allclose(trace.mean_force.values, expected, rtol=1e-12)


def test_a_law_of_magnitudes_takes_a_current():
    scenario = FOUNDING.replace(LAW | CURRENT | SETTLED)
    trace = simulate(scenario, time=np.arange(64) / 64e3)
    assert trace.attrs["solver"] == "one sine"
    amplitude = abs(scenario.force.amplitudes(phasors(scenario, np.array([1e3])))["E"][0]) * 1e-5
    expected = 8.8541878128e-12 * 1e-4 * amplitude**2 / 4
    assert trace.electrostatic_force.values.mean() == pytest.approx(expected, rel=1e-12)


SQUARE = {"drive": {"model": "Square", "high": 10, "frequency": 60}}
ONE_SINE = {"drive": {"model": "Sine", "amplitude": 10, "frequency": 60}}
ROUGH = {"force": {"model": "Persson2018RoughGap", "mean_gap": 1e-5, "rms_gap": 5e-6}}
NO_LAYERS = "its gaps are no layers of the stack"


@pytest.mark.parametrize(
    ("scenario", "changes", "error", "words"),
    [
        (FOUNDING, LEAKY | SETTLED | SQUARE, InputError, "PeriodicState: layer 'stratum_corneum' leaks"),
        (FOUNDING, LEAKY | LAW, NotCausalError, None),
        (FOUNDING, LEAKY | LAW | SETTLED | ONE_SINE, InputError, "PeriodicState"),
        (load("vezzoli_2014/fig6"), CURRENT | ROUGH, InputError, NO_LAYERS),
        (load("vezzoli_2014/fig6"), LEAKY | ROUGH, InputError, NO_LAYERS),
    ],
)
def test_a_leak_has_no_periodic_state_and_laws_of_magnitudes_or_gaps_do_not_see_it(
    scenario, changes, error, words
):
    with pytest.raises(error, match=words):
        simulate(scenario.replace(changes), time=SHORT)
