"""What reducing the shipped skins to Debye terms costs, in permittivity and in what pulls the finger."""

from __future__ import annotations

import numpy as np
import pytest
from scenario_parts import layer, step
from scipy.optimize import brentq

from electrovib.core.discovery import find_members
from electrovib.papers.palmar_1995 import MEN, palmar
from electrovib.physics.force import ForceLaw
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors, reduce_material, reductions
from electrovib.solve.stack.section import inverse_root_thickness

ALLOWED = 1e-3  # stated: below 0.1 % of eps_pol and of the transfer over 1 Hz to 1 MHz
FREQUENCY = np.geomspace(1, 1e6, 997)  # not the grid of the fit, nor of its own check
INSULATORS = {"film": (90e-6, 3.35), "coating": (1e-6, 3.9)}


def stack(finger, skin, insulator="film", *, gap=False, resistance=1000.0, **more):
    between = {"gap": finger.gap(1e-6, 1e-9)} if gap else {}
    layers = {
        "insulator": finger.film(*INSULATORS[insulator]),
        **between,
        "stratum_corneum": layer(200e-6, skin),
    }
    return finger.build(drive=step(1), stack=layers, resistance=resistance, **more)


def missed(debye, skin):
    return np.max(np.abs(debye.permittivity(FREQUENCY) / skin.bound_permittivity(FREQUENCY) - 1))


def test_polarisation(paper_skin):
    reduction = reduce_material(paper_skin)
    error = missed(reduction.debye, paper_skin)
    assert error < ALLOWED
    assert error <= reduction.largest_error * 1.05 + 1e-14  # what is reported is what is found elsewhere
    assert len(reduction.debye.strengths) <= 20  # three a decade and two
    assert min(reduction.debye.strengths, default=0.0) >= 0


def test_fewer_terms_cost_more():
    """The comparison sees a reduction that is too short."""
    skin = palmar(exponent=MEN, conductance=2e-6)
    assert missed(reduce_material(skin, terms=7).debye, skin) > ALLOWED


@pytest.mark.parametrize("insulator", INSULATORS)
def test_factors_of_the_founding_force_keep_clear_of_each_other(finger, paper_skin, insulator):
    """The product of K^(-1/2) and the voltage loses digits where two rates meet."""
    section, _ = modes(stack(finger, paper_skin, insulator))
    root = section.inverse_root_thickness(["insulator", "stratum_corneum"])
    residues = root.gains * root.rates / root.direct
    apart = np.abs(root.rates[:, None] - section.modes.rates) / residues[:, None]
    assert np.min(apart, initial=1.0) > 1e-2  # the digits lost are those of its inverse: two
    product, expected = root * section.voltage, root.at(FREQUENCY) * section.voltage.at(FREQUENCY)
    assert np.max(np.abs(product.at(FREQUENCY) - expected)) < 1e-12 * np.max(np.abs(expected))


def test_factors_with_a_rate_in_common_are_moved_apart(finger):
    """A source resistance that puts a rate of the stack exactly on a node of the expansion of K^(-1/2)."""
    skin = palmar(exponent=MEN, conductance=2e-6)

    def section(resistance):
        return modes(stack(finger, skin, "coating", resistance=resistance))[0]

    names = ["insulator", "stratum_corneum"]
    plain = inverse_root_thickness([(section(1e3)[n].thickness, section(1e3).debye[n]) for n in names])
    slow, fast = (section(resistance).modes.rates for resistance in (1e9, 1.0))
    crossing = np.argwhere((plain.rates[:, None] > slow) & (plain.rates[:, None] < fast))
    node, mode = crossing[len(crossing) // 2]  # this rate passes this node as the resistance changes
    power = brentq(lambda x: np.log(section(10.0**x).modes.rates[mode] / plain.rates[node]), 0, 9, xtol=1e-14)
    meeting = section(10.0**power)
    assert np.min(np.abs(plain.rates[:, None] / meeting.modes.rates - 1)) < 1e-12
    product = meeting.inverse_root_thickness(names) * meeting.voltage
    expected = plain.at(FREQUENCY) * meeting.voltage.at(FREQUENCY)
    assert np.max(np.abs(product.at(FREQUENCY) - expected)) < 1e-11 * np.max(np.abs(expected))


@pytest.mark.parametrize("insulator", INSULATORS)
def test_transfer(finger, paper_skin, insulator):
    scenario = stack(finger, paper_skin, insulator, gap=True)
    layers = scenario.stack.layers
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


def test_the_trace_tells_both_errors(finger, paper_skin):
    scenario = stack(finger, paper_skin, resistance=0.0, force="Vezzoli2014Causal")
    trace = simulate(scenario)
    assert trace.attrs["reduction_error"] == reductions(scenario)["stratum_corneum"].largest_error
    # of the value at each time, down to 1e-4 of the peak
    assert 0 <= trace.attrs["transfer_error"] < 10 * ALLOWED
