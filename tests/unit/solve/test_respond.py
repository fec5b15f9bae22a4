"""The solver follows from the models and says why; what does not go together is refused; values over frequency."""

import json

import numpy as np
import pytest

from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError, NotCausalError
from electrovib.scenario import load
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.over_frequency import over_frequency
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


FREQUENCY = np.geomspace(1.0, 1e5, 11)


def test_an_amplifier_multiplies_the_force_and_leaves_the_impedance():
    """A force of second degree rises with the square of the gain; the impedance is that seen by the plate."""
    gain, bandwidth = 3.0, 2e3
    loud = FOUNDING.replace({"circuit.amplifier": {"gain": gain, "bandwidth": bandwidth}})
    one, two = (over_frequency(each, phasors(each, FREQUENCY), amplitude=10.0) for each in (FOUNDING, loud))
    factor = gain / (1 + 1j * FREQUENCY / bandwidth)
    assert np.allclose(two["mean_force"][1], np.abs(factor) ** 2 * one["mean_force"][1], rtol=1e-12, atol=0)
    assert np.allclose(two["field_gain"][1], factor * one["field_gain"][1], rtol=1e-12, atol=0)
    assert np.array_equal(two["impedance"][1], one["impedance"][1])


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_a_second_contact_pulls_with_its_own_area(ratio):
    """Its field is larger by the ratio of the areas, its force smaller by it than the square: per first area 1 + ratio."""
    contact = {"model": "SecondElectrode", "area": FOUNDING.contact_area / ratio}
    both, given = FOUNDING.replace({"circuit.return_path": contact}), {"E": np.array([1e6, -2e6])}
    assert np.allclose(total_pull(both, given), (1 + ratio) * total_pull(FOUNDING, given), rtol=1e-13, atol=0)


def test_a_leak_counts_over_frequency_as_a_vanishing_sine_sees_it():
    found, without = (phasors(FOUNDING.replace(LEAKY), FREQUENCY, leaks=leaks) for leaks in (True, False))
    plain = phasors(FOUNDING.replace({"stack.stratum_corneum.material.conductivity": 3.5e-6}), FREQUENCY)
    np.testing.assert_allclose(found["gap"].field, plain["gap"].field, rtol=1e-14)
    assert np.max(np.abs(without["stratum_corneum"].field / found["stratum_corneum"].field - 1)) > 0.1


def of_film_and_gap(changes):
    film = {"thickness": 1e-5, "material": {"model": "Constant", "permittivity": 3.0}}
    gap = {"thickness": 2e-6, "material": {"model": "Constant", "permittivity": 1.0}}
    skin = load("vezzoli_2014/fig6").stack.to_dict()["stratum_corneum"]
    given = {
        "force.model": "MaxwellStressInGap",
        "stack": {"insulator": film, "gap": gap, "stratum_corneum": skin},
        "drive": {"model": "Sine", "amplitude": 1.0, "frequency": 30.0},
        "frequency": {"low": 30.0, "high": 3e3, "samples": 3},
    }
    return load("vezzoli_2014/fig6").replace(given | changes)


def said(trace):
    found = read_diagnostics(trace.attrs["validity"])
    return {each.name: each.text for each in found if each.name.startswith("over frequency")}


RECTIFIES = {"model": "PolarityConduction", "conductivity_positive": 6e-9, "conductivity_negative": 2e-9}
EVEN = {"model": "FieldConduction", "conductivity": 4e-9, "onset_field": 1e12}


@pytest.mark.parametrize(("leak", "ratio"), [(RECTIFIES, 1.62), (EVEN, 1.0)], ids=["rectifies", "even"])
def test_mean_force_of_a_leak_in_time_and_over_frequency(leak, ratio):
    """A rectifying gap behind a film charges: the mean of the late periods, by harmonic collocation 1.62 times as large."""
    trace = simulate(of_film_and_gap({"stack.gap.leak": leak}), time=np.linspace(0, 3 / 30, 301))
    late = np.trapezoid(trace.electrostatic_force.values[-101:], dx=0.01)
    assert late / trace.mean_force.values[0] == pytest.approx(ratio, rel=0.02)
    assert ("over frequency, gap" in said(trace)) == (leak is RECTIFIES)


@pytest.mark.parametrize(
    ("amplifier", "words"),
    [
        ({"gain": 3.0, "saturation": 2.5}, "reaches 3 V, above the saturation of 2.5 V"),
        ({"source_current": 1e-8, "stray_capacitance": 1e-10}, "above 10 nA, from 30 Hz on"),
        ({"saturation": 1.5, "source_current": 1.0}, None),
        ({"gain": 3.0, "bandwidth": 100.0}, None),
    ],
    ids=["saturates", "current", "within", "unlimited"],
)
def test_limits_of_an_amplifier_that_the_mean_force_leaves_out(amplifier, words):
    trace = simulate(of_film_and_gap({"circuit.amplifier": amplifier}), time=np.array([1e-3]))
    found = said(trace).get("over frequency, amplifier")
    assert found is None if words is None else words in found
