"""Two and three leaky layers in series: the classic closed forms, and the law of Vezzoli et al. 2014 out of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes
from electrovib.solve.stack.modes import Slab, stack_modes

EPS0 = 8.8541878128e-12
PRECISION = 1e-10  # demanded; measured below 1e-14 of the larger of the two ends


def two_layers(*, dielectric, permittivity, resistivity, gap, gap_resistivity):
    """Give C and G per area of dielectric and gap."""
    return (
        (EPS0 * permittivity / dielectric, 1 / (resistivity * dielectric)),
        (EPS0 / gap, 1 / (gap_resistivity * gap)),
    )


def closed_form(layers, voltage, time):
    (C_d, G_d), (C_g, G_g) = layers
    first, last = voltage * C_d / (C_d + C_g), voltage * G_d / (G_d + G_g)
    return last + (first - last) * np.exp(-time * (G_d + G_g) / (C_d + C_g))


def two_layer_scenario(finger, case, voltage=100.0):
    material = {
        "model": "Constant",
        "permittivity": case["permittivity"],
        "conductivity": 1 / case["resistivity"],
    }
    layers = {
        "insulator": {"thickness": case["dielectric"], "material": material},
        "gap": finger.gap(case["gap"], 1 / case["gap_resistivity"]),
    }
    return finger.build(drive={"model": "Step", "level": voltage}, stack=layers)


SKIN = {"dielectric": 200e-6, "permittivity": 1650.0, "resistivity": 5.6e5, "gap": 3e-6}


@pytest.mark.parametrize(
    ("gap_resistivity", "tau", "before", "after"),
    [(1e12, 8.5e-3, 4544, 4919), (1e6, 0.22e-3, 4544, 3.3)],
    ids=["rising", "falling"],
)
def test_two_layers(finger, gap_resistivity, tau, before, after):
    """Closed form, and the pressures of the published example to their digits."""
    case = SKIN | {"gap_resistivity": gap_resistivity}
    scenario = two_layer_scenario(finger, case)
    time = np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 200)])
    trace = simulate(scenario, time=time)
    across = trace["field"].sel(layer="gap").values * 3e-6
    expected = closed_form(two_layers(**case), 100.0, time)
    assert np.max(np.abs(across - expected)) < PRECISION * np.max(expected)
    section, _ = modes(scenario)
    assert 1 / section.modes.rates == pytest.approx([tau], rel=0.01)  # two digits are printed
    pressure = trace["electrostatic_force"].values / finger.AREA
    assert pressure[0] == pytest.approx(before, rel=1.5e-4)
    assert pressure[-1] == pytest.approx(after, rel=1.5e-2 if after < 10 else 1.5e-4)


def exponents(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


@settings(max_examples=200, deadline=None)
@given(
    dielectric=exponents(-7, -3),
    permittivity=exponents(0, 4),
    resistivity=exponents(0, 15),
    gap=exponents(-8, -4),
    gap_resistivity=exponents(0, 15),
)
def test_gap_field_rises_iff_the_gap_resists_more(
    dielectric, permittivity, resistivity, gap, gap_resistivity
):
    assume(abs(np.log(gap_resistivity / (permittivity * resistivity))) > 1e-6)
    case = {
        "dielectric": dielectric, "permittivity": permittivity, "resistivity": resistivity, "gap": gap,
        "gap_resistivity": gap_resistivity,
    }  # fmt: skip
    slabs = [
        Slab(dielectric, DebyeSum(permittivity), 1 / resistivity),
        Slab(gap, DebyeSum(1.0), 1 / gap_resistivity),
    ]
    field = stack_modes(slabs, area=1e-4, element=SeriesElement()).fields[1]
    layers = two_layers(**case)
    (C_d, G_d), (C_g, G_g) = layers
    time = np.concatenate([[0.0], (C_d + C_g) / (G_d + G_g) * np.geomspace(1e-3, 30, 25)])
    across = gap * (field.direct - np.expm1(-np.outer(time, field.rates)) @ field.gains)
    expected = closed_form(layers, 1.0, time)
    assert np.max(np.abs(across - expected)) < PRECISION * np.max(expected)
    assert (field.gains.sum() > 0) == (gap_resistivity > permittivity * resistivity)


def three_layers(
    finger, *, gap, gap_resistivity=8.7e8, skin_resistivity=5.575e5, permittivity=1560.0, skin=200e-6
):
    layers = {
        "insulator": finger.film(),
        "gap": finger.gap(gap, 1 / gap_resistivity),
        "stratum_corneum": finger.skin(permittivity, 1 / skin_resistivity, skin),
    }
    return finger.build(drive={"model": "Step", "level": 1}, stack=layers)


def gap_decay(scenario):
    """Give time constant and share of the mode that holds most of the gap field's step response."""
    section, _ = modes(scenario)
    field = section["gap"].field
    shares = -field.gains / field.direct
    strongest = int(np.argmax(np.abs(shares)))
    return 1 / field.rates[strongest], shares[strongest]


