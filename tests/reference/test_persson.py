"""Rough gaps against a Monte Carlo of the same distribution, and the law in a stack against the formula."""

from __future__ import annotations

import math

import numpy as np
import pytest

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError
from electrovib.papers.persson_2018 import Persson2018RoughGap, scenarios
from electrovib.physics.roughness import GaussianGaps, IdleSpots, LeakingSpots, PullingSpots, mean_pull
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors

COATING, FILM = 0.378e-6, 27e-6
AREA, VOLTAGE = 1e-4, 100.0
OF_THE_LAW = 2e-4  # its average takes 32 gaps
CONDUCTING = {"model": "Constant", "permittivity": 1560.0, "conductivity": 2e-6}
DISPERSIVE = {
    "model": "Debye",
    "permittivity_high": 50.0,
    "strength": 1500.0,
    "relaxation_time": 1e-3,
    "conductivity": 2e-6,
}


def by_importance(electrical, gaps, *, seed, count=600_000):
    """Mean of 1/|u + h|^2, contact at u <= 0 counted as u = 0, and its standard error.

    A third of the samples is drawn as the gaps themselves, a third near contact as h/(u + h)^2, a third below 0.
    """
    random = np.random.default_rng(seed)
    height, tail = abs(electrical), gaps.rms / max(1.0, gaps.mean / gaps.rms)
    third = count // 3
    near = height * (1 / random.uniform(0.0, 1.0, third) - 1)
    drawn = np.concatenate(
        [random.normal(gaps.mean, gaps.rms, third), near, -random.exponential(tail, third)]
    )
    above = np.where(drawn > 0, height / (np.maximum(drawn, 0) + height) ** 2, 0.0)
    below = np.where(drawn <= 0, np.exp(np.minimum(drawn, 0) / tail) / tail, 0.0)
    normal = np.exp(-(((drawn - gaps.mean) / gaps.rms) ** 2) / 2) / (math.sqrt(2 * math.pi) * gaps.rms)
    values = normal / np.abs(np.maximum(drawn, 0) + electrical) ** 2 / ((normal + above + below) / 3)
    return float(np.mean(values)), float(np.std(values) / math.sqrt(len(values)))


@pytest.mark.parametrize("electrical", [COATING, FILM, COATING * (1 - 0.5j)])
@pytest.mark.parametrize("rms", [5e-6, 22e-6])
@pytest.mark.parametrize("in_rms", [1, 2, 3])
def test_average_against_importance_sampling(electrical, rms, in_rms):
    gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
    sampled, error = by_importance(electrical, gaps, seed=20180)
    assert error < 2.5e-3 * sampled  # four standard errors are within the 1 % asked for
    pull = mean_pull(VOLTAGE, electrical_thickness=electrical, gaps=gaps, spots=PullingSpots())
    expected = VACUUM_PERMITTIVITY * VOLTAGE**2 / 2 * sampled
    assert float(pull.total) == pytest.approx(expected, rel=1e-2)
    # it sees all lengths 6 % smaller, 13 % more pull, and on the coating a contact part that is left out
    smaller = mean_pull(
        VOLTAGE,
        electrical_thickness=0.94 * electrical,
        gaps=GaussianGaps(mean=gaps.mean * 0.94, rms=rms * 0.94),
        spots=PullingSpots(),
    )
    assert float(smaller.total) != pytest.approx(expected, rel=1e-2)
    if electrical == COATING:
        assert float(pull.gaps) != pytest.approx(expected, rel=1e-2)


def rough(changes=None, *, mean=10e-6, rms=5e-6, spots=None):
    force = {"model": "Persson2018RoughGap", "mean_gap": mean, "rms_gap": rms}
    force |= {"spots": spots} if spots else {}
    return scenarios()["coating"].replace({"force": force} | (changes or {}))


def electrical_thickness(scenario, frequency):
    layers = scenario.stack.layers.values()
    return sum(layer.thickness / layer.material.complex_permittivity(frequency) for layer in layers)


