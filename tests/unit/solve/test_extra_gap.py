"""Field in one more gap: phasors and modes against each other and against a stack that has the gap as a layer."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.scenario import load
from electrovib.solve.stack.expand import modes, phasors
from electrovib.solve.stack.section import field_in_gap, fields_in_gaps

FREQUENCY = np.geomspace(1.0, 1e6, 25)
EXACT = 1e-10
"""Of the largest magnitude: roots, residues and a product of partial fractions."""
CONDUCTING = {"model": "Constant", "permittivity": 1560, "conductivity": 2e-6}
DEBYE = {
    "model": "Debye",
    "permittivity_high": 50,
    "strength": 1500,
    "relaxation_time": 1e-3,
    "conductivity": 2e-6,
}
PATHS = {
    "none": {"model": "Grounded", "resistance": 0.0},
    "tiny": {"model": "Grounded", "resistance": 1e-6},
    "large": {"model": "Grounded", "resistance": 1e5},
    "floating": {"model": "Floating", "capacitance": 150e-12, "leak": 1e9, "resistance": 0.0},
}


def finger(skin, path="none"):
    changes = {"stack.stratum_corneum.material": skin, "circuit.return_path": PATHS[path]}
    return load("vezzoli_2014/fig6", changes=changes | {"stack.insulator.thickness": 1e-6})


@pytest.mark.parametrize("thickness", [1e-15, 1e-9, 3e-6, 1e-3])
@pytest.mark.parametrize("conductivity", [0.0, 1e-9, 1e-3])
@pytest.mark.parametrize("material", [CONDUCTING, DEBYE], ids=["conducting", "dispersive"])
@pytest.mark.parametrize("path", PATHS)
def test_modes_are_the_phasors(thickness, conductivity, material, path):
    scenario, given = finger(material, path), {"thickness": thickness, "conductivity": conductivity}
    exact, (section, _) = field_in_gap(phasors(scenario, FREQUENCY), **given), modes(scenario)
    found, thicker = (
        field_in_gap(section, thickness=thickness + more, conductivity=conductivity).at(FREQUENCY)
        for more in (0.0, 1e-9)
    )
    assert np.max(np.abs(found - exact)) < EXACT * np.max(np.abs(exact))
    assert np.max(np.abs(thicker - exact)) > EXACT * np.max(np.abs(exact))


@pytest.mark.parametrize("conductivity", [0.0, 1e-9])
def test_without_anything_in_series_it_is_a_layer_of_the_stack(conductivity):
    scenario = finger(DEBYE)
    film, skin = scenario.to_dict()["stack"].values()
    air = {"model": "Constant", "permittivity": 1.0, "conductivity": conductivity}
    stack = {"insulator": film, "gap": {"thickness": 3e-6, "material": air}, "stratum_corneum": skin}
    expected = phasors(scenario.replace({"stack": stack}), FREQUENCY)["gap"].field
    found = field_in_gap(phasors(scenario, FREQUENCY), thickness=3e-6, conductivity=conductivity)
    np.testing.assert_allclose(found, expected, rtol=1e-13)


def test_initial_charge_is_refused():
    section, _ = modes(finger(CONDUCTING).replace({"stack.insulator.initial_charge": 1e-6}))
    with pytest.raises(InputError, match=r"initial_charge .* force\.model = MaxwellStressInGap"):
        field_in_gap(section, thickness=1e-6)


@pytest.mark.parametrize("material", [CONDUCTING, DEBYE], ids=["conducting", "dispersive"])
@pytest.mark.parametrize("path", PATHS)
def test_several_gaps_at_once_have_the_fields_of_each_alone(material, path):
    section, _ = modes(finger(material, path))
    thickness = np.array([1e-9, 1e-7, 3e-6, 1e-3])
    for each, one in zip(fields_in_gaps(section, thickness), thickness, strict=True):
        alone = field_in_gap(section, thickness=one)
        assert (each.rates.shape, np.shape(each.direct)) == (alone.rates.shape, ())
        np.testing.assert_allclose(each.rates, alone.rates, rtol=1e-12)
        np.testing.assert_allclose(each.at(FREQUENCY), alone.at(FREQUENCY), rtol=1e-11)
    exact = phasors(finger(material, path), FREQUENCY)
    for each, one in zip(fields_in_gaps(exact, thickness), thickness, strict=True):
        np.testing.assert_array_equal(each, field_in_gap(exact, thickness=one))
