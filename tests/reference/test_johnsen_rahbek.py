"""Leaky layers in series and bridges in parallel: the classic closed forms, Johnsen and Rahbek's rise, and what ends it.

The published pressures and time constants are checks of nakamura_2017 and shultz_2015, which tests/contract runs.
"""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenario_parts import AREA, EPS0, apart, constant, grounded, layer, model, powers, step

from electrovib.papers import nakamura_2017 as nakamura
from electrovib.papers import shultz_2015 as shultz
from electrovib.physics.material.bridged_air import BridgedAir
from electrovib.scenario import Scenario
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes

EXACT = 1e-10
"""Of the larger end: measured below 1e-14."""


two_layers = {
    "thickness": powers(-7, -3),
    "permittivity": powers(0, 4),
    "resistivity": powers(0, 15),
    "gap": powers(-8, -4),
    "gap_resistivity": powers(0, 15),
}


def stack_of(name, case):
    changes = {
        "stack.gap.thickness": case["gap"],
        "stack.gap.material.conductivity": 1 / case["gap_resistivity"],
        "stack.stratum_corneum.thickness": case["thickness"],
        "stack.stratum_corneum.material.permittivity": case["permittivity"],
        "stack.stratum_corneum.material.conductivity": 1 / case["resistivity"],
    }
    return nakamura.scenarios()[name].replace(changes)


@settings(max_examples=100)
@given(case=st.fixed_dictionaries(two_layers))
def test_the_gap_field_rises_iff_the_gap_resists_more(case):
    """rho_g > eps_d rho_d, from the scenario to the force."""
    told = case["gap_resistivity"] > case["permittivity"] * case["resistivity"]
    assume(abs(np.log(case["gap_resistivity"] / (case["permittivity"] * case["resistivity"]))) > 1e-6)
    capacitance = (EPS0 * case["permittivity"] / case["thickness"], EPS0 / case["gap"])
    conductance = (1 / case["resistivity"] / case["thickness"], 1 / case["gap_resistivity"] / case["gap"])
    tau = sum(capacitance) / sum(conductance)
    time = np.concatenate([[0.0], tau * np.geomspace(1e-3, 40, 20)])
    scenario = stack_of("rise", case)
    trace = simulate(scenario, time=time)
    across = trace.field.sel(layer="gap").values * case["gap"]
    first, last = 100 * capacitance[0] / sum(capacitance), 100 * conductance[0] / sum(conductance)
    expected = last + (first - last) * np.exp(-time / tau)
    assert apart(across, expected) < EXACT
    resistivities = {name: case[name] for name in ("permittivity", "resistivity", "gap_resistivity")}
    assert nakamura.rises(**resistivities) == told
    assert (modes(scenario)[0]["gap"].field.gains.sum() > 0) == told
    force = trace.electrostatic_force.values
    if abs(last - first) > 1e-6 * max(first, last):
        assert (force[-1] > force[0]) == told
        assert np.all(np.diff(force) * (1 if told else -1) >= -1e-12 * np.max(force))


@settings(max_examples=40)
@given(case=st.fixed_dictionaries(two_layers | {"film": powers(-7, -3)}))
def test_a_blocking_film_always_ends_it(case):
    """With the film of Vezzoli et al. 2014 the gap's field ends at 0, whatever the criterion."""
    scenario = stack_of("blocked", case).replace({"stack.insulator.thickness": case["film"]})
    section, _ = modes(scenario)
    field = section["gap"].field
    static = field.direct + field.gains.sum()
    assert abs(static) < 1e-12 * (abs(field.direct) + np.max(np.abs(field.gains)))
    slowest = 1 / np.min(section.modes.rates[: section.modes.driven])
    force = simulate(scenario, time=np.array([0.0, 50 * slowest])).electrostatic_force.values
    assert force[1] < 1e-9 * max(force[0], 1e-300) or force[1] < 1e-30


