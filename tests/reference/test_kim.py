"""A prescribed current: an attraction that knows neither gap nor insulator nor skin, only frequency and area."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenario_parts import EPS0, largest

from electrovib.papers import kim_2015
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

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
    expected = 1e-3**2 / (2 * EPS0 * 1e-4 * (2 * np.pi * frequency) ** 2)
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
    current = kim_2015.attraction("current")
    assert kim_2015.attraction("current", {"contact.area": 1e-4 * ratio}) * ratio == pytest.approx(
        current, rel=1e-12
    )
    base = kim_2015.attraction("voltage")
    assert base == pytest.approx(current, rel=1e-12)
    wide = kim_2015.attraction("voltage", {"stack.gap.thickness": 100e-6})
    electrical = 90e-6 / 3.35 + 200e-6 / 1560
    assert wide / base == pytest.approx(((electrical + 2e-6) / (electrical + 100e-6)) ** 2, rel=1e-3)


def test_a_gap_that_leaks_pulls_less():
    """Current that goes through as conduction does not charge the gap: 1/(1 + (sigma/(w eps0))^2)."""
    sigma = 2e-6
    leaky = kim_2015.attraction("current", {"stack.gap.material.conductivity": sigma})
    share = sigma / (2 * np.pi * 25e3 * EPS0)
    assert leaky == pytest.approx(kim_2015.attraction("current") / (1 + share**2), rel=1e-12)
    assert share > 1


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
