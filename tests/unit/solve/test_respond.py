"""The solver follows from the models, says why, and refuses what does not go together."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.errors import InputError, NotCausalError
from electrovib.scenario import load
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

LEAK = {"model": "PolarityConduction", "conductivity_positive": 5e-6, "conductivity_negative": 2e-6}
LEAKY = {"stack.stratum_corneum.leak": LEAK, "stack.stratum_corneum.material.conductivity": 0.0}
CURRENT = {"drive": {"model": "CurrentSine", "amplitude": 1e-5, "frequency": 1e3}}
SETTLED = {"time.initial_state.model": "PeriodicState"}
SHORT = np.linspace(0, 5e-3, 51)


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6_gap")


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
def test_the_solver_and_its_reason_are_told(founding, changes, solver, words):
    trace = simulate(founding.replace(changes), time=SHORT)
    assert trace.attrs["solver"] == solver
    assert words in trace.attrs["solver_reason"]
    assert ("step_error" in trace.attrs) == (solver == "nonlinear branch")
    assert ("drive_current" in trace) == ("drive" in changes)
    assert all(np.all(np.isfinite(signal.values)) for signal in trace.data_vars.values())
    assert trace.attrs["transfer_error"] < 1e-12  # these layers are finite sums: nothing was reduced


def test_a_prescribed_current_is_the_current(founding):
    trace = simulate(founding.replace(CURRENT | {"circuit.return_path.resistance": 2e6}), time=SHORT)
    np.testing.assert_allclose(trace.current.values, trace.drive_current.values, rtol=1e-15)
    dropped = trace.drive_voltage.values - trace.stack_voltage.values
    np.testing.assert_allclose(dropped, 2e6 * trace.drive_current.values, rtol=0, atol=1e-12 * 20)
    assert trace["drive_current"].attrs["units"] == "A"
    diagnostics = {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}
    assert diagnostics["current drive"]["state"] == "unknown"
    assert "area" in diagnostics["current drive"]["text"]
    assert diagnostics["current"]["state"] == "ok"


def test_gains_are_per_volt_and_the_mean_force_is_of_the_drive(founding):
    current = founding.replace(CURRENT | {"stack.gap.material.conductivity": 0.0})
    trace = simulate(current, time=SHORT)
    volts = founding.replace({"stack.gap.material.conductivity": 0.0})
    voltage = simulate(volts, time=SHORT)
    for name in ("impedance", "field_gain", "permittivity"):
        np.testing.assert_array_equal(trace[name].values, voltage[name].values)
    angular = 2 * np.pi * trace.frequency.values
    expected = (1e-5) ** 2 / (4 * 8.8541878128e-12 * 1e-4 * angular**2)
    np.testing.assert_allclose(trace.mean_force.values, expected, rtol=1e-12)


def test_a_leak_counts_over_frequency_as_a_vanishing_sine_sees_it(founding):
    frequency = np.geomspace(1, 1e5, 7)
    leaky = phasors(founding.replace(LEAKY), frequency)
    plain = phasors(founding.replace({"stack.stratum_corneum.material.conductivity": 3.5e-6}), frequency)
    np.testing.assert_allclose(leaky["gap"].field, plain["gap"].field, rtol=1e-14)
    without = phasors(founding.replace(LEAKY), frequency, leaks=False)
    assert np.max(np.abs(without["stratum_corneum"].field / leaky["stratum_corneum"].field - 1)) > 0.1


def test_a_leak_has_no_periodic_state(founding):
    square = {"drive": {"model": "Square", "high": 10, "frequency": 60}}
    with pytest.raises(InputError, match="PeriodicState: layer 'stratum_corneum' leaks"):
        simulate(founding.replace(LEAKY | SETTLED | square))


def test_a_law_of_magnitudes_does_not_see_a_leak(founding):
    law = {"force.model": "Vezzoli2014PerFrequency"}
    with pytest.raises(NotCausalError):
        simulate(founding.replace(LEAKY | law))
    one_sine = {"drive": {"model": "Sine", "amplitude": 10, "frequency": 60}}
    with pytest.raises(InputError, match="PeriodicState"):
        simulate(founding.replace(LEAKY | law | SETTLED | one_sine))


def test_a_law_of_magnitudes_takes_a_current(founding):
    changes = {"force.model": "Vezzoli2014PerFrequency"} | CURRENT | SETTLED
    time = np.arange(64) / 64e3
    trace = simulate(founding.replace(changes), time=time)
    assert trace.attrs["solver"] == "one sine"
    place = np.array([1e3])
    expected = phasors(founding.replace(changes), place)
    law = founding.replace(changes).force
    amplitude = abs(law.amplitudes(expected)["E"][0]) * 1e-5
    assert trace.electrostatic_force.values.mean() == pytest.approx(
        8.8541878128e-12 * 1e-4 * amplitude**2 / 4, rel=1e-12
    )


@pytest.mark.parametrize("changes", [CURRENT, LEAKY], ids=["current", "leak"])
def test_laws_with_gaps_of_their_own_are_refused(changes):
    rough = {"force": {"model": "Persson2018RoughGap", "mean_gap": 1e-5, "rms_gap": 5e-6}}
    with pytest.raises(InputError, match="its gaps are no layers of the stack"):
        simulate(load("vezzoli_2014/fig6").replace(changes | rough), time=SHORT)
