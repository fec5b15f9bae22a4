"""A prescribed current: an attraction that knows neither gap nor insulator nor skin, only frequency and area."""

from __future__ import annotations

import numpy as np
import pytest
from harmonic_response import periodic
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.model import read_model
from electrovib.papers import kim_2015
from electrovib.physics.drive.base import Drive
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors

EPS0 = 8.8541878128e-12
EXACT = 1e-9
"""Independence asked for; measured 3e-16."""
PHASES = 64


def one_period(frequency):
    return np.arange(PHASES) / PHASES / frequency


@pytest.mark.parametrize(
    ("current", "frequency", "force"),
    [(1e-3, 25e3, 22.89e-3), (1e-4, 1e3, 143.0e-3), (1e-3, 5e3, 572.2e-3)],
)
def test_the_three_numbers(current, frequency, force):
    """Over frequency, in time from the periodic state, and by the closed form."""
    changes = {"drive.amplitude": np.sqrt(2) * current, "drive.frequency": frequency}
    scenario = kim_2015.scenarios()["current"].replace(changes)
    mean = float(simulate(scenario, time=one_period(frequency)).electrostatic_force.mean())
    assert mean == pytest.approx(force, rel=5e-4)  # four digits
    assert kim_2015.mean_attraction("current", changes) == pytest.approx(mean, rel=1e-12)
    assert kim_2015.uniform_force(current=current, frequency=frequency) == pytest.approx(mean, rel=1e-12)
    field = kim_2015.gap_field(current=current, frequency=frequency)
    assert EPS0 * 1e-4 * field**2 / 2 == pytest.approx(mean, rel=1e-12)


exponents = {
    "stack.gap.thickness": (-7.0, -4.0),  # 0.1 to 100 um
    "stack.insulator.thickness": (-7.0, -3.0),
    "stack.insulator.material.permittivity": (0.0, 3.0),
    "stack.stratum_corneum.thickness": (-5.0, -3.0),
    "stack.stratum_corneum.material.conductivity": (-9.0, -3.0),
    "circuit.return_path.resistance": (0.0, 7.0),
    "circuit.source_resistance": (0.0, 7.0),
}
layers = st.fixed_dictionaries(
    {path: st.floats(*ends).map(lambda power: 10.0**power) for path, ends in exponents.items()}
)


@settings(max_examples=40)
@given(changes=layers, frequency=st.sampled_from([80.0, 1e3, 25e3]))
def test_the_attraction_is_that_of_any_other_finger(changes, frequency):
    scenario = kim_2015.scenarios()["current"].replace(changes | {"drive.frequency": frequency})
    expected = kim_2015.uniform_force(current=kim_2015.CURRENT, frequency=frequency)
    force = simulate(scenario, time=one_period(frequency)).electrostatic_force.values
    assert abs(force.mean() / expected - 1) < EXACT
    # its waveform too: the current leads the charge by a quarter
    wave = 2 * expected * np.cos(2 * np.pi * np.arange(PHASES) / PHASES) ** 2
    assert np.max(np.abs(force - wave)) < EXACT * expected
    over_frequency = mean_force(
        scenario, phasors(scenario, np.array([frequency])), amplitude=np.sqrt(2) * 1e-3
    )
    assert abs(over_frequency[0] / expected - 1) < EXACT


def test_a_voltage_does_know_the_gap():
    """The same finger under the voltage that pulls as much at 2 um: 20 times less at 100 um."""
    base = kim_2015.mean_attraction("voltage")
    assert base == pytest.approx(kim_2015.mean_attraction("current"), rel=1e-12)
    wide = kim_2015.mean_attraction("voltage", {"stack.gap.thickness": 100e-6})
    electrical = 90e-6 / 3.35 + 200e-6 / 1560
    assert wide / base == pytest.approx(((electrical + 2e-6) / (electrical + 100e-6)) ** 2, rel=1e-3)


@given(ratio=st.floats(-1, 1).map(lambda power: 10.0**power))
def test_the_attraction_does_know_the_area(ratio):
    force = kim_2015.mean_attraction("current", {"contact.area": 1e-4 * ratio})
    assert force * ratio == pytest.approx(kim_2015.mean_attraction("current"), rel=1e-12)


def test_a_gap_that_leaks_pulls_less():
    """Current that goes through as conduction does not charge the gap: 1/(1 + (sigma/(w eps0))^2)."""
    sigma = 2e-6
    leaky = kim_2015.mean_attraction("current", {"stack.gap.material.conductivity": sigma})
    share = sigma / (2 * np.pi * 25e3 * EPS0)
    assert leaky == pytest.approx(kim_2015.mean_attraction("current") / (1 + share**2), rel=1e-12)
    assert share > 1


