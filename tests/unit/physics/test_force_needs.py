"""A law tells the layers that it reads by role or by name."""

from __future__ import annotations

import pytest

from electrovib.physics.force import needed_layer, wanted_layer

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
