"""Contact: surfaces under pressure, gross and real area, gaps and the attraction over them."""

import math
from statistics import NormalDist

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.contact import (
    Contact,
    FittedSurface,
    FixedArea,
    GrowingArea,
    LinearSpring,
    PerssonSurface,
    PlateAttraction,
    RoughAttraction,
    Surface,
)
from electrovib.physics.contact.surface import gaussian_gaps
from electrovib.physics.roughness import (
    ContactSpots,
    GaussianGaps,
    IdleSpots,
    LeakingSpots,
    PullingSpots,
    contact_fraction,
    contact_growth,
    local_pull,
    mean_pull,
)

EPS0 = 8.8541878128e-12
COATING, FILM = 0.378e-6, 27e-6
GROWING = {"area": 1e-4, "at_force": 0.5, "exponent": 2 / 3}
PULLING, IDLE, LEAKING = PullingSpots(), IdleSpots(), LeakingSpots(resistivity=1e8)
SURFACES = {name: kind.model_validate(dict(kind.example)) for name, kind in find_members(Surface).items()}
SKIN = SURFACES["PerssonSurface"]
STIFF = FittedSurface(modulus=1e8, rms_height=2e-5, rms_slope=0.5)
lengths = st.floats(-9.0, -4.0).map(lambda power: 10.0**power)


def pull(gaps, electrical=COATING, voltage=1.0, spots=PULLING, **more):
    return mean_pull(voltage, electrical_thickness=electrical, gaps=gaps, spots=spots, **more)


def ratio(electrical, rms, in_rms):
    """Averaged pull over the pull at the mean gap."""
    gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
    at_mean = local_pull(1.0, electrical_thickness=electrical, gap=gaps.mean)
    return float(pull(gaps, electrical).total / at_mean)


def by_panels(electrical, gaps):
    """Integral of P(u)/|u + h|^2 over panels that grow away from contact, where P may be infinite, and are short against P."""
    size, end = abs(electrical), gaps.rms * (gaps.mean / gaps.rms + 10) ** gaps.power
    near = np.geomspace(1e-14 * min(size, end), end, 240)
    edges = np.concatenate([[0.0], near, np.linspace(max(0.0, gaps.mean - 10 * gaps.rms), end, 120)])
    points, weights = np.polynomial.legendre.leggauss(16)
    edges = np.unique(edges)
    half = np.diff(edges)[:, None] / 2
    places = edges[:-1, None] + half * (1 + points)
    return float(np.sum(half * weights * gaps.density(places) / np.abs(places + electrical) ** 2))


def test_ratios_of_the_average_to_the_pull_at_the_mean_gap():
    expected = {5e-6: (36, 22, 4.5), 22e-6: (571, 329, 46)}  # on the coat, at a mean of 1, 2 and 3 rms
    found = {rms: [ratio(COATING, rms, in_rms) for in_rms in (1, 2, 3)] for rms in expected}
    for rms, values in expected.items():
        assert found[rms] == pytest.approx(values, rel=1.2e-2)  # two digits
    assert ratio(1.1 * COATING, 5e-6, 1) != pytest.approx(36, rel=1.2e-2)
    for rms in (1e-6, 5e-6, 22e-6):
        assert all(0.95 < ratio(FILM, rms, in_rms) < 1.45 for in_rms in (1, 2, 3))  # 1.0 to 1.4, one digit
    pulls = [pull(GaussianGaps(mean=in_rms * rms, rms=rms)) for rms in expected for in_rms in (1, 2, 3)]
    shares = [float(each.spots / each.total) for each in pulls]
    assert (min(shares), max(shares)) == pytest.approx((0.50, 0.97), abs=5e-3)  # two digits


@pytest.mark.parametrize(("fraction", "expect"), [(1e-4, 15.0), (1e-3, 155.0), (1e-2, 1550.0)])
def test_what_a_share_in_contact_adds(fraction, expect):
    """100 V at alternating voltage on the coating."""
    gaps = GaussianGaps(mean=-NormalDist().inv_cdf(fraction) * 5e-6, rms=5e-6)
    assert gaps.contact_fraction == pytest.approx(fraction, rel=1e-9)
    # two digits
    assert float(pull(gaps, voltage=100 / math.sqrt(2)).spots) == pytest.approx(expect, rel=4e-2)


