"""Which layer belongs to the plate, to the gap or to the finger, and which is nearest to the interface."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.physics.interface import IMPLIED, ORDER, beside_interface, interface_place, roles_of
from electrovib.physics.stack import Layer

SLAB = Layer(thickness=1e-6)
LAYERS = {
    "glass": Layer(thickness=1e-3, role="plate"),
    "insulator": SLAB,
    "stratum_corneum": SLAB,
    "dermis": Layer(thickness=1e-3, role="finger"),
}


def test_a_known_name_implies_its_role_and_others_declare_it():
    assert roles_of(LAYERS) == {
        "glass": "plate",
        "insulator": "plate",
        "stratum_corneum": "finger",
        "dermis": "finger",
    }
    assert set(IMPLIED.values()) == set(ORDER)


def test_the_layer_beside_the_interface():
    roles = roles_of(LAYERS)
    assert beside_interface(roles, "plate") == "insulator"
    assert beside_interface(roles, "finger") == "stratum_corneum"
    assert beside_interface(roles, "gap") is None
    assert interface_place(roles.values()) == 2
    assert beside_interface(roles_of({"insulator": SLAB, "gap": SLAB}), "gap") == "gap"
    assert interface_place(roles_of({"stratum_corneum": SLAB}).values()) == 0


def test_every_wrong_role_is_reported_at_once():
    with pytest.raises(InputError) as caught:
        roles_of({"glass": SLAB, "insulator": Layer(thickness=1e-6, role="gap"), "skin": SLAB})
    assert [problem.split(":")[0] for problem in caught.value.problems] == [
        "stack.glass.role",
        "stack.insulator.role",
        "stack.skin.role",
    ]
