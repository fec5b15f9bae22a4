"""Attraction against the mean gap: plates, and the average over a rough skin with its spots."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from electrovib.core.errors import InputError
from electrovib.papers.ciavarella_2020 import BearingArea
from electrovib.physics.contact import PerssonSurface, PlateAttraction, RoughAttraction
from electrovib.physics.roughness import IdleSpots, LeakingSpots, PullingSpots, local_pull

EPS0 = 8.8541878128e-12
COATING, FILM = 0.378e-6, 27e-6
SURFACES = {kind.__name__: kind.model_validate(dict(kind.example)) for kind in (PerssonSurface, BearingArea)}
SPOTS = {"pulling": PullingSpots(), "idle": IdleSpots()}


def rough(surface="PerssonSurface", spots="pulling", thickness=COATING, voltage=100.0):
    return RoughAttraction(
        voltage=voltage, electrical_thickness=thickness, surface=SURFACES[surface], spots=SPOTS[spots]
    )


def test_plates_are_the_local_pull():
    plates = PlateAttraction(100.0, COATING)
    for gap in (0.0, 1e-6, 3e-5):
        expected = local_pull(100.0, electrical_thickness=COATING, gap=gap)
        assert plates.pressure(gap) == pytest.approx(float(expected), rel=1e-14)
        step = 1e-4 * (COATING + gap)
        difference = (plates.pressure(gap + step) - plates.pressure(gap - step)) / (2 * step)
        assert plates.slope(gap) == pytest.approx(difference, rel=1e-7)  # 2 (step/(K + g))^2


@pytest.mark.parametrize("thickness", [0.0, -1e-6, math.inf, math.nan])
def test_nothing_that_blocks_is_refused(thickness):
    with pytest.raises(InputError, match="is unbounded"):
        PlateAttraction(100.0, thickness)
    with pytest.raises(InputError, match="is unbounded"):
        rough(thickness=thickness)


def by_quadrature(gaps, thickness, voltage):
    """Both parts straight from the definition, apart from the rule of the average."""
    at_spots = gaps.contact_fraction / thickness**2
    edges = [0.0, thickness, 10 * thickness, *(gaps.mean + gaps.rms * np.arange(-3, 9))]
    edges = sorted({edge for edge in edges if edge >= 0})
    between = sum(
        quad(lambda u: float(gaps.density(u)) / (u + thickness) ** 2, low, high, epsabs=0, epsrel=1e-11)[0]
        for low, high in pairwise(edges)
    )
    return EPS0 * voltage**2 / 2 * np.array([at_spots, between])


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("thickness", [COATING, FILM])
@pytest.mark.parametrize("gap", [1e-5, 4e-5, 8e-5])
def test_a_rough_skin_is_the_integral_over_its_gaps(surface, thickness, gap):
    skin = SURFACES[surface]
    gaps = skin.gaps(float(skin.pressure(np.asarray(gap))))
    found = rough(surface, thickness=thickness).parts(gap)
    # quad's own tolerance and what lies beyond 8 rms gaps
    np.testing.assert_allclose([found.spots, found.gaps], by_quadrature(gaps, thickness, 100.0), rtol=1e-8)


def test_idle_spots_take_their_part_away():
    pulling, idle = rough().parts(6e-5), rough(spots="idle").parts(6e-5)
    assert idle.spots == 0
    assert idle.gaps == pytest.approx(pulling.gaps, rel=1e-14)
    held = RoughAttraction(
        voltage=100.0,
        electrical_thickness=COATING,
        surface=SURFACES["PerssonSurface"],
        spots=LeakingSpots(resistivity=1e8),
    )
    assert held.parts(6e-5).spots == 0  # a held voltage: the charge has crossed
    fast = RoughAttraction(
        voltage=100.0,
        electrical_thickness=COATING,
        surface=SURFACES["PerssonSurface"],
        spots=LeakingSpots(resistivity=1e8),
        frequency=1e9,
    )
    assert fast.parts(6e-5).spots == pytest.approx(pulling.spots, rel=1e-6)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("spots", SPOTS)
@pytest.mark.parametrize("thickness", [COATING, FILM])
def test_the_slope_is_the_slope(surface, spots, thickness):
    attraction = rough(surface, spots, thickness)
    for gap in np.geomspace(1.1 * max(attraction.smallest_gap, 1e-6), 2e-4, 12):
        step = 1e-4 * gap
        difference = (attraction.pressure(gap + step) - attraction.pressure(gap - step)) / (2 * step)
        # central difference: third derivative, (step/decay)^2 = 1e-6 at worst
        assert attraction.slope(gap) == pytest.approx(difference, rel=5e-6)


def test_only_plates_are_said_to_fall_ever_less():
    """What the search for all states rests on, and where it must not rest on it."""
    plates = PlateAttraction(100.0, COATING)
    slopes = np.array([plates.slope(gap) for gap in np.geomspace(1e-9, 1e-3, 100)])
    assert plates.convex
    assert np.all(slopes < 0)
    assert np.all(np.diff(slopes) > 0)
    idle = rough(spots="idle", thickness=1e-3)
    assert not idle.convex
    assert idle.slope(1.01 * idle.smallest_gap) > 0  # what touches pulls no more


def test_half_of_the_area_touches_at_the_smallest_gap():
    attraction = rough()
    skin = SURFACES["PerssonSurface"]
    share = skin.real_share(skin.pressure(np.asarray(attraction.smallest_gap)))
    assert share == pytest.approx(0.5, rel=1e-9)
    with pytest.raises(InputError, match="Gaussian"):
        attraction.pressure(0.9 * attraction.smallest_gap)
    soft = PerssonSurface(**{**PerssonSurface.example, "pressure_factor": 0.01})
    assert RoughAttraction(
        voltage=1.0, electrical_thickness=COATING, surface=soft, spots=PullingSpots()
    ).smallest_gap == pytest.approx(1e-9 * COATING)