def test_a_sine_pulls_half_of_its_peak():
    mean = local_pull(100.0 / math.sqrt(2), electrical_thickness=COATING, gap=[0.0, 3e-6, 10e-6])
    np.testing.assert_allclose(mean, [155e3, 1.94e3, 206.0], rtol=3e-3)  # three digits


@given(mean=lengths | st.just(0.0), rms=lengths, size=lengths, angle=st.floats(0.0, 1.4))
@settings(max_examples=60, deadline=None)
def test_the_rule_against_many_panels(mean, rms, size, angle):
    gaps, electrical = GaussianGaps(mean=min(mean, 30 * rms), rms=rms), size * np.exp(-1j * angle)
    found, expected = pull(gaps, electrical), EPS0 / 2 * by_panels(electrical, gaps)
    # 96 nodes: 1e-9 at worst, the panels less
    assert abs(float(found.gaps) - expected) < 1e-8 * float(found.total)


@given(mean=lengths, rms=lengths, near=lengths)
@settings(max_examples=50, deadline=None)
def test_shares_and_spots_are_the_whole_area(mean, rms, near):
    gaps = GaussianGaps(mean=min(mean, 30 * rms), rms=rms)
    places, shares = gaps.rule(near, count=96)
    assert np.all(places >= 0)
    assert np.all(shares >= 0)
    # nodes are dense near contact; of a density alone they keep 6 digits when near is 1e-5 of the roughness
    assert float(np.sum(shares)) + gaps.contact_fraction == pytest.approx(1.0, abs=1e-6)


def test_a_smooth_skin_has_one_gap_and_shapes_broadcast():
    gaps = GaussianGaps(mean=3e-6, rms=1e-10)
    assert gaps.contact_fraction == 0
    alone = local_pull(100.0, electrical_thickness=COATING, gap=3e-6)
    # second moment: 3 (rms/(u + h))^2
    assert float(pull(gaps, voltage=100.0).total) == pytest.approx(float(alone), rel=1e-8)
    gaps, second = GaussianGaps(mean=5e-6, rms=5e-6), (2.0 - 0.1j) * COATING
    thickness = np.array([[COATING], [second]])
    many = pull(gaps, thickness, spots=LEAKING, frequency=[1.0, 1e2, 1e4]).total
    assert many.shape == (2, 3)
    one = pull(gaps, second, spots=LEAKING, frequency=1e2).total
    assert many[1, 1] == pytest.approx(float(one), rel=1e-13)


def test_kinds_of_spots():
    gaps, frequency = GaussianGaps(mean=5e-6, rms=5e-6), np.array([0.0, 1.0, 1e9])
    pulling, leaking, idle = (
        pull(gaps, spots=each, frequency=frequency).spots for each in (PULLING, LEAKING, IDLE)
    )
    np.testing.assert_array_equal(idle, 0.0)
    assert leaking[0] == 0
    phase = 2 * np.pi * 1.0 * EPS0 * 1e8
    assert leaking[1] == pytest.approx(pulling[1] * phase**2 / (1 + phase**2), rel=1e-12)
    assert leaking[2] == pytest.approx(pulling[2], rel=1e-9)
    assert pulling[0] == pytest.approx(EPS0 / 2 * gaps.contact_fraction / COATING**2, rel=1e-14)
    leaks = {"IdleSpots": {}, "PullingSpots": {}, "LeakingSpots": {"resistivity": "2 ohm m"}}
    found = [read_model(ContactSpots, {"model": name} | content).leak for name, content in leaks.items()]
    assert found == [None, 0, 0.5]


def test_real_contact_between_its_limits():
    """For small pressures 1.596 p/(E* h'), for large ones 1; never more than proportional to the pressure."""
    pressure = np.geomspace(1.0, 1e9, 200)
    share = contact_fraction(pressure, modulus=1e7, slope=0.5)
    proportional = 1.596 * pressure / (1e7 * 0.5)
    assert share[0] == pytest.approx(proportional[0], rel=3e-4)  # four digits
    assert share[-1] == 1
    assert np.all(np.diff(share) >= 0)
    assert np.all(share <= proportional * 1.0003)


