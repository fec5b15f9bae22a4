"""Field in one more gap: phasors and modes against each other and against a stack that has the gap as a layer."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.stack.expand import modes, phasors
from electrovib.solve.stack.section import field_in_gap

FREQUENCY = np.geomspace(1.0, 1e6, 25)
EXACT = 1e-10
"""Of the largest magnitude: roots, residues and a product of partial fractions."""
CONDUCTING = {"model": "Constant", "permittivity": 1560, "conductivity": 2e-6}
DISPERSIVE = {
    "model": "Debye",
    "permittivity_high": 50,
    "strength": 1500,
    "relaxation_time": 1e-3,
    "conductivity": 2e-6,
}


def finger(skin, **circuit):
    path = {"model": "Grounded", "resistance": 0.0} | circuit
    changes = {"stack.stratum_corneum.material": skin, "circuit.return_path": path}
    return load("vezzoli_2014/fig6").replace(changes | {"stack.insulator.thickness": 1e-6})


@pytest.mark.parametrize("thickness", [1e-15, 1e-9, 3e-6, 1e-3])
@pytest.mark.parametrize("conductivity", [0.0, 1e-9, 1e-3])
@pytest.mark.parametrize("material", [CONDUCTING, DISPERSIVE], ids=["conducting", "dispersive"])
@pytest.mark.parametrize(
    "circuit",
    [
        {},
        {"resistance": 1e-6},
        {"resistance": 1e5},
        {"model": "Floating", "capacitance": 150e-12, "leak": 1e9},
    ],
    ids=["none", "tiny", "large", "floating"],
)
def test_modes_are_the_phasors(thickness, conductivity, material, circuit):
    scenario = finger(material, **circuit)
    given = {"thickness": thickness, "conductivity": conductivity}
    exact = field_in_gap(phasors(scenario, FREQUENCY), **given)
    section, _ = modes(scenario)
    found = field_in_gap(section, **given).at(FREQUENCY)
    assert np.max(np.abs(found - exact)) < EXACT * np.max(np.abs(exact))
    thicker = field_in_gap(section, thickness=thickness + 1e-9, conductivity=conductivity).at(FREQUENCY)
    assert np.max(np.abs(thicker - exact)) > EXACT * np.max(np.abs(exact))


@pytest.mark.parametrize("conductivity", [0.0, 1e-9])
def test_without_anything_in_series_it_is_a_layer_of_the_stack(conductivity):
    scenario = finger(DISPERSIVE)
    tables = scenario.to_dict()
    material = {"model": "Constant", "permittivity": 1.0, "conductivity": conductivity}
    film, skin = tables["stack"].values()
    gap = {"thickness": 3e-6, "material": material}
    tables["stack"] = {"insulator": film, "gap": gap, "stratum_corneum": skin}
    expected = phasors(type(scenario).model_validate(tables), FREQUENCY)["gap"].field
    given = {"thickness": 3e-6, "conductivity": conductivity}
    np.testing.assert_allclose(field_in_gap(phasors(scenario, FREQUENCY), **given), expected, rtol=1e-13)


def test_initial_charge_is_refused():
    section, _ = modes(finger(CONDUCTING).replace({"stack.insulator.initial_charge": 1e-6}))
    with pytest.raises(InputError, match=r"initial_charge .* force\.model = MaxwellStressInGap"):
        field_in_gap(section, thickness=1e-6)
