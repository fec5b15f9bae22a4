"""Surfaces under pressure and the two areas of a contact: repulsion and gap are inverse, real area is no gross area."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.contact import (
    Contact,
    FixedArea,
    GrowingArea,
    LinearSpring,
    PerssonSurface,
    Surface,
    pull_in_voltage,
)
from electrovib.physics.contact.rough_surface import gaussian_gaps
from electrovib.physics.roughness import contact_fraction, contact_growth

EPS0 = 8.8541878128e-12
SKIN = PerssonSurface(**PerssonSurface.example)
GROWING = {"area": 1e-4, "at_force": 0.5, "exponent": 2 / 3}


@pytest.mark.parametrize("name", sorted(find_members(Surface)))
def test_every_surface_repels_ever_less_and_touches_ever_more(name):
    kind = find_members(Surface)[name]
    surface = kind.model_validate(dict(kind.example))
    gaps = np.linspace(1e-7, 9e-6, 20)
    np.testing.assert_allclose(surface.gap(surface.pressure(gaps)), gaps, rtol=1e-12)
    gaps = np.linspace(0.0, 3e-5, 301)
    pressure, slope = surface.pressure(gaps), surface.slope(gaps)
    assert np.all(np.diff(pressure) < 0)
    assert np.all(np.diff(slope) >= 0)
    differences = (pressure[2:] - pressure[:-2]) / (gaps[2:] - gaps[:-2])
    # central difference: (step/decay)^2/6 = 2e-5 for a decay of 10 um
    np.testing.assert_allclose(slope[1:-1], differences, rtol=5e-5)
    assert surface.gap(np.asarray(2 * pressure[0])) == 0  # a flat relief keeps no gap
    share = surface.real_share(np.geomspace(1.0, 1e12, 50))
    assert np.all(np.diff(share) >= 0)
    assert share[0] >= 0
    assert share[-1] == pytest.approx(1.0, abs=1e-15)


def test_a_spring_touches_when_it_is_closed_and_has_no_relief():
    spring = LinearSpring(stiffness=1e9, free_gap=1e-5)
    assert spring.real_share(np.array([0.0, 9999.0, 10000.0, 1e6])).tolist() == [0, 0, 1, 1]
    with pytest.raises(InputError, match="no distribution of gaps"):
        spring.gaps(100.0)
    with pytest.raises(InputError, match="PerssonSurface"):
        spring.real_growth(100.0)
    assert np.isinf(SKIN.gap(np.asarray(0.0)))  # nothing pressing is no bound


@given(mean=st.floats(-8, -4), touching=st.floats(-12, math.log10(0.5)))
def test_gaps_have_the_mean_and_the_contact_they_were_made_from(mean, touching):
    gaps = gaussian_gaps(mean_gap=10**mean, touching=10**touching)
    assert gaps.contact_fraction == pytest.approx(10**touching, rel=1e-10)
    places, shares = gaps.rule(gaps.rms)
    assert float(np.sum(places * shares)) == pytest.approx(10**mean, rel=1e-9)


def test_gaps_of_a_surface_are_of_one_contact():
    gaps = SKIN.gaps(5e3)
    assert gaps.contact_fraction == pytest.approx(float(SKIN.real_share(np.asarray(5e3))), rel=1e-10)
    places, shares = gaps.rule(1e-6)
    assert float(np.sum(places * shares)) == pytest.approx(float(SKIN.gap(np.asarray(5e3))), rel=1e-9)
    # the spread comes out near the rms height, although nothing asks for it
    assert 0.5 * SKIN.rms_gap < gaps.rms < 2 * SKIN.rms_gap


@pytest.mark.parametrize(("mean", "touching"), [(0.0, 0.1), (1e-6, 0.51), (1e-6, 0.0), (math.inf, 0.1)])
def test_gaps_outside_the_limits_are_refused(mean, touching):
    with pytest.raises(InputError, match="lower the pressure"):
        gaussian_gaps(mean_gap=mean, touching=touching)


@pytest.mark.parametrize("pressure", [0.0, 1e3, 1e6, 5e6])
def test_growth_is_the_slope_of_the_share(pressure):
    given = {"modulus": 1e7, "slope": 0.7}
    exact = mpmath.diff(lambda p: mpmath.erf(mpmath.sqrt(2) * p / 7e6), pressure)
    assert contact_growth(pressure=pressure, **given) == pytest.approx(float(exact), rel=1e-10)
    assert contact_fraction(1.0, **given) == pytest.approx(contact_growth(pressure=0.0, **given), rel=1e-12)


def test_pull_in_voltage_is_the_printed_formula():
    def voltage(thickness, free_gap=1e-5, **load):
        return pull_in_voltage(stiffness=1e9, free_gap=free_gap, electrical_thickness=thickness, **load)

    assert voltage(1e-6) == pytest.approx(math.sqrt(8 * 1e9 * 1.1e-5**3 / (27 * EPS0)), rel=1e-14)
    assert voltage(2e-5) is None  # g0 = K/2: it closes without a snap
    assert voltage(1.999e-5) is not None
    # a load is a smaller free gap
    assert voltage(1e-6, pressure=1e3) == pytest.approx(voltage(1e-6, free_gap=9e-6), rel=1e-12)
    assert voltage(1e-6, pressure=2e4) is None
    film = 90e-6 / 3.35 + 200e-6 / 1560  # on the founding film a gap below 13 um has none
    assert voltage(film, free_gap=13.4e-6) is None
    assert voltage(film, free_gap=13.6e-6) is not None


# ------------------------------------------------------------------------------ gross and real area


def test_a_fixed_area_is_the_same_under_any_force_and_a_growing_one_follows_its_power():
    contact, growing = FixedArea(area=1e-4), GrowingArea(**GROWING)
    assert contact.gross_area() == contact.gross_area(2.0) == 1e-4
    assert growing.gross_area() == growing.gross_area(0.5) == 1e-4
    assert growing.gross_area(4.0) == pytest.approx(4e-4, rel=1e-14)  # 8^(2/3)
    assert growing.gross_area(0.0) == 0.0
    force = np.array([0.0, 4.0, np.nan])
    np.testing.assert_array_equal(contact.outline(force), [1e-4, 1e-4, np.nan])
    np.testing.assert_allclose(growing.outline(force), [0.0, 4e-4, np.nan], rtol=1e-14)
    assert contact.sliding_length() == pytest.approx(1e-2, rel=1e-15)
    assert growing.sliding_length(4.0) == pytest.approx(2e-2, rel=1e-14)
    assert FixedArea(area=1e-4, length=8e-3).sliding_length() == 8e-3
    with pytest.raises(InputError, match="exponent"):  # which has no default
        read_model(Contact, {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5})


def test_real_area_is_that_of_the_relief_under_the_mean_pressure():
    contact = FixedArea(area=1e-4, surface=SKIN)
    area = contact.real_area(np.array([0.0, 0.5, np.nan]))
    share = math.erf(math.sqrt(2) * 0.5 / 1e-4 / (SKIN.modulus * SKIN.rms_slope))
    assert area == pytest.approx([0, 1e-4 * share, np.nan], rel=1e-12, nan_ok=True)
    assert area[1] < contact.gross_area()
    growing = GrowingArea(**GROWING, surface=SKIN)
    gross = growing.gross_area(0.1)
    assert growing.real_area(0.1) == pytest.approx(gross * float(SKIN.real_share(0.1 / gross)), rel=1e-12)
    assert growing.real_area(0.0) == 0
    # 1.596 F/(E* h') under a small load: why Coulomb's friction does not ask for the gross area
    areas = [float(FixedArea(area=area, surface=SKIN).real_area(0.01)) for area in (5e-5, 1e-4, 2e-4)]
    expected = math.sqrt(8 / math.pi) * 0.01 / (SKIN.modulus * SKIN.rms_slope)
    assert areas == pytest.approx([expected] * 3, rel=1e-6)
    with pytest.raises(InputError, match=r"contact\.surface is not given.*PerssonSurface"):
        FixedArea(area=1e-4).real_area(0.5)
