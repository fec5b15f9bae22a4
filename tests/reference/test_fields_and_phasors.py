"""Fields, displacements and current out of modes against impedances of the materials as declared."""

from __future__ import annotations

import numpy as np
import pytest
from scenario_parts import AREA, EPS0, floating, grounded, largest, layer, model, prony, step

from electrovib.solve.stack.expand import modes, phasors, reduce_material
from electrovib.solve.stack.modes import stack_modes

FREQUENCY = np.geomspace(1, 1e6, 61)
PRECISION = (
    1e-10  # demanded, of the largest value in the band; fields reach 3e-11 where they nearly vanish in it
)
TIGHT = 1e-12  # the same for the stacks of a finger
OF_THE_DRIVE = 1e-13  # voltage of a layer over that of the drive: roundings of up to 25 modes


def by_impedance(slabs, element, second, frequency):
    """Give field and displacement of each layer, current density and voltage of the rest, per volt."""
    s = 2j * np.pi * frequency
    permittivity = np.array([slab.debye.permittivity(frequency) for slab in slabs])
    conductivity, thickness = np.array([[slab.conductivity, slab.thickness] for slab in slabs]).T[:, :, None]
    drops = thickness / (s * EPS0 * permittivity + conductivity)
    outside = AREA * element.impedance(frequency)
    current = 1 / (drops.sum(axis=0) * (1 + second) + outside)
    fields = drops * current / thickness
    return fields, EPS0 * permittivity * fields, current, outside


@pytest.mark.parametrize("seed", range(4))
def test_random_stacks(finger, seed):
    random = np.random.default_rng(1000 + seed)
    for _ in range(75):
        slabs, element = finger.random_stack(random), finger.random_element(random)
        second = 0.0 if random.random() < 0.7 else float(random.uniform(0.2, 3))
        found = stack_modes(slabs, area=AREA, element=element, second=second)
        fields, displacements, current, outside = by_impedance(slabs, element, second, FREQUENCY)
        across = 0
        for k, slab in enumerate(slabs):
            field, displacement = found.fields[k].at(FREQUENCY), found.displacements[k].at(FREQUENCY)
            assert largest(field - fields[k]) * slab.thickness < OF_THE_DRIVE
            assert largest(field - fields[k]) < PRECISION * largest(fields[k])
            assert largest(displacement - displacements[k]) < PRECISION * largest(displacements[k])
            across = across + field * slab.thickness * (1 + second)
        flow = found.current_density.at(FREQUENCY)
        assert largest(flow / current - 1) < OF_THE_DRIVE  # of itself at every frequency
        assert largest(across + outside * flow - 1) < OF_THE_DRIVE


SURROUNDINGS = {
    "nothing": {"return_path": grounded()},
    "grounded": {"return_path": grounded(1000)},
    "floating": {"return_path": floating(leak=1e9)},
    "second": {"return_path": model("SecondElectrode", area=0.5e-4), "source_resistance": 1e5},
}


@pytest.mark.parametrize("surroundings", SURROUNDINGS)
@pytest.mark.parametrize("gap", [0, 1e-10, 1e-3], ids=["no gap", "dry gap", "wet gap"])
def test_stacks_of_a_finger(finger, paper_skin, gap, surroundings):
    """The stack of Vezzoli et al. 2014 with every skin, also with a gap full of sweat."""
    exact = prony(reduce_material(paper_skin).debye, paper_skin.conductivity)
    layers = {"insulator": finger.film()} | ({"gap": finger.gap(1e-6, gap)} if gap else {})
    layers["stratum_corneum"] = layer(200e-6, exact)
    scenario = finger.build(drive=step(1), stack=layers, circuit=SURROUNDINGS[surroundings])
    section, _ = modes(scenario)
    truth = phasors(scenario, FREQUENCY)
    for name in section.names:
        field, displacement = section[name].field.at(FREQUENCY), section[name].displacement.at(FREQUENCY)
        assert largest(field - truth[name].field) < TIGHT * largest(truth[name].field)
        assert largest(displacement - truth[name].displacement) < TIGHT * largest(truth[name].displacement)
    assert largest(section.voltage.at(FREQUENCY) - truth.voltage) < OF_THE_DRIVE
    flow = section.current_density.at(FREQUENCY)
    assert largest(flow / truth.current_density - 1) < OF_THE_DRIVE
    outside = AREA * scenario.circuit.element().impedance(FREQUENCY)
    second = scenario.circuit.return_path.second_contact(AREA)
    drop = section.voltage.at(FREQUENCY) * (1 + second) + outside * flow
    assert largest(drop - 1) < OF_THE_DRIVE


def test_a_wrong_field_is_refused(finger):
    """The comparison sees a conductivity that is off by 1e-9."""
    layers = {"insulator": finger.film(), "stratum_corneum": finger.skin(conductivity=1e-6)}
    scenario = finger.build(drive=step(1), stack=layers)
    wrong = scenario.replace({"stack.stratum_corneum.material.conductivity": 1e-6 * (1 + 1e-9)})
    section, _ = modes(wrong)
    truth = phasors(scenario, FREQUENCY)["stratum_corneum"].field
    assert largest(section["stratum_corneum"].field.at(FREQUENCY) / truth - 1) > PRECISION
