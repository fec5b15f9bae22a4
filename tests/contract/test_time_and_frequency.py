"""Time domain = frequency domain for every causal law; a law that is not causal has no time domain."""

import numpy as np
import pytest

from electrovib.core.errors import NotCausalError
from electrovib.physics.stack import IMPLIED, ORDER
from electrovib.scenario import load
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

FREQUENCY, AMPLITUDE, SAMPLES = 125.0, 100.0, 64
EXACT = 1e-9
"""Relative: steady state and phasors go through different arithmetic, of poles and of impedances."""
CONDUCTING = {"conductivity": 2e-6}
SLOW, FAST = ({"strength": 900, "relaxation_time": 2e-3}, {"strength": 300, "relaxation_time": 2e-5})
BROAD = {"strength": 3e3, "relaxation_time": 1.6e-3, "broadening": 0.2}
PHASE = {"permittivity": 1560, "reference_frequency": 100, "exponent": 0.75}
FINGERS = {
    "plain": {"model": "Constant", "permittivity": 1560} | CONDUCTING,
    "blocking": {"model": "Constant", "permittivity": 1560},
    "Debye": {"model": "Debye", "permittivity_high": 50, **FAST} | CONDUCTING,
    "Prony": {"model": "Prony", "permittivity_high": 50, "terms": [SLOW, FAST]} | CONDUCTING,
    "ColeCole": {"model": "ColeCole", "permittivity_high": 4, "terms": [BROAD]} | CONDUCTING,
    "ConstantPhase": {"model": "ConstantPhase", **PHASE} | CONDUCTING,
}
EXACTLY_FINITE = {"plain", "blocking", "Debye", "Prony"}
OWN = {"role": "plate", "thickness": 10e-6, "material": {"model": "Constant", "permittivity": 2.5}}
"""A layer whose name only its law knows."""


def stack_for(law, base):
    """Layers of a scenario of Vezzoli et al. 2014, and what else the law needs, from the plate to the finger."""
    known = load(f"vezzoli_2014/{base}").stack.to_dict()
    if "gap" in law.needs:
        known.setdefault("gap", {"thickness": 1e-6})
    skin = known.pop("stratum_corneum")
    own = {name: OWN for name in law.needs if name not in {*ORDER, *IMPLIED}}
    gap = {name: known.pop(name) for name in ("gap",) if name in known}
    return {**known, **own, **gap, "stratum_corneum": skin}


def under_a_sine(law, skin, *, base="fig6_gap", **more):
    changes = {
        "force": {"model": law.__name__, **law.example},
        "drive": {"model": "Sine", "amplitude": AMPLITUDE, "frequency": FREQUENCY},
        "time.initial_state": {"model": "PeriodicState"},
    }
    if "gap" in getattr(law, "replaces", ()):  # a law with gaps of its own stands in a stack without one
        base = "fig6"
    changes |= {"stack": stack_for(law, base), "stack.stratum_corneum.material": FINGERS[skin]}
    return load(f"vezzoli_2014/{base}").replace(changes | more)


def one_period():
    return np.arange(SAMPLES) / SAMPLES / FREQUENCY


def stated_error(trace):
    """What the stated error of the law's amplitudes may do to a force of second degree in them."""
    return EXACT + 2 * trace.attrs["transfer_error"]


def waveform(scenario):
    """Attraction over one period from phasors alone."""
    amplitudes = scenario.force.amplitudes(phasors(scenario, np.array([FREQUENCY])))
    wave = -1j * AMPLITUDE * np.exp(2j * np.pi * FREQUENCY * one_period())
    given = {name: np.real(value[0] * wave) for name, value in amplitudes.items()}
    return scenario.contact.gross_area() * scenario.force.pressure(**given)


def from_phasors(scenario, frequency=FREQUENCY):
    return float(mean_force(scenario, phasors(scenario, np.array([frequency])), amplitude=AMPLITUDE)[0])


