"""The maximum of the force over frequency is found where it is, and 250 Hz is put there by hand."""

from __future__ import annotations

import math

import pytest

from electrovib.papers import aliabbasi_2022, aliabbasi_2024, plutchik_1963


def test_status_is_honest():
    assert aliabbasi_2022.STATUS == "unverified"
    assert all(check.status == "derived" for check in aliabbasi_2022.CHECKS)
    assert all(check.expect != aliabbasi_2022.DIVISION for check in aliabbasi_2022.CHECKS)


def test_the_ready_made_scenario_is_fitted_and_says_so():
    scenario = aliabbasi_2022.scenarios()["maximum"]
    # three digits of the resistivity on a flat maximum
    assert aliabbasi_2022.maximum(scenario) == pytest.approx(250.0, rel=1e-2)
    assert "circular" in scenario.sources["stack.gap.material.conductivity"]


@pytest.mark.parametrize("wanted", [50.0, 250.0, 2000.0, 20e3])
def test_any_maximum_can_be_had_by_the_leak(wanted):
    from scipy.optimize import brentq

    def miss(decade):
        found = aliabbasi_2022.maximum_of(gap_resistivity=10**decade, skin=plutchik_1963.material())
        return math.log(found / wanted)

    resistivity = 10 ** brentq(miss, 5.5, 9.5, xtol=1e-3)
    again = aliabbasi_2022.maximum_of(gap_resistivity=resistivity, skin=plutchik_1963.material())
    assert again == pytest.approx(wanted, rel=2e-2)


def test_no_maximum_is_no_number():
    conductor = aliabbasi_2024.chain(gap_resistivity=2e7, resistance=0.0)
    assert aliabbasi_2022.maximum(conductor) is None or aliabbasi_2022.maximum(conductor) > 1e5
