"""Gap and force from impedances, on a measurement that is computed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.papers import aliabbasi_2024, plutchik_1963
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import phasors


@given(
    gap=st.floats(0.1e-6, 50e-6),
    decade=st.floats(6, 10),
    frequency=st.floats(1, 1e5),
)
def test_gap_and_force_come_back_whatever_leaks(gap, decade, frequency):
    scenario = aliabbasi_2024.scenarios()["chain"].replace(
        {"stack.gap.thickness": gap, "stack.gap.material.conductivity": 10**-decade}
    )
    found, force = aliabbasi_2024.estimate(scenario, frequency=frequency, voltage=100.0)
    law = float(mean_force(scenario, phasors(scenario, np.array([frequency])), amplitude=100.0)[0])
    # the gap's reactance is what is left of sums up to 1e4 times larger, and a part of the leak of 1e-5 at the least
    assert found / gap == pytest.approx(1.0, rel=1e-6)
    assert force / law == pytest.approx(1.0, rel=1e-6)
    assert 1.001 * force / law != pytest.approx(1.0, rel=1e-6)


def test_remaining_impedance_is_a_capacitor_with_a_leak_beside_it():
    scenario = aliabbasi_2024.scenarios()["chain"]
    frequency = np.geomspace(0.1, 1e5, 30)
    left = aliabbasi_2024.remaining_impedance(scenario, frequency)
    layer = scenario.stack.layers["gap"]
    assert left == pytest.approx(layer.impedance(frequency) / 1e-4, rel=1e-9)
    # at low frequency the leak alone: R_g = rho g/A
    resistance = aliabbasi_2024.GAP_RESISTIVITY * aliabbasi_2024.GAP / 1e-4
    assert abs(left[0]) == pytest.approx(resistance, rel=1e-6)


def test_chain_takes_skins_and_none():
    bare = aliabbasi_2024.chain(gap_resistivity=1e6)
    assert list(bare.stack.layers) == ["insulator", "gap"]
    full = aliabbasi_2024.chain(gap_resistivity=1e6, skin=plutchik_1963.material())
    assert list(full.stack.layers) == ["insulator", "gap", "stratum_corneum"]
    assert full.stack.layers["gap"].material.conductivity == 1e-6


def test_edge_below_the_band_is_the_lowest_frequency():
    stiff = aliabbasi_2024.scenarios()["chain"].replace({"stack.gap.material.conductivity": 0.0})
    assert aliabbasi_2024.rises_to(stiff, share=0.5) == pytest.approx(1e-2)