DRIVES = {
    "two sines": {
        "model": "Sum",
        "drives": [
            {"model": "Sine", "amplitude": 1.0, "frequency": 200},
            {"model": "Sine", "amplitude": 0.5, "frequency": 700, "phase": 1.0},
        ],
    },
    "modulated": {
        "model": "AmplitudeModulation", "amplitude": 1, "carrier": 3000, "modulation": 100, "depth": 0.8,
    },
    "square": {"model": "Square", "high": 1, "low": -1, "frequency": 300},
}  # fmt: skip


@pytest.mark.parametrize("name", DRIVES)
def test_the_periodic_state_is_the_sum_of_its_harmonics(name):
    """Integrators and relaxing layers in time, against impedances over frequency."""
    drive = {"model": "CurrentAmplifier", "sense_resistance": 1e4, "command": DRIVES[name]}
    scenario = kim_2015.scenarios()["current"].replace({"drive": drive})
    model = read_model(Drive, drive)
    time = np.linspace(0, model.period, 201)[:-1]
    trace = simulate(scenario, time=time)
    # harmonics of a square over (j w) fall as 1/n^2: 4096 of them leave 1e-4 of the peak
    bound = 3e-4 if name == "square" else 1e-11
    for layer in trace.layer.values:
        field = trace.field.sel(layer=layer).values

        def gain(frequency, layer=layer):
            return phasors(scenario, frequency)[layer].field

        expected = periodic(gain, model, time, static=0.0)
        assert np.max(np.abs(field - expected)) < bound * np.max(np.abs(expected))


@pytest.mark.parametrize(
    "drive",
    [
        {"model": "CurrentSine", "amplitude": 1e-4, "frequency": 300, "phase": 0.7},
        {
            "model": "CurrentAmplifier",
            "sense_resistance": 1e4,
            "command": {"model": "Trapezium", "high": 1, "rise": 1e-3, "hold": 2e-3, "fall": 1e-3},
        },
    ],
    ids=["sine", "trapezium"],
)
def test_from_rest_every_layer_obeys_its_own_equation(drive):
    """eps0 eps dE/dt + sigma E = I/A in each layer, by an adaptive integrator."""
    from scipy.integrate import solve_ivp

    scenario = kim_2015.scenarios()["current"].replace({"drive": drive, "time.initial_state.model": "AtRest"})
    model = read_model(Drive, drive)
    time = np.linspace(0, 6e-3, 61)
    trace = simulate(scenario, time=time)
    for name, layer in scenario.stack.layers.items():
        material = layer.material

        def rate(now, field, material=material):
            density = model.voltage(now) / 1e-4 - material.conductivity * field
            return density / (EPS0 * material.permittivity)

        part = solve_ivp(rate, (0, 6e-3), [0.0], t_eval=time, rtol=1e-10, atol=1e-3, max_step=1e-5)
        found = trace.field.sel(layer=name).values
        assert np.max(np.abs(found - part.y[0])) < 1e-7 * np.max(np.abs(found))


def test_what_is_prescribed_and_what_results():
    scenario = kim_2015.scenarios()["current"].replace({"limits.current": "250 uA"})
    trace = simulate(scenario, time=one_period(25e3))
    section = phasors(scenario, np.array([25e3]))
    impedance = np.interp(25e3, trace.frequency.values, np.abs(trace.impedance.values))
    assert np.max(np.abs(trace.drive_current.values)) == pytest.approx(np.sqrt(2) * 1e-3, rel=1e-12)
    largest = np.max(np.abs(trace.drive_voltage.values))
    assert largest == pytest.approx(impedance * np.sqrt(2) * 1e-3, rel=2e-2)
    assert largest > np.abs(section.voltage[0]) * np.sqrt(2) * 1e-3 * 0.99
    diagnostics = trace.attrs["validity"]
    assert "the force is proportional to 1/area" in diagnostics
    assert "above 250 uA" in diagnostics  # what Vezzoli et al. 2014's limiter allows


def test_the_modes_are_those_of_the_layers_alone():
    section, _ = modes(kim_2015.scenarios()["current"])
    skin = kim_2015.scenarios()["current"].stack.layers["stratum_corneum"].material
    rate = skin.conductivity / (EPS0 * skin.permittivity)
    assert section.modes.rates[section.modes.rates > 1e-20] == pytest.approx([rate], rel=1e-14)


def test_a_wrong_current_is_noticed():
    wrong = kim_2015.mean_attraction("current", {"drive.amplitude": 1.001 * np.sqrt(2) * 1e-3})
    assert abs(wrong / kim_2015.mean_attraction("current") - 1) > 1e-3
    assert all(not check.accepts(check.expect * (1 + 3 * check.rtol)) for check in kim_2015.CHECKS)
