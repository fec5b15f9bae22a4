"""A prescribed current: an attraction that knows neither gap nor insulator nor skin, only frequency and area."""

from __future__ import annotations

import numpy as np
import pytest
from harmonic_response import periodic
from hypothesis import given, settings
from hypothesis import strategies as st
from scenario_parts import EPS0, apart, largest, model, sine, square, trapezium
from scipy.integrate import solve_ivp

from electrovib.core.model import read_model
from electrovib.papers import kim_2015
from electrovib.physics.drive.base import Drive
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors

EXACT = 1e-9
"""Independence asked for; measured 3e-16."""
PHASES = 64


def one_period(frequency):
    return np.arange(PHASES) / PHASES / frequency


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


@given(ratio=st.floats(-1, 1).map(lambda power: 10.0**power))
def test_what_the_attraction_does_know(ratio):
    """The area; and under the voltage that pulls as much at 2 um the gap: 20 times less at 100 um."""
    current = kim_2015.mean_attraction("current")
    assert kim_2015.mean_attraction("current", {"contact.area": 1e-4 * ratio}) * ratio == pytest.approx(
        current, rel=1e-12
    )
    base = kim_2015.mean_attraction("voltage")
    assert base == pytest.approx(current, rel=1e-12)
    wide = kim_2015.mean_attraction("voltage", {"stack.gap.thickness": 100e-6})
    electrical = 90e-6 / 3.35 + 200e-6 / 1560
    assert wide / base == pytest.approx(((electrical + 2e-6) / (electrical + 100e-6)) ** 2, rel=1e-3)


def test_a_gap_that_leaks_pulls_less():
    """Current that goes through as conduction does not charge the gap: 1/(1 + (sigma/(w eps0))^2)."""
    sigma = 2e-6
    leaky = kim_2015.mean_attraction("current", {"stack.gap.material.conductivity": sigma})
    share = sigma / (2 * np.pi * 25e3 * EPS0)
    assert leaky == pytest.approx(kim_2015.mean_attraction("current") / (1 + share**2), rel=1e-12)
    assert share > 1


MODULATED = model("AmplitudeModulation", amplitude=1, carrier=3000, modulation=100, depth=0.8)
DRIVES = {
    "two sines": model("Sum", drives=[sine(1.0, 200), sine(0.5, 700, phase=1.0)]),
    "modulated": MODULATED,
    "square": square(1, 300, low=-1),
}


def controlled(command):
    return model("CurrentAmplifier", sense_resistance=1e4, command=command)


@pytest.mark.parametrize("name", DRIVES)
def test_the_periodic_state_is_the_sum_of_its_harmonics(name):
    """Integrators and relaxing layers in time, against impedances over frequency."""
    drive = controlled(DRIVES[name])
    scenario = kim_2015.scenarios()["current"].replace({"drive": drive})
    drive_model = read_model(Drive, drive)
    time = np.linspace(0, drive_model.period, 201)[:-1]
    trace = simulate(scenario, time=time)
    # harmonics of a square over (j w) fall as 1/n^2: 4096 of them leave 1e-4 of the peak
    bound = 3e-4 if name == "square" else 1e-11
    for layer in trace.layer.values:
        field = trace.field.sel(layer=layer).values

        def gain(frequency, layer=layer):
            return phasors(scenario, frequency)[layer].field

        assert apart(field, periodic(gain, drive_model, time, static=0.0)) < bound


CURRENTS = [
    model("CurrentSine", amplitude=1e-4, frequency=300, phase=0.7),
    controlled(trapezium(1, 1e-3, 2e-3, 1e-3)),
]


@pytest.mark.parametrize("drive", CURRENTS, ids=["sine", "trapezium"])
def test_from_rest_every_layer_obeys_its_own_equation(drive):
    """eps0 eps dE/dt + sigma E = I/A in each layer, by an adaptive integrator."""
    scenario = kim_2015.scenarios()["current"].replace({"drive": drive, "time.initial_state.model": "AtRest"})
    drive_model = read_model(Drive, drive)
    time = np.linspace(0, 6e-3, 61)
    trace = simulate(scenario, time=time)
    for name, layer in scenario.stack.layers.items():
        material = layer.material

        def rate(now, field, material=material):
            density = drive_model.voltage(now) / 1e-4 - material.conductivity * field
            return density / (EPS0 * material.permittivity)

        part = solve_ivp(rate, (0, 6e-3), [0.0], t_eval=time, rtol=1e-10, atol=1e-3, max_step=1e-5)
        found = trace.field.sel(layer=name).values
        assert apart(part.y[0], found) < 1e-7


def test_what_is_prescribed_and_what_results():
    scenario = kim_2015.scenarios()["current"].replace({"limits.current": "250 uA"})
    trace = simulate(scenario, time=one_period(25e3))
    section = phasors(scenario, np.array([25e3]))
    impedance = np.interp(25e3, trace.frequency.values, np.abs(trace.impedance.values))
    assert largest(trace.drive_current.values) == pytest.approx(np.sqrt(2) * 1e-3, rel=1e-12)
    volts = largest(trace.drive_voltage.values)
    assert volts == pytest.approx(impedance * np.sqrt(2) * 1e-3, rel=2e-2)
    assert volts > np.abs(section.voltage[0]) * np.sqrt(2) * 1e-3 * 0.99
    diagnostics = trace.attrs["validity"]
    assert "the force is proportional to 1/area" in diagnostics
    assert "above 250 uA" in diagnostics  # what Vezzoli et al. 2014's limiter allows


def test_the_modes_are_those_of_the_layers_alone():
    section, _ = modes(kim_2015.scenarios()["current"])
    skin = kim_2015.scenarios()["current"].stack.layers["stratum_corneum"].material
    rate = skin.conductivity / (EPS0 * skin.permittivity)
    assert section.modes.rates[section.modes.rates > 1e-20] == pytest.approx([rate], rel=1e-14)