def formula(scenario, frequency, spots):
    """Mean force under a sine of 100 V, with complex permittivities."""
    gaps = GaussianGaps(mean=scenario.force.mean_gap, rms=scenario.force.rms_gap)
    thickness = electrical_thickness(scenario, frequency)
    return (
        AREA
        * mean_pull(
            VOLTAGE / math.sqrt(2),
            electrical_thickness=thickness,
            gaps=gaps,
            spots=spots,
            frequency=frequency,
        ).total
    )


@pytest.mark.parametrize("filling", [None, CONDUCTING, DISPERSIVE], ids=["plain", "conducting", "dispersive"])
@pytest.mark.parametrize("spots", [PullingSpots(), IdleSpots(), LeakingSpots(resistivity=3e7)], ids=repr)
def test_law_over_frequency_is_the_formula(filling, spots):
    changes = {"circuit.return_path.resistance": 0.0}
    changes |= {"stack.stratum_corneum.material": filling} if filling else {}
    scenario = rough(changes, spots=spots.to_dict())
    frequency = np.geomspace(1.0, 1e6, 19)
    force = mean_force(scenario, phasors(scenario, frequency), amplitude=VOLTAGE)
    np.testing.assert_allclose(force, formula(scenario, frequency, spots), rtol=OF_THE_LAW)


@pytest.mark.parametrize("mean", [0.0, 1e-6, 5e-6, 15e-6, 60e-6])
@pytest.mark.parametrize("rms", [0.3e-6, 5e-6, 22e-6])
def test_held_voltage_on_layers_that_insulate(mean, rms):
    scenario = rough({"drive": {"model": "Step", "level": VOLTAGE}}, mean=mean, rms=rms)
    force = simulate(scenario, time=np.array([0.0, 0.1])).electrostatic_force.values
    gaps = GaussianGaps(mean=mean, rms=rms)
    thickness = 1e-6 / 3.9 + 200e-6 / 1650
    pull = mean_pull(VOLTAGE, electrical_thickness=thickness, gaps=gaps, spots=PullingSpots())
    np.testing.assert_allclose(force[-1], AREA * pull.total, rtol=OF_THE_LAW)


def test_each_gap_is_a_stack_of_its_own():
    """Force of the law in time against a plain stack with a layer gap for each of its gaps."""
    drive = {"model": "Trapezium", "high": VOLTAGE, "rise": 2e-3, "hold": 2e-2, "fall": 2e-3}
    changes = {"drive": drive, "time": {"duration": 0.03}, "stack.stratum_corneum.material": DISPERSIVE}
    changes["circuit.return_path.resistance"] = 0.0
    scenario = rough(changes, spots={"model": "IdleSpots"})
    time = np.linspace(0, 0.03, 61)
    force = simulate(scenario, time=time).electrostatic_force.values
    law = scenario.force
    skin, film = scenario.stack.layers["stratum_corneum"], scenario.stack.layers["insulator"]
    places, shares = law.gaps().rule(film.thickness / 3.9, count=32, reach=5.5)
    total = np.zeros(len(time))
    for place, share in zip(places, shares, strict=True):
        tables = scenario.to_dict()
        tables["force"] = {"model": "MaxwellStressInGap"}
        tables["stack"] = {
            "insulator": film.to_dict(),
            "gap": {"thickness": max(place, 1e-10)},
            "stratum_corneum": skin.to_dict(),
        }
        alone = type(scenario).model_validate(tables)
        total += share * simulate(alone, time=time).electrostatic_force.values
    # the smallest gaps of the rule lie below the thinnest layer a stack may have
    np.testing.assert_allclose(force, total, rtol=0, atol=1e-4 * np.max(total))
    assert np.max(np.abs(force * 1.001 - total)) > 1e-4 * np.max(total)


