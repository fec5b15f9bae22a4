"""The first-order circuit that the paper's own measurement contradicts."""

from __future__ import annotations

import math

import pytest

from electrovib.core.discovery import papers
from electrovib.papers import meyer_2013


@pytest.mark.parametrize("frequency", [50.0, 250.0, 500.0, 2000.0])
def test_cut_off_and_time_constant_are_one_number(frequency):
    skin = meyer_2013.first_order_skin(time_constant=meyer_2013.time_constant(frequency))
    # linear interpolation of logarithms, 570 points a decade
    assert meyer_2013.cut_off(skin) == pytest.approx(frequency, rel=1e-5)


@pytest.mark.parametrize(
    ("frequency", "share"), [(50.0, 1 / 101), (500.0, 0.5), (1500.0, 0.9), (5000.0, 1 / 1.01)]
)
def test_attraction_follows_a_first_order_high_pass(frequency, share):
    assert meyer_2013.share_of_plateau(frequency=frequency) == pytest.approx(share, rel=1e-9)
    assert meyer_2013.share_of_plateau(frequency=frequency * 1.01) > share * (1 + 1e-5)


def test_cut_off_of_published_skins_is_below_about_500_hz():
    """Whole skin excepted, the model puts the cut-off at 14 to 514 Hz: the abstract's 'below about 500 Hz'."""
    found = {}
    for name in ("palmar_1995", "plutchik_1963", "vezzoli_2014"):
        for key, skin in papers()[name].skins().items():
            if skin.reproduces_force:
                found[key] = meyer_2013.cut_off(skin.material)
    assert min(found.values()) == pytest.approx(13.8, rel=5e-3)
    assert max(found.values()) == pytest.approx(514.0, rel=5e-3)
    assert found["moist_men"] == max(found.values())
    dry = papers()["gabriel_1996"].skins()["dry"].material
    assert meyer_2013.cut_off(dry) == pytest.approx(1880.0, rel=5e-3)


def test_skin_that_does_not_conduct_has_no_cut_off():
    surrogate = papers()["vezzoli_2014"].skins()["surrogate_0.85"].material
    assert math.isnan(meyer_2013.cut_off(surrogate))


def test_the_abstract_gives_no_data_of_its_own():
    assert meyer_2013.time_constant(500.0) == pytest.approx(0.318e-3, abs=5e-7)
    assert (
        "circular"
        in meyer_2013.scenarios()["first_order"].sources["stack.stratum_corneum.material.conductivity"]
    )
