"""Johnsen-Rahbek: a leaky dielectric over a gap that leaks less, and what a blocking film makes of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from electrovib.papers import nakamura_2017 as nakamura
from electrovib.papers import shultz_2015 as shultz
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes

EPS0 = 8.8541878128e-12
EXACT = 1e-10
"""Of the larger end: measured below 1e-14."""


def powers(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


two_layers = {
    "thickness": powers(-7, -3),
    "permittivity": powers(0, 4),
    "resistivity": powers(1, 14),
    "gap": powers(-8, -4),
    "gap_resistivity": powers(1, 14),
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


@settings(max_examples=60)
@given(case=st.fixed_dictionaries(two_layers))
def test_the_gap_field_rises_iff_the_gap_resists_more(case):
    """rho_g > eps_d rho_d, from the scenario to the force."""
    margin = abs(np.log(case["gap_resistivity"] / (case["permittivity"] * case["resistivity"])))
    assume(margin > 1e-6)
    capacitance = (EPS0 * case["permittivity"] / case["thickness"], EPS0 / case["gap"])
    conductance = (
        1 / (case["resistivity"] * case["thickness"]), 1 / (case["gap_resistivity"] * case["gap"]),
    )  # fmt: skip
    tau = sum(capacitance) / sum(conductance)
    time = np.concatenate([[0.0], tau * np.geomspace(1e-2, 40, 15)])
    trace = simulate(stack_of("rise", case), time=time)
    across = trace.field.sel(layer="gap").values * case["gap"]
    first, last = 100 * capacitance[0] / sum(capacitance), 100 * conductance[0] / sum(conductance)
    expected = last + (first - last) * np.exp(-time / tau)
    assert np.max(np.abs(across - expected)) < EXACT * max(first, last)
    told = nakamura.rises(
        permittivity=case["permittivity"],
        resistivity=case["resistivity"],
        gap_resistivity=case["gap_resistivity"],
    )
    section, _ = modes(stack_of("rise", case))
    assert (section["gap"].field.gains.sum() > 0) == told
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


def test_the_published_example():
    """Two layers: 4544 Pa at first, 4919 or 3.3 Pa at last."""
    first, rising = nakamura.pressures("rise")
    again, falling = nakamura.pressures("fall")
    assert first == pytest.approx(4544, abs=0.5)
    assert again == pytest.approx(first, rel=1e-14)  # the beginning knows no resistivity
    assert rising == pytest.approx(4919, abs=0.5)
    assert falling == pytest.approx(3.3, abs=0.05)
    assert nakamura.time_constant("rise") == pytest.approx(8.5e-3, abs=0.05e-3)
    assert nakamura.time_constant("fall") == pytest.approx(0.22e-3, abs=0.005e-3)


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
    bound = trace.displacement.values
    order = list(trace.layer.values)
    gap, skin = order.index("gap"), order.index("stratum_corneum")
    left = bound[skin, 1] - bound[gap, 1]
    assert left == pytest.approx(nakamura.interface_charge(gap_resistivity=nakamura.RISING), rel=1e-12)
    assert bound[skin, 0] == pytest.approx(bound[gap, 0], rel=1e-12)  # none at first


def test_a_coating_that_leaks_holds_its_attraction():
    """Nearly all of a DC voltage across the gap, where an insulating coating lets it fade."""
    limit = shultz.gap_force(voltage=shultz.VOLTAGE, gap=shultz.GAP, area=shultz.AREA)
    leaky = shultz.settled_force("leaky")
    assert limit == pytest.approx(0.4919, abs=5e-5)
    assert leaky < limit
    assert leaky == pytest.approx(limit, rel=2e-4)
    assert shultz.settled_force("insulated") < 1e-12 * limit
    start = [
        float(simulate(scenario, time=np.array([0.0, 1e-6])).electrostatic_force[-1])
        for scenario in shultz.scenarios().values()
    ]
    assert start[0] == pytest.approx(start[1], rel=0.1)  # at first they pull alike


def test_the_leaky_coating_has_to_leak_more_than_the_gap():
    """A coating as resistive as the gap in all takes half of the voltage, and a quarter of the force is left."""
    series = shultz.GAP * shultz.GAP_RESISTIVITY
    tight = shultz.scenarios()["leaky"].replace({"stack.insulator.material.conductivity": 1e-6 / series})
    force = simulate(tight, time=np.array([0.0, 1e5])).electrostatic_force.values[-1]
    assert force == pytest.approx(shultz.settled_force("leaky") / 4, rel=1e-3)
