"""Surface topography under pressure: repulsion and gap are inverse, slopes are slopes, gaps have the contact's own share."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.physics.contact import LinearSpring, PerssonSurface, Surface, pull_in_voltage
from electrovib.physics.contact.rough_surface import gaussian_gaps
from electrovib.physics.roughness import contact_fraction, contact_growth

EPS0 = 8.8541878128e-12


@pytest.fixture(params=sorted(find_members(Surface)))
def surface(request):
    kind = find_members(Surface)[request.param]
    return kind.model_validate(dict(kind.example))


def test_members_are_found():
    assert {"LinearSpring", "PerssonSurface", "BearingArea"} <= set(find_members(Surface))


def test_gap_and_repulsion_are_inverse(surface):
    gaps = np.linspace(1e-7, 9e-6, 20)
    np.testing.assert_allclose(surface.gap(surface.pressure(gaps)), gaps, rtol=1e-12)


def test_repulsion_falls_ever_less_and_its_slope_is_its_slope(surface):
    gaps = np.linspace(0.0, 3e-5, 301)
    pressure, slope = surface.pressure(gaps), surface.slope(gaps)
    assert np.all(np.diff(pressure) < 0)
    assert np.all(np.diff(slope) >= 0)
    differences = (pressure[2:] - pressure[:-2]) / (gaps[2:] - gaps[:-2])
    # central difference: (step/decay)^2/6 = 2e-5 for a decay of 10 um
    np.testing.assert_allclose(slope[1:-1], differences, rtol=5e-5)


def test_a_flat_relief_keeps_no_gap(surface):
    flat = float(surface.pressure(np.asarray(0.0)))
    assert surface.gap(np.asarray(2 * flat)) == 0


def test_the_touching_share_grows_to_one(surface):
    share = surface.real_share(np.geomspace(1.0, 1e12, 50))
    assert np.all(np.diff(share) >= 0)
    assert share[-1] == pytest.approx(1.0, abs=1e-15)
    assert np.all(share >= 0)


def test_a_spring_touches_when_it_is_closed():
    spring = LinearSpring(stiffness=1e9, free_gap=1e-5)
    assert spring.real_share(np.array([0.0, 9999.0, 10000.0, 1e6])).tolist() == [0, 0, 1, 1]
    with pytest.raises(InputError, match="no distribution of gaps"):
        spring.gaps(100.0)
    with pytest.raises(InputError, match="PerssonSurface"):
        spring.real_growth(100.0)


def test_nothing_pressing_is_no_bound():
    assert np.isinf(PerssonSurface(**PerssonSurface.example).gap(np.asarray(0.0)))


@given(mean=st.floats(-8, -4), touching=st.floats(-12, math.log10(0.5)))
def test_gaps_have_the_mean_and_the_contact_they_were_made_from(mean, touching):
    gaps = gaussian_gaps(mean_gap=10**mean, touching=10**touching)
    assert gaps.contact_fraction == pytest.approx(10**touching, rel=1e-10)
    places, shares = gaps.rule(gaps.rms)
    assert float(np.sum(places * shares)) == pytest.approx(10**mean, rel=1e-9)


def test_gaps_of_a_surface_are_of_one_contact():
    skin = PerssonSurface(**PerssonSurface.example)
    gaps = skin.gaps(5e3)
    assert gaps.contact_fraction == pytest.approx(float(skin.real_share(np.asarray(5e3))), rel=1e-10)
    places, shares = gaps.rule(1e-6)
    assert float(np.sum(places * shares)) == pytest.approx(float(skin.gap(np.asarray(5e3))), rel=1e-9)
    # the spread comes out near the rms height, although nothing asks for it
    assert 0.5 * skin.rms_gap < gaps.rms < 2 * skin.rms_gap


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
    found = pull_in_voltage(stiffness=1e9, free_gap=1e-5, electrical_thickness=1e-6)
    assert found == pytest.approx(math.sqrt(8 * 1e9 * 1.1e-5**3 / (27 * EPS0)), rel=1e-14)
    assert (
        pull_in_voltage(stiffness=1e9, free_gap=1e-5, electrical_thickness=2e-5) is None
    )  # g0 = K/2: it closes without a snap
    assert pull_in_voltage(stiffness=1e9, free_gap=1e-5, electrical_thickness=1.999e-5) is not None
    # a load is a smaller free gap
    loaded = pull_in_voltage(stiffness=1e9, free_gap=1e-5, electrical_thickness=1e-6, pressure=1e3)
    assert loaded == pytest.approx(
        pull_in_voltage(stiffness=1e9, free_gap=9e-6, electrical_thickness=1e-6), rel=1e-12
    )
    assert pull_in_voltage(stiffness=1e9, free_gap=1e-5, electrical_thickness=1e-6, pressure=2e4) is None


def test_on_the_founding_film_a_gap_below_13_um_has_no_pull_in():
    film = 90e-6 / 3.35 + 200e-6 / 1560
    assert pull_in_voltage(stiffness=1e9, free_gap=13.4e-6, electrical_thickness=film) is None
    assert pull_in_voltage(stiffness=1e9, free_gap=13.6e-6, electrical_thickness=film) is not None
