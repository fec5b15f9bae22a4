"""Gross and real area are two numbers, and neither is the other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.contact import Contact, FixedArea, GrowingArea, PerssonSurface

SKIN = PerssonSurface(**PerssonSurface.example)
GROWING = {"area": 1e-4, "at_force": 0.5, "exponent": 2 / 3}


def test_a_fixed_area_is_the_same_under_any_force():
    contact = FixedArea(area=1e-4)
    assert contact.gross_area() == contact.gross_area(2.0) == 1e-4
    np.testing.assert_array_equal(contact.outline(np.array([0.0, 2.0, np.nan])), [1e-4, 1e-4, np.nan])
    assert contact.sliding_length() == pytest.approx(1e-2, rel=1e-15)
    assert FixedArea(area=1e-4, length=8e-3).sliding_length() == 8e-3


def test_a_growing_area_follows_its_power():
    contact = GrowingArea(**GROWING)
    assert contact.gross_area() == contact.gross_area(0.5) == 1e-4
    assert contact.gross_area(4.0) == pytest.approx(4e-4, rel=1e-14)  # 8^(2/3)
    assert contact.gross_area(0.0) == 0.0
    assert contact.mean_pressure(4.0) == pytest.approx(4.0 / 4e-4, rel=1e-14)
    assert contact.sliding_length(4.0) == pytest.approx(2e-2, rel=1e-14)
    np.testing.assert_allclose(contact.outline(np.array([0.0, 4.0, np.nan])), [0.0, 4e-4, np.nan], rtol=1e-14)


def test_the_exponent_has_no_default():
    with pytest.raises(InputError, match="exponent"):
        read_model(Contact, {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5})


@given(force=st.floats(1e-3, 10.0), exponent=st.floats(0, 1))
def test_pressure_times_gross_area_is_the_force(force, exponent):
    for contact in (FixedArea(area=1e-4), GrowingArea(area=1e-4, at_force=0.5, exponent=exponent)):
        assert contact.mean_pressure(force) * contact.gross_area(force) == pytest.approx(force, rel=1e-13)


def test_real_area_is_that_of_the_relief_under_the_mean_pressure():
    contact = FixedArea(area=1e-4, surface=SKIN)
    force = np.array([0.0, 0.1, 0.5, np.nan])
    area = contact.real_area(force)
    assert area[0] == 0
    assert np.isnan(area[3])
    share = math.erf(math.sqrt(2) * 0.5 / 1e-4 / (SKIN.modulus * SKIN.rms_slope))
    assert area[2] == pytest.approx(1e-4 * share, rel=1e-12)
    assert area[2] < contact.gross_area()
    growing = GrowingArea(**GROWING, surface=SKIN)
    gross = growing.gross_area(0.1)
    assert growing.real_area(0.1) == pytest.approx(gross * float(SKIN.real_share(0.1 / gross)), rel=1e-12)
    assert growing.real_area(0.0) == 0


def test_a_small_load_carries_real_area_in_proportion_whatever_the_gross_area():
    """1.596 F/(E* h'): why Coulomb's friction does not ask for the gross area."""
    areas = [float(FixedArea(area=area, surface=SKIN).real_area(0.01)) for area in (5e-5, 1e-4, 2e-4)]
    assert areas == pytest.approx(
        [math.sqrt(8 / math.pi) * 0.01 / (SKIN.modulus * SKIN.rms_slope)] * 3, rel=1e-6
    )


def test_real_area_without_a_surface_says_what_is_missing():
    with pytest.raises(InputError, match=r"contact\.surface is not given.*PerssonSurface"):
        FixedArea(area=1e-4).real_area(0.5)
