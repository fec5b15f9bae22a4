"""Moisture: one number between dry and wet."""

from __future__ import annotations

import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.moisture import Moisture

GIVEN = {k: v for k, v in Moisture.example.items() if k != "level"}


def test_ends_are_the_given_values():
    dry, wet = Moisture(level=0, **GIVEN), Moisture(level=1, **GIVEN)
    assert dry.gap_resistivity() == GIVEN["dry_gap_resistivity"]
    assert wet.gap_resistivity() == pytest.approx(GIVEN["wet_gap_resistivity"], rel=1e-14)
    assert (dry.coefficient(), wet.coefficient()) == (0.4, 0.8)
    # 2 and 20 uS for each cm2 over 200 um
    assert dry.skin_conductivity(200e-6) == pytest.approx(2e-6 / 1e-4 * 200e-6, rel=1e-14)
    assert wet.skin_conductivity(200e-6) == pytest.approx(20e-6 / 1e-4 * 200e-6, rel=1e-14)


def test_the_middle_is_geometric_and_for_friction_the_mean():
    half = Moisture(level=0.5, **GIVEN)
    assert half.gap_resistivity() == pytest.approx(1e9, rel=1e-12)
    assert half.coefficient() == pytest.approx(0.6, rel=1e-14)
    assert half.skin_conductivity(1.0) == pytest.approx((0.02 * 0.2) ** 0.5, rel=1e-14)


@pytest.mark.parametrize("name", sorted(GIVEN))
def test_what_no_source_gives_has_to_be_given(name):
    with pytest.raises(InputError, match=name):
        read_model(Moisture, {"level": 0.5} | {k: v for k, v in GIVEN.items() if k != name})


def test_a_conductance_per_area_is_read_as_it_is_written():
    wet = read_model(Moisture, dict(Moisture.example) | {"wet_skin_conductance": "20 uS/cm**2"})
    assert wet.wet_skin_conductance == pytest.approx(0.2, rel=1e-14)