def rough(surface=SKIN, thickness=COATING, voltage=100.0, spots=PULLING, **more):
    return RoughAttraction(
        voltage=voltage, electrical_thickness=thickness, surface=surface, spots=spots, **more
    )


def test_plates_are_the_local_pull_and_fall_ever_less():
    """What the search for all states rests on, and where it must not rest on it."""
    plates = PlateAttraction(100.0, COATING)
    for gap in (0.0, 1e-6, 3e-5):
        expected = local_pull(100.0, electrical_thickness=COATING, gap=gap)
        assert plates.pressure(gap) == pytest.approx(float(expected), rel=1e-14)
        step = 1e-4 * (COATING + gap)
        difference = (plates.pressure(gap + step) - plates.pressure(gap - step)) / (2 * step)
        assert plates.slope(gap) == pytest.approx(difference, rel=1e-7)  # 2 (step/(K + g))^2
    slopes = np.array([plates.slope(gap) for gap in np.geomspace(1e-9, 1e-3, 100)])
    assert plates.convex
    assert np.all(slopes < 0)
    assert np.all(np.diff(slopes) > 0)
    idle = rough(thickness=1e-3, spots=IDLE)
    assert not idle.convex
    assert idle.slope(1.01 * idle.smallest_gap) > 0  # what touches pulls no more


@pytest.mark.parametrize("surface", [SKIN, SURFACES["BearingArea"], STIFF])
@pytest.mark.parametrize("thickness", [COATING, FILM])
def test_a_rough_skin_is_the_integral_over_its_gaps_with_its_slope(surface, thickness):
    attraction, idle = rough(surface, thickness), rough(surface, thickness, spots=IDLE)
    for gap in (1e-5, 4e-5, 8e-5):
        gaps = surface.gaps(float(surface.pressure(np.asarray(gap))))
        between = by_panels(thickness, gaps)
        expected = EPS0 * 100.0**2 / 2 * np.array([gaps.contact_fraction / thickness**2, between])
        found = attraction.parts(gap)
        np.testing.assert_allclose([found.spots, found.gaps], expected, rtol=1e-8)
        assert attraction.total(gap) == pytest.approx(expected.sum(), rel=1e-8)
        assert idle.total(gap) == idle.pressure(gap) == pytest.approx(expected[1], rel=1e-8)
        assert attraction.pressure(gap) == pytest.approx(
            expected.sum() - surface.held * expected[0], rel=1e-8
        )
    for each in (attraction, idle):
        for gap in np.geomspace(1.1 * max(each.smallest_gap, 1e-6), 2e-4, 12):
            step = 1e-4 * gap
            difference = (each.pressure(gap + step) - each.pressure(gap - step)) / (2 * step)
            # central difference: third derivative, (step/decay)^2 = 1e-6 at worst
            assert each.slope(gap) == pytest.approx(difference, rel=5e-6)


def test_idle_and_leaking_spots_take_their_part_away():
    pulling, idle = rough().parts(6e-5), rough(spots=IDLE).parts(6e-5)
    assert idle.spots == 0
    assert idle.gaps == pytest.approx(pulling.gaps, rel=1e-14)
    assert rough(spots=LEAKING).parts(6e-5).spots == 0  # a held voltage: the charge has crossed
    fast = rough(spots=LEAKING, frequency=1e9).parts(6e-5)
    assert fast.spots == pytest.approx(pulling.spots, rel=1e-6)


def test_half_of_the_area_touches_at_the_smallest_gap():
    attraction = rough()
    share = SKIN.real_share(SKIN.pressure(np.asarray(attraction.smallest_gap)))
    assert share == pytest.approx(0.5, rel=1e-9)
    with pytest.raises(InputError, match="Gaussian"):
        attraction.pressure(0.9 * attraction.smallest_gap)
    soft = PerssonSurface(**{**PerssonSurface.example, "pressure_factor": 0.01})
    assert rough(soft, voltage=1.0).smallest_gap == pytest.approx(1e-9 * COATING)