def test_spots_that_leak_let_a_held_voltage_go():
    """A vanishing gap is a high pass of eps0 rho, whatever the layers; the rest keeps its force."""
    resistivity = 1e-3 / VACUUM_PERMITTIVITY  # 1 ms
    changes = {
        "drive": {"model": "Step", "level": VOLTAGE},
        "circuit.return_path.resistance": 0.0,
        "time.initial_state": {"model": "AtRest"},
    }
    time = np.array([0.0, 0.5e-3, 1e-3, 2e-3, 20e-3])

    def force(spots):
        return simulate(rough(changes, spots=spots), time=time).electrostatic_force.values

    leaking = force({"model": "LeakingSpots", "resistivity": resistivity})
    pulling, idle = force({"model": "PullingSpots"}), force({"model": "IdleSpots"})
    np.testing.assert_allclose(
        leaking - idle, (pulling - idle) * np.exp(-2 * time / 1e-3), rtol=1e-6, atol=1e-12
    )
    assert pulling[0] / idle[0] > 3


def test_a_gap_or_no_insulator_or_charge_is_refused():
    scenario = scenarios()["coating"]
    tables = scenario.to_dict()
    film, skin = tables["stack"].values()
    tables["stack"] = {"insulator": film, "gap": {"thickness": 1e-6}, "stratum_corneum": skin}
    with pytest.raises(InputError, match=r"stack\.gap: .*mean_gap and force\.rms_gap; omit the layer"):
        simulate(type(scenario).model_validate(tables))
    leaking = {
        "stack.insulator.material.conductivity": 1e-12,
        "stack.stratum_corneum.material.conductivity": 1e-6,
    }
    with pytest.raises(InputError, match="every layer conducts"):
        simulate(scenario.replace(leaking))
    with pytest.raises(InputError, match="initial_charge is not supported"):
        simulate(scenario.replace({"stack.insulator.initial_charge": 1e-6}))


def test_gaps_have_no_default():
    with pytest.raises(InputError) as caught:
        scenarios()["coating"].replace({"force": {"model": "Persson2018RoughGap"}})
    assert len(caught.value.problems) == 2
    assert "mean_gap" in str(caught.value)
    assert "rms_gap" in str(caught.value)


def test_roughness_is_spoken_of():
    law = Persson2018RoughGap(mean_gap=5e-6, rms_gap=5e-6)
    coating = law.diagnostics(scenarios()["coating"].stack.layers)
    film = law.diagnostics(
        scenarios()["coating"].replace({"stack.insulator.thickness": "90 um"}).stack.layers
    )
    assert {diagnostic.name: diagnostic.state for diagnostic in coating} == {
        "contact spots": "warning",
        "roughness wavelength": "unknown",
        "stack voltage": "unknown",
    }
    assert {diagnostic.name: diagnostic.state for diagnostic in film}["roughness wavelength"] == "warning"
    assert "565 um" in film[1].text
    assert {diagnostic.name: diagnostic.state for diagnostic in film}["contact spots"] == "ok"


def test_series_resistance_is_that_of_the_layers_alone():
    """The voltage is what the layers without a gap leave: the same share for every gap."""
    frequency = np.geomspace(1e3, 1e6, 7)
    with_body, without = (
        rough({"circuit.return_path.resistance": 1e4}),
        rough({"circuit.return_path.resistance": 0.0}),
    )
    share = np.abs(phasors(with_body, frequency).voltage) ** 2
    assert share[-1] < 0.01
    force = mean_force(with_body, phasors(with_body, frequency), amplitude=VOLTAGE)
    np.testing.assert_allclose(
        force, share * mean_force(without, phasors(without, frequency), amplitude=VOLTAGE), rtol=1e-12
    )
    section, _ = modes(with_body)
    exact = with_body.force.amplitudes(phasors(with_body, frequency))
    for name, transfer in with_body.force.amplitudes(section).items():
        np.testing.assert_allclose(transfer.at(frequency), exact[name], rtol=1e-9, err_msg=name)
