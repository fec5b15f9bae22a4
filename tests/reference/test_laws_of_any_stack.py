"""The laws of K and L on several layers a side, against formulas and circuits that share no code with them."""

import numpy as np
import pytest
from scenario_parts import AREA, EPS0, SETTLED, constant, debye, grounded, layer, model, sine, step
from scipy.linalg import expm

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors

VOLTAGE = 100.0
PLATE = {"film": (60e-6, 3.35), "coating": (5e-6, 12.0)}
FINGER = {"outer": (40e-6, 900.0, 2e-6), "inner": (160e-6, 1700.0, 5e-6)}
"""Thickness [m], permittivity, and conductivity [S/m] of the layers."""


def on(law, *, conducts=True, gap=0.0, drive=None, **more):
    stack = {name: layer(thick, constant(eps), role="plate") for name, (thick, eps) in PLATE.items()}
    stack |= {"gap": {"thickness": gap}} if gap else {}
    for name, (thick, eps, conductivity) in FINGER.items():
        stack[name] = layer(thick, constant(eps, conductivity * conducts), role="finger")
    changes = {
        "stack": stack,
        "force": {"model": law},
        "drive": drive or step(VOLTAGE),
        "circuit.return_path": grounded(),
        "contact.area": AREA,
    }
    return load("vezzoli_2014/fig6").replace(changes | more)


def sums():
    every = [*PLATE.values(), *(numbers[:2] for numbers in FINGER.values())]
    return sum(t / e for t, e in every), sum(t for t, _ in every)


@pytest.mark.parametrize("gap", [0.0, 3e-6])
def test_the_static_law_is_that_of_the_sums_over_plate_and_finger(gap):
    """A gap is no part of the effective medium."""
    electrical, length = sums()
    expected = EPS0 * AREA * VOLTAGE**2 / (2 * electrical * length)
    scenario = on("EffectiveMedium", conducts=False, gap=gap)
    trace = simulate(scenario, time=np.array([0.0, 1e-3]))
    np.testing.assert_allclose(trace.electrostatic_force.values, expected, rtol=1e-9)
    np.testing.assert_allclose(trace.mean_force.values, expected / 2, rtol=1e-9)


def lost_charge(time):
    """Effective voltage after a step, from the circuit of capacitors and conductances: v less Q_i/C_i."""
    film = 1 / sum(t / (EPS0 * e) for t, e in PLATE.values())
    capacitance = np.array([film, *(EPS0 * e / t for t, e, _ in FINGER.values())])
    conductance = np.array([0.0, *(s / t for t, _, s in FINGER.values())])
    voltages = VOLTAGE / capacitance / np.sum(1 / capacitance)
    # C dV/dt + G V = J in each layer, with the sum of V held
    flow = conductance / capacitance / np.sum(1 / capacitance)
    rate = (np.ones((3, 1)) * flow - np.diag(conductance)) / capacitance[:, None]
    found = np.array([expm(rate * each) @ voltages for each in time])
    lost = found[:, 0] * capacitance[0] - found[:, 1] * capacitance[1]
    return VOLTAGE - lost / film


def test_the_charge_lost_to_the_insulator_is_that_between_plate_and_finger():
    time = np.linspace(0.0, 30e-3, 13)
    trace = simulate(on("Vezzoli2014Causal"), time=time)
    effective = lost_charge(time)
    assert effective[-1] < 0.1 * effective[0]
    np.testing.assert_allclose(trace.effective_voltage.values, effective, atol=1e-9 * VOLTAGE)
    electrical, length = sums()
    force = EPS0 * AREA * effective**2 / (2 * electrical * length)
    np.testing.assert_allclose(trace.electrostatic_force.values, force, atol=1e-9 * force[0])


def test_the_law_per_frequency_takes_the_layers_of_a_side_in_series():
    scenario = on("Vezzoli2014PerFrequency", drive=sine(VOLTAGE, 50.0), **SETTLED)
    trace = simulate(scenario)
    angular = 2 * np.pi * trace.frequency.values
    film = 1 / sum(t / (EPS0 * e) for t, e in PLATE.values())
    skin = 1 / sum(1 / ((1j * angular * EPS0 * e + s) / t) for t, e, s in FINGER.values())
    imaginary = angular * film + skin.imag
    gain = 1j * imaginary / (skin.real + 1j * imaginary)
    np.testing.assert_allclose(trace.effective_voltage_gain.values, gain, atol=1e-12)
    electrical, length = sums()
    force = EPS0 * AREA * (VOLTAGE * np.abs(gain)) ** 2 / (4 * electrical * length)
    np.testing.assert_allclose(trace.mean_force.values, force, rtol=1e-9)


TERMS = [{"strength": 700.0, "relaxation_time": 3e-3}, {"strength": 80.0, "relaxation_time": 2e-6}]
DISPERSIVE = {
    "stack.outer.material": debye(40.0, 900.0, 1e-4, 1e-6),
    "stack.inner.material": model("Prony", permittivity_high=90.0, conductivity=3e-6, terms=TERMS),
}


@pytest.mark.parametrize("law", ["EffectiveMedium", "Vezzoli2014Causal"])
def test_the_root_of_several_dispersive_layers_is_the_same_in_time_and_over_frequency(law):
    """Modes against the formula with complex permittivities, written out here."""
    scenario = on(law, **DISPERSIVE)
    frequency = np.geomspace(1.0, 1e6, 41)
    given = {name: scenario.stack.layers[name] for name in [*PLATE, *FINGER]}
    bound = {name: one.material.bound_permittivity(frequency) for name, one in given.items()}
    root = np.sqrt(1 / sum(one.thickness / bound[name] for name, one in given.items()))
    drops = {name: one.impedance(frequency) for name, one in given.items()}
    lost = 0.0
    if law == "Vezzoli2014Causal":
        outer, film = given["outer"], sum(drops[name] for name in PLATE)
        lost = outer.material.conductivity * drops["outer"] / outer.thickness * film / sum(drops.values())
    expected = root * (1 - lost) / np.sqrt(sum(one.thickness for one in given.values()))
    for section in (phasors(scenario, frequency), modes(scenario)[0]):
        found = scenario.force.amplitudes(section)["E"]
        found = found.at(frequency) if hasattr(found, "at") else found
        np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("law", ["Vezzoli2014Causal", "Vezzoli2014PerFrequency"])
def test_a_dispersive_layer_of_the_plate_is_refused_by_its_own_name(law):
    more = {"stack.coating.material": debye(3.0, 1.0, 1e-3)} | SETTLED
    with pytest.raises(InputError, match=r"stack\.coating\.material = Debye: .* MaxwellStressInGap"):
        simulate(on(law, drive=sine(VOLTAGE, 50.0), **more))
    with pytest.raises(InputError, match=r"EffectiveMedium needs a layer 'stack.stratum_corneum'"):
        load("strong_1970/display").replace({"force": {"model": "EffectiveMedium"}})
