"""A law tells the layers that it reads by role or by name."""

from __future__ import annotations

import pytest

from electrovib.physics.force import needed_layer, wanted_layer
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

ROLES = {
    "insulator": "plate",
    "coating": "plate",
    "gap": "gap",
    "sweat": "finger",
    "stratum_corneum": "finger",
}


@pytest.mark.parametrize(
    ("wanted", "name"),
    [("plate", "coating"), ("gap", "gap"), ("finger", "sweat"), ("insulator", "insulator"), ("oil", None)],
)
def test_a_role_is_the_layer_nearest_to_the_interface_and_a_name_that_layer(wanted, name):
    assert needed_layer(ROLES, wanted) == name


def test_what_is_missing_is_told_as_it_is_written():
    assert wanted_layer("gap") == "a layer 'stack.gap', or one of another name with role = 'gap'"
    assert wanted_layer("oil") == "a layer 'stack.oil'"
    assert needed_layer({"insulator": "plate"}, "finger") is None


@pytest.mark.parametrize("law", ["EffectiveMedium", "Vezzoli2014Causal"])
def test_a_law_of_the_effective_medium_warns_of_layers_that_it_leaves_out(law):
    scenario = load("vezzoli_2014/fig6").replace({"force.model": law})
    alone = [each.name for each in scenario.force.diagnostics(scenario.stack.layers)]
    assert "layers left out" not in alone
    film = {"thickness": 5e-6, "role": "plate", "material": {"model": "Constant", "permittivity": 3.35}}
    two = scenario.replace({"stack.primer": film, "stack.gap.thickness": 1e-6})
    found = {each.name: each for each in scenario.force.diagnostics(two.stack.layers)}["layers left out"]
    assert found.state == "warning"
    assert f"{law} has one layer of the plate and one of the finger, primer and stratum_corneum" in found.text
    assert "leaves insulator out" in found.text
    in_gap = two.replace({"force": {"model": "MaxwellStressInGap"}})
    assert in_gap.force.diagnostics(two.stack.layers) == ()


def test_what_an_effective_medium_leaves_out_makes_its_force_too_large():
    """95 um of one film, in one layer and in two."""
    base = load("vezzoli_2014/fig6_static").replace({"force.model": "EffectiveMedium"})
    film = {"thickness": 5e-6, "role": "plate", "material": {"model": "Constant", "permittivity": 3.35}}
    one, two = ({"stack.insulator.thickness": 95e-6}, {"stack.primer": film})
    forces = [float(simulate(base.replace(each)).electrostatic_force.max()) for each in (one, two)]
    assert forces[1] > 20 * forces[0]
