"""A gap in series: the impedance it adds and the force it costs are one number."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.constants import eps0
from electrovib.papers import shultz_2018
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import phasors


@given(rise=st.floats(*shultz_2018.RISE))
def test_a_gap_for_every_rise_of_the_abstract(rise):
    impedance, force = shultz_2018.sliding_over_rest(gap=shultz_2018.gap_for(rise=rise))
    # the skin's conduction is 1e-8 of its admittance at 100 kHz
    assert impedance == pytest.approx(rise, rel=1e-6)
    assert 1 / force == pytest.approx(rise**2, rel=1e-6)
    assert impedance != pytest.approx(rise * 1.001, rel=1e-6)


def test_window_of_gaps():
    """100 to 1000 % on 1 um of permittivity 3.9 with the skin of Vezzoli et al. 2014: 0.385 to 3.85 um."""
    low, high = (shultz_2018.gap_for(rise=rise) for rise in shultz_2018.RISE)
    assert low / 1e-6 == pytest.approx(0.3846, rel=1e-4)
    assert high / low == pytest.approx(10.0, rel=1e-12)


def test_body_hides_part_of_the_rise():
    """At 10 kHz with 1 kohm in series the ready-made finger shows less than the 3.6 of the gap alone."""
    found = {}
    for name, scenario in shultz_2018.scenarios().items():
        section = phasors(scenario, np.array([1e4]))
        found[name] = 1 / abs(section.current_density[0])
    assert 3.5 < found["sliding"] / found["at_rest"] < 3.6


@pytest.mark.parametrize("gap", [1e-9, 1e-3])
def test_limits_of_the_gap_plane(gap):
    scenario = shultz_2018.scenarios()["sliding"].replace(
        {"stack.gap.thickness": gap, "circuit.return_path.resistance": 0.0}
    )
    force = float(mean_force(scenario, phasors(scenario, np.array([1e5])), amplitude=100.0)[0])
    thickness = shultz_2018.electrical_thickness() if gap < 1e-6 else gap
    # 1 nm of gap is 2.6e-3 of K, K is 4e-4 of 1 mm; both twice in the square
    assert force / (eps0 * 1e-4 * 100.0**2 / (4 * thickness**2)) == pytest.approx(1.0, rel=6e-3)
