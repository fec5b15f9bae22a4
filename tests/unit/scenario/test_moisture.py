"""Moisture changes only parameters that the scenario has."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.physics.moisture import Moisture
from electrovib.scenario import Scenario, load
from electrovib.scenario.moisture import moistened
from electrovib.solve.simulate import simulate

WET = Moisture(**{**Moisture.example, "level": 1.0})
GAP = {"thickness": 3e-6, "material": {"model": "Constant", "permittivity": 1.0}}
PATHS = [
    "stack.stratum_corneum.material.conductivity",
    "stack.gap.material.conductivity",
    "friction.coefficient",
]


def with_layers(**layers):
    stack = dict(Scenario.example["stack"])
    stack = {"insulator": stack["insulator"], **layers, "stratum_corneum": stack["stratum_corneum"]}
    return Scenario.model_validate(dict(Scenario.example) | {"stack": stack})


def test_all_three_move_together():
    scenario = with_layers(gap=GAP)
    changes = moistened(scenario, WET)
    assert sorted(changes) == sorted(PATHS)
    moist = scenario.replace(changes)
    assert moist.stack.layers["stratum_corneum"].material.conductivity == pytest.approx(
        0.2 * 200e-6, rel=1e-14
    )
    assert moist.stack.layers["gap"].material.conductivity == pytest.approx(1e-6, rel=1e-14)
    assert moist.friction.coefficient == 0.8


def test_only_what_is_there_is_moved():
    assert "stack.gap.material.conductivity" not in moistened(with_layers(), WET)
    bridges = {"model": "BridgedAir", "bridged_share": 0.01, "spot_conductivity": 0.0}
    changes = moistened(with_layers(gap={"thickness": 3e-6, "material": bridges}), WET)
    assert changes["stack.gap.material.spot_conductivity"] == pytest.approx(1e-6, rel=1e-14)
    assert "stack.gap.material.conductivity" not in changes
    no_skin = Scenario.model_validate(
        dict(Scenario.example) | {"stack": {"insulator": Scenario.example["stack"]["insulator"]}}
    )
    assert list(moistened(no_skin, WET)) == ["friction.coefficient"]


def test_a_moist_finger_loses_a_held_force_sooner_and_rubs_harder():
    """The attraction decays with the resistivity of the gap; friction without voltage rises with the coefficient."""
    scenario = with_layers(gap=GAP).replace({"time.duration": 1e-3, "time.samples": 51})
    left, rubs = [], []
    for level in (0.0, 0.5, 1.0):
        moisture = Moisture(**{**Moisture.example, "level": level, "wet_gap_resistivity": 1e6})
        trace = simulate(scenario.replace(moistened(scenario, moisture)))
        left.append(float(trace.electrostatic_force[-1] / trace.electrostatic_force[1]))
        rubs.append(float((trace.lateral_force / (trace.electrostatic_force + 0.5))[-1]))
    assert np.all(np.diff(left) < 0)
    assert left[0] > 0.99
    assert rubs == pytest.approx([0.4, 0.6, 0.8], rel=1e-12)


def test_changes_fit_a_papers_scenario():
    scenario = load("vezzoli_2014/fig6")
    assert scenario.replace(moistened(scenario, WET)) != scenario