@pytest.mark.parametrize("thickness", [0.0, -1e-6, math.inf, math.nan])
def test_nothing_that_blocks_is_refused(thickness):
    with pytest.raises(InputError, match="is unbounded"):
        PlateAttraction(100.0, thickness)
    with pytest.raises(InputError, match="is unbounded"):
        rough(thickness=thickness)


@pytest.mark.parametrize(
    ("mean", "rms", "words"),
    [(-1e-6, 1e-6, "mean = -1e-06"), (math.nan, 1e-6, "mean = nan"), (1e-6, 0.0, "rms = 0.0")],
)
def test_what_is_no_distribution_is_refused(mean, rms, words):
    with pytest.raises(InputError, match=words):
        GaussianGaps(mean=mean, rms=rms)


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_every_surface_repels_ever_less_and_touches_ever_more(surface):
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


@given(
    mean=st.floats(-8, -4), touching=st.floats(-12, math.log10(0.5)), power=st.sampled_from([1.0, 4 / 3, 1.5])
)
def test_gaps_have_the_mean_and_the_contact_they_were_made_from(mean, touching, power):
    gaps = gaussian_gaps(mean_gap=10**mean, touching=10**touching, power=power)
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


def test_gaps_of_a_power_of_a_gaussian():
    """Of power 2 and mean 0 the mean gap is rms/2 and the attraction by mpmath's quadrature over the Gaussian."""
    gaps = GaussianGaps(mean=0.0, rms=3e-6, power=2.0)
    places, shares = gaps.rule(1e-6)
    assert float(np.sum(places * shares)) == pytest.approx(1.5e-6, rel=1e-9)
    assert float(gaps.share_up_to(3e-6)) == pytest.approx(NormalDist().cdf(1.0), rel=1e-12)
    for power in (1.0, 4 / 3):
        gaps = GaussianGaps(mean=2e-6, rms=2e-6, power=power)

        def at(y, power=power):
            gap = 2e-6 * y**power
            return mpmath.npdf(y - 1) / (gap + COATING) ** 2

        between = mpmath.quad(at, [0, 0.1, 0.5, 1, 2, 4, 10])
        assert float(pull(gaps).gaps) == pytest.approx(EPS0 / 2 * float(between), rel=1e-7)
    with pytest.raises(InputError, match=r"power = 0\.9: from 1"):
        GaussianGaps(mean=1e-6, rms=1e-6, power=0.9)


def test_the_corrected_law_is_its_six_numbers_and_ends_where_it_was_fitted():
    surface = FittedSurface(modulus=2e6, rms_height=5e-6, rms_slope=0.2)
    reduced = 1e4 / (2e6 * 0.2)
    share = float(surface.real_share(np.asarray(1e4)))
    assert share == pytest.approx(math.erf(math.sqrt(2) * 1.29 * reduced**0.974), rel=1e-12)
    step = (surface.real_share(np.asarray(1.0001e4)) - surface.real_share(np.asarray(0.9999e4))) / 2.0
    assert surface.real_growth(1e4) == pytest.approx(float(step), rel=1e-6)  # central difference
    assert surface.gap(np.asarray(1e4)) == pytest.approx(0.451 * 5e-6 * math.log(0.362 / reduced), rel=1e-12)
    assert (surface.gaps(1e4).power, surface.held) == (4 / 3, 0.7)
    within = surface.diagnostics([0.0, 0.01, 0.2])[0]
    assert (within.state, "within 15 %" in within.text) == ("ok", True)
    for changed, shares, words in (
        ({"rms_height": 4e-5}, [0.1], "rms_height = 40 um (fitted: 500 nm to 30 um)"),
        ({"rms_slope": 1.0}, [0.1], "rms_slope = 1 (fitted: 0.04 to 0.7)"),
        ({}, [2e-4, 0.1], "real over gross contact area = 0.0002 (fitted: 0.001 to 0.5)"),
        ({}, [0.1, 0.6], "real over gross contact area = 0.6 "),
    ):
        (outside,) = surface.model_copy(update=changed).diagnostics(shares)
        assert outside.state == "warning"
        assert words in outside.text
    (published,) = SKIN.diagnostics([0.1])
    assert (published.state, "0.55 to 1 (median 0.74)" in published.text) == ("warning", True)


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
