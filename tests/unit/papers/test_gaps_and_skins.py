"""Gaps and skins told by impedance and by the frequencies of the force: Aliabbasi, Shultz and Meyer."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.discovery import papers
from electrovib.papers import (
    aliabbasi_2022,
    aliabbasi_2024,
    gabriel_1996,
    meyer_2013,
    plutchik_1963,
    shultz_2018,
)
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import phasors


def test_a_fitted_maximum_says_so_and_a_conductor_has_none():
    assert aliabbasi_2022.STATUS == "unverified"
    assert all(check.status == "derived" for check in aliabbasi_2022.CHECKS)
    assert all(check.expect != 250.0 for check in aliabbasi_2022.CHECKS)
    scenario = aliabbasi_2022.scenarios()["maximum"]
    # three digits of the resistivity on a flat maximum
    assert aliabbasi_2022.maximum(scenario) == pytest.approx(250.0, rel=1e-2)
    assert "circular" in scenario.sources["stack.gap.material.conductivity"]
    conductor = aliabbasi_2024.chain(gap_resistivity=2e7, resistance=0.0)
    assert aliabbasi_2022.maximum(conductor) is None or aliabbasi_2022.maximum(conductor) > 1e5


@given(gap=st.floats(0.1e-6, 50e-6), decade=st.floats(6, 10), frequency=st.floats(1, 1e5))
def test_gap_and_force_come_back_from_impedances_whatever_leaks(gap, decade, frequency):
    scenario = aliabbasi_2024.scenarios()["chain"].replace(
        {"stack.gap.thickness": gap, "stack.gap.material.conductivity": 10**-decade}
    )
    found, force = aliabbasi_2024.estimate(scenario, frequency=frequency, voltage=100.0)
    # the gap's reactance is what is left of sums up to 1e4 times larger, and a part of the leak of 1e-5 at the least
    assert found / gap == pytest.approx(1.0, rel=1e-6)
    law = mean_force(scenario, phasors(scenario, np.array([frequency])), amplitude=100.0)
    assert force / law == pytest.approx([1.0], rel=1e-6)


def test_the_remaining_impedance_is_that_of_a_leaky_gap():
    scenario = aliabbasi_2024.scenarios()["chain"]
    frequency = np.geomspace(0.1, 1e5, 30)
    left = aliabbasi_2024.remaining_impedance(scenario, frequency)
    assert left == pytest.approx(scenario.stack.layers["gap"].impedance(frequency) / 1e-4, rel=1e-9)
    # at low frequency the leak alone: R_g = rho g/A
    resistance = 2e7 * 3e-6 / 1e-4
    assert abs(left[0]) == pytest.approx(resistance, rel=1e-6)
    stiff = scenario.replace({"stack.gap.material.conductivity": 0.0})
    # the lowest frequency of the band
    assert aliabbasi_2024.rises_to(stiff, share=0.5) == pytest.approx(1e-2)
    bare = aliabbasi_2024.chain(gap_resistivity=1e6)
    assert list(bare.stack.layers) == ["insulator", "gap"]
    full = aliabbasi_2024.chain(gap_resistivity=1e6, skin=plutchik_1963.skins()["skin"].material)
    assert list(full.stack.layers) == ["insulator", "gap", "stratum_corneum"]
    assert full.stack.layers["gap"].material.conductivity == 1e-6


@given(rise=st.floats(*(2.0, 11.0)))
def test_a_gap_for_every_rise_of_the_impedance(rise):
    thickness = sum(
        layer.thickness / layer.material.permittivity
        for layer in shultz_2018.scenarios()["at_rest"].stack.layers.values()
    )
    impedance, force = shultz_2018.sliding_over_rest(gap=(rise - 1) * thickness)
    # the skin's conduction is 1e-8 of its admittance at 100 kHz
    assert impedance == pytest.approx(rise, rel=1e-6)
    assert 1 / force == pytest.approx(rise**2, rel=1e-6)


def test_a_body_hides_part_of_the_rise():
    """At 10 kHz with 1 kohm in series the ready-made finger shows less than the 3.6 of the gap alone."""
    found = {
        name: 1 / abs(phasors(scenario, np.array([1e4])).current_density[0])
        for name, scenario in shultz_2018.scenarios().items()
    }
    assert 3.5 < found["sliding"] / found["at_rest"] < 3.6


@pytest.mark.parametrize(("frequency", "share"), [(50.0, 1 / 101), (1500.0, 0.9), (5000.0, 1 / 1.01)])
def test_attraction_follows_a_first_order_high_pass(frequency, share):
    assert meyer_2013.share_of_plateau(frequency=frequency) == pytest.approx(share, rel=1e-9)
    skin = meyer_2013.first_order_skin(time_constant=meyer_2013.time_constant(frequency))
    # linear interpolation of logarithms, 570 points a decade
    assert meyer_2013.cut_off(skin) == pytest.approx(frequency, rel=1e-5)


def test_the_cut_off_of_published_skins_is_below_about_500_hz():
    """Whole skin excepted, the model puts the cut-off at 14 to 514 Hz: the abstract's 'below about 500 Hz'."""
    found = {
        key: meyer_2013.cut_off(skin.material)
        for name in ("palmar_1995", "plutchik_1963", "vezzoli_2014")
        for key, skin in papers()[name].skins().items()
        if skin.reproduces_force
    }
    assert (min(found.values()), found["moist_men"]) == pytest.approx((13.8, 514.0), rel=5e-3)
    assert found["moist_men"] == max(found.values())
    dry = papers()["gabriel_1996"].skins()["dry"].material
    assert meyer_2013.cut_off(dry) == pytest.approx(1880.0, rel=5e-3)
    surrogate = papers()["vezzoli_2014"].skins()["surrogate_0.85"].material
    assert math.isnan(meyer_2013.cut_off(surrogate)), "it does not conduct"
    quick = meyer_2013.first_order_skin(time_constant=1e-9)
    assert math.isnan(meyer_2013.cut_off(quick)), "above 1 MHz"
    sources = meyer_2013.scenarios()["first_order"].sources
    assert "circular" in sources["stack.stratum_corneum.material.conductivity"]


def test_a_printed_table_of_skin_is_met_within_half_a_unit_of_its_last_digit_but_for_one_number():
    printed = [check for check in gabriel_1996.CHECKS if check.status == "second-hand"]
    assert len(printed) == 19
    (first,) = (check for check in printed if check.name == "permittivity of wet skin at 10 kHz")
    assert first.rtol * first.expect == pytest.approx(0.5, rel=1e-12)
    assert not first.accepts(29010.6)
    slipped = gabriel_1996.computed(200e3, "wet", "conductivity")
    assert f"{slipped:.4f} S/m here" in gabriel_1996.DEFECTS[0]
    assert abs(slipped - 0.1135) > 20 * 0.00005
