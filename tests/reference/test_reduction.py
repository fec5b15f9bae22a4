"""What reducing the shipped skins to 14 Debye terms costs, in permittivity and in what pulls the finger."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.physics.force import ForceLaw
from electrovib.solve.reduce import reduce_material
from electrovib.solve.simulate import modes, phasors, simulate

ALLOWED = 1e-3  # stated: below 0.1 % of eps_pol and of the transfer over 1 Hz to 1 MHz
FREQUENCY = np.geomspace(1, 1e6, 997)  # not the grid of the fit, nor of its own check
INSULATORS = {"film": (90e-6, 3.35), "coat": (1e-6, 3.9)}


def test_polarisation(skin):
    reduction = reduce_material(skin)
    error = np.max(np.abs(reduction.debye.permittivity(FREQUENCY) / skin.polarisation(FREQUENCY) - 1))
    assert error < ALLOWED
    assert error <= reduction.largest_error * 1.05 + 1e-14  # what is reported is what is found elsewhere
    assert len(reduction.debye.strengths) <= 14
    assert min(reduction.debye.strengths, default=0.0) >= 0


@pytest.mark.parametrize("insulator", INSULATORS)
def test_transfer(finger, skin, insulator):
    layers = {
        "insulator": finger.film(*INSULATORS[insulator]),
        "gap": finger.gap(1e-6, 1e-9),
        "stratum_corneum": {"thickness": 200e-6, "material": skin},
    }
    scenario = finger.build(drive={"model": "Constant", "level": 1}, stack=layers, resistance=1000)
    section, _ = modes(scenario)
    truth = phasors(scenario, FREQUENCY)
    for name, kind in find_members(ForceLaw).items():
        law = kind.model_validate(dict(kind.example))
        if not law.causal or set(getattr(kind, "replaces", ())) & set(layers):
            continue
        reduced, declared = law.amplitudes(section), law.amplitudes(truth)
        for quantity, exact in declared.items():
            error = np.max(np.abs(reduced[quantity].at(FREQUENCY) - exact)) / np.max(np.abs(exact))
            assert error < ALLOWED, (name, quantity)


def test_the_trace_tells_both_errors(finger, skin):
    layers = {"insulator": finger.film(), "stratum_corneum": {"thickness": 200e-6, "material": skin}}
    trace = simulate(
        finger.build(drive={"model": "Constant", "level": 1}, stack=layers, force="Vezzoli2014Causal")
    )
    assert trace.attrs["reduction_error"] == reduce_material(skin).largest_error
    assert 0 <= trace.attrs["transfer_error"] < ALLOWED


def test_fewer_terms_cost_more(finger):
    """The comparison sees a reduction that is too short."""
    from electrovib.papers.palmar_1995 import MEN, palmar

    skin = palmar(exponent=MEN, conductance=2e-6)
    coarse = reduce_material(skin, terms=7).debye
    assert np.max(np.abs(coarse.permittivity(FREQUENCY) / skin.polarisation(FREQUENCY) - 1)) > ALLOWED