def test_a_blocked_rise_rises_first():
    """As the skin conducts it leaves its share, 0.4 %, to film and gap; then the gap loses all of it."""
    time = np.concatenate([np.linspace(0, 50e-3, 101), [50.0]])
    force = simulate(nakamura.scenarios()["blocked"], time=time).electrostatic_force.values
    assert 1.003 < np.max(force) / force[0] < 1.01
    assert force[-1] < 1e-3 * force[0]


def test_charge_that_is_not_neutralised_changes_the_response():
    """A second voltage finds the charge of the first: nothing is left of the rise."""
    first, last = nakamura.pressures("charged")
    assert first == pytest.approx(nakamura.pressures("rise")[1], rel=1e-12)
    assert last == pytest.approx(first, rel=1e-12)
    neutralised = nakamura.scenarios()["charged"].replace({"stack.gap.initial_charge": 0.0})
    time = np.linspace(0, 0.05, 11)
    force = simulate(neutralised, time=time).electrostatic_force.values
    again = simulate(nakamura.scenarios()["rise"], time=time).electrostatic_force.values
    np.testing.assert_array_equal(force, again)


def test_the_charge_between_the_layers_is_what_one_conducts_more():
    trace = simulate(nakamura.scenarios()["rise"], time=np.array([0.0, 10.0]))
    gap, skin = (trace.displacement.sel(layer=name).values for name in ("gap", "stratum_corneum"))
    charge = nakamura.interface_charge(gap_resistivity=nakamura.RISING)
    assert skin[1] - gap[1] == pytest.approx(charge, rel=1e-12)
    assert skin[0] == pytest.approx(gap[0], rel=1e-12)  # none at first


def test_a_coating_that_leaks_holds_its_attraction():
    """Nearly all of a DC voltage across the gap, where an insulating coating lets it fade."""
    limit = shultz.gap_force(voltage=100.0, gap=3e-6, area=1e-4)
    assert (1 - 2e-4) * limit < shultz.settled_force("leaky") < limit
    assert shultz.settled_force("insulated") < 1e-12 * limit
    early = np.array([0.0, 1e-6])
    start = [
        float(simulate(each, time=early).electrostatic_force[-1]) for each in shultz.scenarios().values()
    ]
    assert start[0] == pytest.approx(start[1], rel=0.1)  # at first they pull alike
    # a coating as resistive as the gap in all takes half of the voltage, and a quarter of the force is left
    series = 3e-6 * 1e12  # the gap leaks less than the coating
    tight = shultz.scenarios()["leaky"].replace({"stack.insulator.material.conductivity": 1e-6 / series})
    force = simulate(tight, time=np.array([0.0, 1e5])).electrostatic_force.values[-1]
    assert force == pytest.approx(shultz.settled_force("leaky") / 4, rel=1e-3)


# ------------------------------------------------------------------ three layers


def three_layers(finger, *, gap, gap_resistivity=8.7e8, skin_resistivity=5.575e5, skin=200e-6):
    layers = {
        "insulator": finger.film(),
        "gap": finger.gap(gap, 1 / gap_resistivity),
        "stratum_corneum": finger.skin(1560.0, 1 / skin_resistivity, skin),
    }
    return modes(finger.build(drive=step(1), stack=layers))[0]["gap"].field


def gap_decay(field):
    """Give time constant and share of the mode that holds most of the gap field's step response."""
    shares = -field.gains / field.direct
    strongest = int(np.argmax(np.abs(shares)))
    return 1 / field.rates[strongest], shares[strongest]


@pytest.mark.parametrize(("gap", "printed"), [(0.1e-6, 7.77e-3), (1e-6, 8.03e-3), (5e-6, 9.17e-3)])
def test_blocking_film_decays_with_the_gap_not_with_the_skin(finger, gap, printed):
    tau, share = gap_decay(three_layers(finger, gap=gap))
    assert tau == pytest.approx(printed, abs=0.005e-3)  # printed with three digits
    assert share == pytest.approx(1, abs=0.025)  # the skin's mode has 2 % at 0.1 um and less above
    assert tau == pytest.approx(EPS0 * 8.7e8 * (1 + gap * 3.35 / 90e-6), rel=5e-3)
    faster, _ = gap_decay(three_layers(finger, gap=gap, skin_resistivity=5.575e4))
    assert faster == pytest.approx(tau, rel=5e-3)  # rho_s ten times smaller
    slower, _ = gap_decay(three_layers(finger, gap=gap, gap_resistivity=8.7e7))
    assert slower == pytest.approx(tau / 10, rel=0.02)  # while rho_g is what decides


