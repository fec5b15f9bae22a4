"""Fringe field at an edge: closed forms, limits and refusals. tests/reference compares it with the field solution."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from electrovib.core.errors import InputError
from electrovib.physics.fringe import edge_excess, fringe_factor

FILM = {"electrical_thickness": 32e-6, "film_thickness": 90e-6, "film_permittivity": 3.35}
CASES = {
    "ratio": st.floats(-3, 4).map(lambda power: 10**power),
    "permittivity": st.floats(1, 10),
    "share": st.floats(0, 0.99),
}


@pytest.mark.parametrize(
    ("width", "round_contact", "percent"),
    [(2e-3, False, 10.4), (5e-3, False, 4.2), (10e-3, False, 2.1), (20e-3, False, 1.0), (10e-3, True, 4.2)],
)
def test_the_numbers_of_the_document(width, round_contact, percent):
    thickness = 90e-6 / 3.35 + 5e-6 + 200e-6 / 1560
    given = FILM | {"electrical_thickness": thickness, "edge_radius": 0.2e-3}
    factor = fringe_factor(width=width, round_contact=round_contact, **given)
    assert round(100 * (float(factor) - 1), 1) == percent


def in_units_of_thickness(permittivity, share, ratio, scale=1.0):
    film = {"film_thickness": scale * share * permittivity, "film_permittivity": permittivity}
    return film | {"electrical_thickness": scale, "edge_radius": scale * ratio}


def test_a_square_edge_without_a_film_is_the_conformal_map():
    assert edge_excess(electrical_thickness=3e-6) == pytest.approx(3e-6 * 2 / np.pi, rel=1e-14)
    # the field on the bottom of a step, integrated: int_0^1 (1/(1 - u) - 1) sqrt(1 - u)/(pi u) du
    excess, _ = quad(lambda u: (1 / (1 - u) - 1) * np.sqrt(1 - u) / (np.pi * u), 0, 1)
    assert edge_excess(electrical_thickness=1.0) == pytest.approx(excess, rel=1e-8)


@pytest.mark.parametrize("ratio", [1e3, 1e5])
@pytest.mark.parametrize(("permittivity", "share"), [(1.0, 0.0), (3.35, 0.84), (10.0, 0.9)])
def test_a_well_rounded_edge_is_a_slowly_varying_gap(ratio, permittivity, share):
    def per_angle(angle):
        height = 1 + ratio * (1 - np.cos(angle))
        slope = np.tan(angle) if angle < 1 else 0.0  # beyond, of higher order
        film = 1 + 4 * (permittivity**2 - 1) * share**3 / height**3
        return ratio * np.cos(angle) / height**2 * (1 + slope**2 * film / 3)

    near = 10 / np.sqrt(ratio)
    expected = quad(per_angle, 0, near)[0] + quad(per_angle, near, np.pi / 2, limit=200)[0]
    claimed = edge_excess(**in_units_of_thickness(permittivity, share, ratio))
    # the lateral part is of the order of 1/ratio of the wedge, and good to a few tenths of itself
    assert claimed == pytest.approx(expected, rel=3 / ratio + 3e-5)


@settings(max_examples=60, deadline=None)
@given(scale=st.floats(1e-7, 1e3), round_contact=st.booleans(), **CASES)
def test_only_ratios_of_lengths_matter_and_the_film_adds(permittivity, share, ratio, scale, round_contact):
    case = in_units_of_thickness(permittivity, share, ratio)
    scaled = in_units_of_thickness(permittivity, share, ratio, scale)
    whole = fringe_factor(width=200.0, round_contact=round_contact, **case)
    found = fringe_factor(width=200 * scale, round_contact=round_contact, **scaled)
    assert 1 < whole == pytest.approx(found, rel=1e-12)
    bare = edge_excess(electrical_thickness=1.0, edge_radius=ratio)
    assert edge_excess(**case) >= bare * (1 - 1e-2)  # the passage from square to round is fitted
    assert edge_excess(**in_units_of_thickness(1.0, share, ratio)) == pytest.approx(bare, rel=1e-12)


def test_a_wide_contact_needs_no_correction():
    widths = np.geomspace(1e-3, 1e3, 7)
    strip, disc = (
        fringe_factor(width=widths, edge_radius=1e-3, round_contact=each, **FILM) for each in (False, True)
    )
    for factor in (strip, disc):
        assert np.all(np.diff(factor) < 0)
        assert factor[-1] == pytest.approx(1.0, abs=2e-6)
    # the perimeter over the area of a disc is twice that of a strip
    assert disc[-1] - 1 == pytest.approx(2 * (strip[-1] - 1), rel=1e-6)
    factor = fringe_factor(width=np.array([[1e-3], [1e-2]]), edge_radius=np.array([0.0, 1e-4, 1e-3]), **FILM)
    assert factor.shape == (2, 3)
    assert np.all(np.diff(factor, axis=1) > 0)
    alone = fringe_factor(width=1e-2, edge_radius=1e-4, **FILM)
    assert np.ndim(alone) == 0
    assert alone == factor[1, 1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"width": 100e-6}, "width = 0.0001 m"),
        ({"width": np.nan}, "width = nan"),
        ({"width": 500e-6, "round_contact": True}, "10 times film and gap"),
        ({"film_permittivity": 12.0}, "film_permittivity = 12: compared with the field from 1 to 10"),
        ({"film_permittivity": np.nan}, "film_permittivity = nan"),
        ({"electrical_thickness": 27e-6}, "at most 99%"),
        ({"electrical_thickness": 0.0, "film_thickness": 0.0}, "electrical_thickness = 0 m"),
        ({"electrical_thickness": -1e-6}, "electrical_thickness = -1e-06 m: must be finite and not negative"),
        ({"edge_radius": np.inf}, "edge_radius = inf"),
        ({"edge_radius": -1e-3}, "edge_radius = -0.001"),
        ({"film_thickness": np.nan}, "film_thickness = nan"),
    ],
)
def test_what_was_not_compared_with_the_field_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        fringe_factor(**({"width": 5e-3} | FILM | change))


def test_the_limits_themselves_are_allowed_and_every_mistake_is_listed():
    film = {"electrical_thickness": 1.0, "film_thickness": 9.9, "film_permittivity": 10.0}
    assert np.isfinite(edge_excess(**film))
    narrow = 2 * (9.9 + 0.01)
    assert fringe_factor(width=narrow, **film) > 1
    with pytest.raises(InputError, match="2 times film and gap"):
        fringe_factor(width=0.99 * narrow, **film)
    with pytest.raises(InputError) as caught:
        edge_excess(electrical_thickness=-1.0, film_permittivity=0.5, edge_radius=np.nan)
    assert len(caught.value.problems) == 3