@pytest.mark.parametrize(("gap", "printed"), [(0.1e-6, 7.77e-3), (1e-6, 8.03e-3), (5e-6, 9.17e-3)])
def test_blocking_film_decays_with_the_gap_not_with_the_skin(finger, gap, printed):
    tau, share = gap_decay(three_layers(finger, gap=gap))
    assert tau == pytest.approx(printed, abs=0.005e-3)  # printed with three digits
    assert share == pytest.approx(1, abs=0.025)  # the skin's mode has 2 % at 0.1 um and less above
    capacitances = EPS0 * 3.35 / 90e-6, EPS0 / gap
    closed = EPS0 * 8.7e8 * (1 + capacitances[0] / capacitances[1])
    assert tau == pytest.approx(closed, rel=5e-3)
    faster, _ = gap_decay(three_layers(finger, gap=gap, skin_resistivity=5.575e4))
    assert faster == pytest.approx(tau, rel=5e-3)  # rho_s ten times smaller
    slower, _ = gap_decay(three_layers(finger, gap=gap, gap_resistivity=8.7e7))
    assert slower == pytest.approx(tau / 10, rel=0.02)  # while rho_g is what decides


@pytest.mark.parametrize("gap", [0.1e-6, 1e-6, 5e-6])
def test_founding_law_comes_back_with_the_gaps_time_constant(finger, gap):
    """H_gap/H_gap(inf) tends to tau_gap s/(1 + tau_gap s) as C_i/C_s goes to 0, with a difference proportional to it."""
    tau = EPS0 * 8.7e8 * (1 + gap * 3.35 / 90e-6)
    s = 2j * np.pi * np.geomspace(0.1, 1e5, 121)
    law = tau * s / (1 + tau * s)
    errors = []
    for thinner in (1.0, 0.1, 0.01):
        section, _ = modes(three_layers(finger, gap=gap, skin=200e-6 * thinner))
        field = section["gap"].field
        errors.append(np.max(np.abs(field.at(s.imag / (2 * np.pi)) / field.direct - law)))
    assert errors[0] < 1.1 * (200e-6 / 1560) / (90e-6 / 3.35)  # C_i/C_s of the paper: 0.5 %
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.02)


def test_blocking_film_lets_the_field_of_any_leaky_gap_fade(finger):
    """Even where the two-layer criterion says rise: the film ends it."""
    scenario = three_layers(finger, gap=1e-6, gap_resistivity=1e13, skin_resistivity=5.575e5)
    section, _ = modes(scenario)
    field = section["gap"].field
    assert field.direct + field.gains.sum() == pytest.approx(0, abs=1e-15 * field.direct)
    step = field.direct - np.expm1(-np.outer(np.geomspace(1e-4, 1, 50), field.rates)) @ field.gains
    assert np.max(step) > field.direct * (1 + 1e-3)  # it rises first
