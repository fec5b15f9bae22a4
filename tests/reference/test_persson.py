"""The law of rough gaps in a stack against the formula, and against stacks with one gap each.

The average itself is compared with panels in tests/unit/physics/test_roughness.
"""

import math

import numpy as np
import pytest
from scenario_parts import AREA, constant, debye, step, trapezium

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError
from electrovib.papers.persson_2018 import Persson2018RoughGap, scenarios
from electrovib.physics.roughness import GaussianGaps, IdleSpots, LeakingSpots, PullingSpots, mean_pull
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import modes, phasors

VOLTAGE = 100.0
OF_THE_LAW = 2e-4  # its average takes 32 gaps
CONDUCTING, DISPERSIVE = constant(1560.0, 2e-6), debye(50.0, 1500.0, 1e-3, 2e-6)
BARE = {"circuit.return_path.resistance": 0.0}


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
    given = {"electrical_thickness": thickness, "gaps": gaps, "spots": spots, "frequency": frequency}
    return AREA * mean_pull(VOLTAGE / math.sqrt(2), **given).total


@pytest.mark.parametrize("filling", [None, CONDUCTING, DISPERSIVE], ids=["plain", "conducting", "dispersive"])
@pytest.mark.parametrize("spots", [PullingSpots(), IdleSpots(), LeakingSpots(resistivity=3e7)], ids=repr)
def test_law_over_frequency_is_the_formula(filling, spots):
    changes = {"stack.stratum_corneum.material": filling} if filling else {}
    scenario = rough(BARE | changes, spots=spots.to_dict())
    frequency = np.geomspace(1.0, 1e6, 19)
    force = mean_force(scenario, phasors(scenario, frequency), amplitude=VOLTAGE)
    np.testing.assert_allclose(force, formula(scenario, frequency, spots), rtol=OF_THE_LAW)


@pytest.mark.parametrize("mean", [0.0, 1e-6, 5e-6, 15e-6, 60e-6])
@pytest.mark.parametrize("rms", [0.3e-6, 5e-6, 22e-6])
def test_held_voltage_on_layers_that_insulate(mean, rms):
    scenario = rough({"drive": step(VOLTAGE)}, mean=mean, rms=rms)
    force = simulate(scenario, time=np.array([0.0, 0.1])).electrostatic_force.values
    gaps = GaussianGaps(mean=mean, rms=rms)
    thickness = 1e-6 / 3.9 + 200e-6 / 1650
    pull = mean_pull(VOLTAGE, electrical_thickness=thickness, gaps=gaps, spots=PullingSpots())
    np.testing.assert_allclose(force[-1], AREA * pull.total, rtol=OF_THE_LAW)


def test_each_gap_is_a_stack_of_its_own():
    """Force of the law in time against a plain stack with a layer gap for each of its gaps."""
    changes = {"drive": trapezium(VOLTAGE, 2e-3, 2e-2, 2e-3), "time": {"duration": 0.03}}
    changes |= {"stack.stratum_corneum.material": DISPERSIVE}
    scenario = rough(BARE | changes, spots={"model": "IdleSpots"})
    time = np.linspace(0, 0.03, 61)
    force = simulate(scenario, time=time).electrostatic_force.values
    law = scenario.force
    skin, film = scenario.stack.layers["stratum_corneum"], scenario.stack.layers["insulator"]
    places, shares = law.gaps().rule(film.thickness / 3.9, count=32, reach=5.5)
    total = np.zeros(len(time))
    for place, share in zip(places, shares, strict=True):
        tables = scenario.to_dict()
        tables["force"] = {"model": "MaxwellStressInGap"}
        layers = {"insulator": film.to_dict(), "gap": {"thickness": max(place, 1e-10)}}
        tables["stack"] = layers | {"stratum_corneum": skin.to_dict()}
        alone = type(scenario).model_validate(tables)
        total += share * simulate(alone, time=time).electrostatic_force.values
    # the smallest gaps of the rule lie below the thinnest layer a stack may have
    np.testing.assert_allclose(force, total, rtol=0, atol=1e-4 * np.max(total))
    assert np.max(np.abs(force * 1.001 - total)) > 1e-4 * np.max(total)


def test_spots_that_leak_let_a_held_voltage_go():
    """A vanishing gap is a high pass of eps0 rho, whatever the layers; the rest keeps its force."""
    resistivity = 1e-3 / VACUUM_PERMITTIVITY  # 1 ms
    changes = BARE | {"drive": step(VOLTAGE), "time.initial_state": {"model": "AtRest"}}
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
    with pytest.raises(InputError) as caught:
        scenario.replace({"force": {"model": "Persson2018RoughGap"}})
    assert [name in str(caught.value) for name in ("mean_gap", "rms_gap")] == [True, True]
    assert len(caught.value.problems) == 2


def test_roughness_is_spoken_of():
    law = Persson2018RoughGap(mean_gap=5e-6, rms_gap=5e-6)
    thick = scenarios()["coating"].replace({"stack.insulator.thickness": "90 um"})
    coating, film = (
        {each.name: each for each in law.diagnostics(scenario.stack.layers)}
        for scenario in (scenarios()["coating"], thick)
    )
    states = {name: each.state for name, each in coating.items()}
    names = ("form of the gaps", "roughness wavelength", "stack voltage")
    unknown = dict.fromkeys(names, "unknown")
    assert states == {"contact spots": "warning"} | unknown
    assert film["roughness wavelength"].state == "warning"
    assert "565 um" in film["roughness wavelength"].text
    assert film["contact spots"].state == "ok"


def test_series_resistance_is_that_of_the_layers_alone():
    """The voltage is what the layers without a gap leave: the same share for every gap."""
    frequency = np.geomspace(1e3, 1e6, 7)
    with_body, without = (rough({"circuit.return_path.resistance": ohms}) for ohms in (1e4, 0.0))
    share = np.abs(phasors(with_body, frequency).voltage) ** 2
    assert share[-1] < 0.01
    force, bare = (
        mean_force(each, phasors(each, frequency), amplitude=VOLTAGE) for each in (with_body, without)
    )
    np.testing.assert_allclose(force, share * bare, rtol=1e-12)
    section, _ = modes(with_body)
    exact = with_body.force.amplitudes(phasors(with_body, frequency))
    for name, transfer in with_body.force.amplitudes(section).items():
        np.testing.assert_allclose(transfer.at(frequency), exact[name], rtol=1e-9, err_msg=name)