@pytest.mark.parametrize("filling", FINGERS)
def test_steady_force_under_a_sine(law_class, filling):
    if not law_class.causal:
        return
    scenario = under_a_sine(law_class, filling)
    trace = simulate(scenario, time=one_period())
    force, expected = trace.electrostatic_force.values, from_phasors(scenario)
    tolerance = EXACT if filling in EXACTLY_FINITE else stated_error(trace)
    assert tolerance < 0.02  # the error is stated against the value at each time, near its zero too
    assert expected > 0
    assert abs(force.mean() / expected - 1) < tolerance
    assert np.max(np.abs(force - waveform(scenario))) < tolerance * np.max(force)
    assert (trace.attrs["reduction_error"] == 0) == (filling in EXACTLY_FINITE)
    if filling == "Debye" and "gap" not in law_class.needs:  # nor does the stack have to have one
        scenario = under_a_sine(law_class, filling, base="fig6")
        force = simulate(scenario, time=one_period()).electrostatic_force.values
        assert np.max(np.abs(force - waveform(scenario))) < EXACT * np.max(force)


@pytest.mark.parametrize(
    "return_path",
    [
        {"model": "Floating", "capacitance": 150e-12, "leak": 1e9},
        {"model": "Grounded", "resistance": 1e6},
        {"model": "SecondElectrode", "area": 0.3e-4, "resistance": 2e3},
    ],
    ids=lambda path: path["model"],
)
def test_return_paths_agree_too(law_class, return_path):
    if not law_class.causal:
        return
    more = {"circuit": {"return_path": return_path, "source_resistance": 1e5}}
    scenario = under_a_sine(law_class, "plain", **more)
    force = simulate(scenario, time=one_period()).electrostatic_force.values
    assert abs(force.mean() / from_phasors(scenario) - 1) < EXACT


def test_the_comparison_can_fail(discovered):
    """A start from rest, or a frequency 1 % off, is not the steady state asked for."""
    scenario = under_a_sine(discovered["law_class"]["MaxwellStressInGap"], "plain")
    expected = from_phasors(scenario)
    at_rest = scenario.replace({"time.initial_state": {"model": "AtRest"}})
    from_rest = simulate(at_rest, time=one_period()).electrostatic_force.values.mean()
    assert abs(from_rest / expected - 1) > 100 * EXACT
    assert abs(from_phasors(scenario, 1.01 * FREQUENCY) / expected - 1) > 100 * EXACT


@pytest.mark.parametrize("state", ["PeriodicState", "AtRest"])
def test_laws_that_are_not_causal_refuse_edges(law_class, discovered, state):
    trapezium = {"model": "Trapezium", "high": 1000, "rise": 0.036, "hold": 0.1, "fall": 0.036, "repeat": 0.4}
    force = {"model": law_class.__name__, **law_class.example}
    changes = {"force": force, "drive": trapezium, "time.initial_state": {"model": state}}
    scenario = load("vezzoli_2014/fig6").replace({"stack": stack_for(law_class, "fig6")} | changes)
    if law_class.causal:
        assert law_class.instead == ""
        assert np.all(np.isfinite(simulate(scenario).electrostatic_force))
        return
    assert discovered["law_class"][law_class.instead].causal
    with pytest.raises(NotCausalError) as caught:
        simulate(scenario)
    assert all(word in str(caught.value) for word in (law_class.__name__, law_class.instead, "Trapezium"))
    simulate(scenario.replace({"force": {"model": law_class.instead}}))


def test_laws_that_are_not_causal_answer_one_sine(discovered):
    others = [law for law in discovered["law_class"].values() if not law.causal]
    assert 0 < len(others) < len(discovered["law_class"])
    for law in others:
        scenario = under_a_sine(law, "ConstantPhase", base="fig6")
        force = simulate(scenario, time=one_period()).electrostatic_force.values
        np.testing.assert_allclose(force, waveform(scenario), rtol=0, atol=EXACT * np.max(force))
        one = scenario.drive.to_dict()
        with pytest.raises(NotCausalError):
            simulate(scenario.replace({"drive": {"model": "Sum", "drives": [one, one | {"frequency": 250}]}}))