@pytest.mark.parametrize("gap", [0.1e-6, 1e-6, 5e-6])
def test_founding_law_comes_back_with_the_gaps_time_constant(finger, gap):
    """H_gap/H_gap(inf) tends to tau_gap s/(1 + tau_gap s) as C_i/C_s goes to 0, with a difference proportional to it."""
    tau = EPS0 * 8.7e8 * (1 + gap * 3.35 / 90e-6)
    frequency = np.geomspace(0.1, 1e5, 121)
    law = 2j * np.pi * frequency * tau / (1 + 2j * np.pi * frequency * tau)
    fields = [three_layers(finger, gap=gap, skin=200e-6 * thinner) for thinner in (1.0, 0.1, 0.01)]
    errors = [np.max(np.abs(field.at(frequency) / field.direct - law)) for field in fields]
    assert errors[0] < 1.1 * (200e-6 / 1560) / (90e-6 / 3.35)  # C_i/C_s of the paper: 0.5 %
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.02)


# ------------------------------------------------------------------ a gap bridged in places


VOLTAGE = 300.0
FILM, FILM_PERMITTIVITY, GAP = 90e-6, 3.35, 5e-6
CASES = [(1e-3, 1e-6), (0.05, 2e-8), (0.4, 1e-7)]
"""Share of the area that is bridged, and conductivity of the bridges; those that insulate take their share only."""


def bridged(share, conductivity, **changes):
    material = model("BridgedAir", bridged_share=share, spot_conductivity=conductivity)
    content = dict(Scenario.example) | {
        "drive": step(VOLTAGE),
        "contact": model("FixedArea", area=AREA),
        "circuit": {"return_path": grounded()},
        "stack": {"insulator": layer(FILM, constant(FILM_PERMITTIVITY)), "gap": layer(GAP, material)},
    }
    return Scenario.model_validate(content).replace(changes)


def closed_form(share, conductivity, time):
    """Charge on the open part's capacitor beside the bridges, in series with the film; the pull on the open part."""
    film, air = EPS0 * FILM_PERMITTIVITY / FILM, EPS0 / GAP * (1 - share)
    bridge = share * conductivity / GAP
    voltage = VOLTAGE * film / (film + air) * np.exp(-time * bridge / (film + air))
    return (1 - share) * AREA * EPS0 * (voltage / GAP) ** 2 / 2


@pytest.mark.parametrize(("share", "conductivity"), CASES)
def test_force_decays_through_the_bridges(share, conductivity):
    film, air = EPS0 * FILM_PERMITTIVITY / FILM, EPS0 / GAP * (1 - share)
    decay = (film + air) / (share * conductivity / GAP)
    trace = simulate(bridged(share, conductivity, **{"time.duration": 4 * decay, "time.samples": 401}))
    expected = closed_form(share, conductivity, trace.time.values)
    np.testing.assert_allclose(trace.electrostatic_force, expected, rtol=1e-10, atol=1e-12 * expected[0])
    insulated = simulate(bridged(share, 0.0))
    expected = closed_form(share, 0.0, insulated.time.values)
    np.testing.assert_allclose(insulated.electrostatic_force, expected, rtol=1e-12)
    # by whichever of the two the share is left out, it shows
    assert abs(expected[0] / (1 - share) / float(trace.electrostatic_force[0]) - 1) > 0.9 * share


def test_a_leak_on_bridges_is_kept():
    air = BridgedAir(bridged_share=0.1, spot_conductivity=1e-6)
    more = air.conducting(3e-7)
    assert air.conductivity == pytest.approx(1e-7, rel=1e-15)
    assert more.conductivity == pytest.approx(3e-7, rel=1e-15)
    assert more.pulling_share == air.pulling_share == 0.9
