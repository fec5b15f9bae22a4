"""Gap distributions: the rule of the average, the part that touches, the kinds of spots, real contact."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.roughness import (
    ContactSpots,
    GaussianGaps,
    IdleSpots,
    LeakingSpots,
    PullingSpots,
    contact_fraction,
    local_pull,
    mean_pull,
)

EPS0 = 8.8541878128e-12
COATING, FILM = 0.378e-6, 27e-6
lengths = st.floats(-9.0, -4.0).map(lambda power: 10.0**power)


def ratio(electrical, rms, in_rms):
    """Averaged pull over the pull at the mean gap."""
    gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
    total = mean_pull(1.0, electrical_thickness=electrical, gaps=gaps, spots=PullingSpots()).total
    return float(total / local_pull(1.0, electrical_thickness=electrical, gap=gaps.mean))


def by_panels(electrical, gaps):
    """Integral of P(u)/|u + h|^2 over panels that grow away from contact and are short against the Gaussian."""
    size, end = abs(electrical), gaps.mean + 10 * gaps.rms
    edges = np.concatenate(
        [
            [0.0],
            np.geomspace(1e-3 * min(size, end), end, 120),
            np.linspace(max(0.0, gaps.mean - 10 * gaps.rms), end, 60),
        ]
    )
    points, weights = np.polynomial.legendre.leggauss(16)
    edges = np.unique(edges)
    half = np.diff(edges)[:, None] / 2
    places = edges[:-1, None] + half * (1 + points)
    return float(np.sum(half * weights * gaps.density(places) / np.abs(places + electrical) ** 2))


@pytest.mark.parametrize(
    ("rms", "in_rms", "expect"),
    [(5e-6, 1, 36), (5e-6, 2, 22), (5e-6, 3, 4.5), (22e-6, 1, 571), (22e-6, 2, 329), (22e-6, 3, 46)],
)
def test_ratio_on_the_coat(rms, in_rms, expect):
    assert ratio(COATING, rms, in_rms) == pytest.approx(expect, rel=1.2e-2)  # two digits
    assert ratio(1.1 * COATING, rms, in_rms) != pytest.approx(expect, rel=1.2e-2)


@pytest.mark.parametrize("rms", [1e-6, 5e-6, 22e-6])
@pytest.mark.parametrize("in_rms", [1, 2, 3])
def test_ratio_on_the_film(rms, in_rms):
    assert 0.95 < ratio(FILM, rms, in_rms) < 1.45  # 1.0 to 1.4, one digit


def test_most_of_the_pull_on_a_coat_is_carried_by_the_spots():
    shares = []
    for rms in (5e-6, 22e-6):
        for in_rms in (1, 2, 3):
            gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
            pull = mean_pull(1.0, electrical_thickness=COATING, gaps=gaps, spots=PullingSpots())
            shares.append(float(pull.spots / pull.total))
    assert (min(shares), max(shares)) == pytest.approx((0.50, 0.97), abs=5e-3)  # two digits


@pytest.mark.parametrize(("fraction", "expect"), [(1e-4, 15.0), (1e-3, 155.0), (1e-2, 1550.0)])
def test_what_a_share_in_contact_adds(fraction, expect):
    """100 V at alternating voltage on the coating."""
    from statistics import NormalDist

    gaps = GaussianGaps(mean=-NormalDist().inv_cdf(fraction) * 5e-6, rms=5e-6)
    assert gaps.contact_fraction == pytest.approx(fraction, rel=1e-9)
    pull = mean_pull(100 / math.sqrt(2), electrical_thickness=COATING, gaps=gaps, spots=PullingSpots())
    assert float(pull.spots) == pytest.approx(expect, rel=4e-2)  # two digits


@given(mean=lengths | st.just(0.0), rms=lengths, size=lengths, angle=st.floats(0.0, 1.4))
@settings(max_examples=60, deadline=None)
def test_the_rule_against_many_panels(mean, rms, size, angle):
    gaps, electrical = GaussianGaps(mean=min(mean, 30 * rms), rms=rms), size * np.exp(-1j * angle)
    pull = mean_pull(1.0, electrical_thickness=electrical, gaps=gaps, spots=PullingSpots())
    expected = EPS0 / 2 * by_panels(electrical, gaps)
    assert abs(float(pull.gaps) - expected) < 1e-8 * float(
        pull.total
    )  # 96 nodes: 1e-9 at worst, the panels less


@given(mean=lengths, rms=lengths, near=lengths)
@settings(max_examples=50, deadline=None)
def test_shares_and_spots_are_the_whole_area(mean, rms, near):
    gaps = GaussianGaps(mean=min(mean, 30 * rms), rms=rms)
    places, shares = gaps.rule(near, count=96)
    assert np.all(places >= 0)
    assert np.all(shares >= 0)
    # nodes are dense near contact; of a density alone they keep 6 digits when near is 1e-5 of the roughness
    assert float(np.sum(shares)) + gaps.contact_fraction == pytest.approx(1.0, abs=1e-6)


def test_a_smooth_skin_has_one_gap():
    gaps = GaussianGaps(mean=3e-6, rms=1e-10)
    assert gaps.contact_fraction == 0
    pull = mean_pull(100.0, electrical_thickness=COATING, gaps=gaps, spots=PullingSpots())
    alone = local_pull(100.0, electrical_thickness=COATING, gap=3e-6)
    # second moment: 3 (rms/(u + h))^2
    assert float(pull.total) == pytest.approx(float(alone), rel=1e-8)


def test_a_sine_pulls_half_of_its_peak():
    peak = local_pull(100.0, electrical_thickness=COATING, gap=[0.0, 3e-6, 10e-6])
    mean = local_pull(100.0 / math.sqrt(2), electrical_thickness=COATING, gap=[0.0, 3e-6, 10e-6])
    np.testing.assert_allclose(mean, peak / 2, rtol=1e-14)
    np.testing.assert_allclose(mean, [155e3, 1.94e3, 206.0], rtol=3e-3)  # three digits
    assert abs(mean[2] / 204.0 - 1) > 3e-3


def test_shapes_broadcast():
    gaps = GaussianGaps(mean=5e-6, rms=5e-6)
    thickness = COATING * np.array([[1.0], [2.0 - 0.1j]])
    spots = LeakingSpots(resistivity=1e8)
    many = mean_pull(
        10.0, electrical_thickness=thickness, gaps=gaps, spots=spots, frequency=[1.0, 1e2, 1e4]
    ).total
    assert many.shape == (2, 3)
    alone = mean_pull(
        10.0, electrical_thickness=2 * COATING - 0.1j * COATING, gaps=gaps, spots=spots, frequency=1e2
    )
    assert many[1, 1] == pytest.approx(float(alone.total), rel=1e-13)


def test_kinds_of_spots():
    gaps, frequency = GaussianGaps(mean=5e-6, rms=5e-6), np.array([0.0, 1.0, 1e9])

    def spots_pull(spots):
        return mean_pull(1.0, electrical_thickness=COATING, gaps=gaps, spots=spots, frequency=frequency).spots

    pulling, leaking = spots_pull(PullingSpots()), spots_pull(LeakingSpots(resistivity=1e8))
    np.testing.assert_array_equal(spots_pull(IdleSpots()), 0.0)
    assert leaking[0] == 0
    phase = 2 * np.pi * 1.0 * EPS0 * 1e8
    assert leaking[1] == pytest.approx(pulling[1] * phase**2 / (1 + phase**2), rel=1e-12)
    assert leaking[2] == pytest.approx(pulling[2], rel=1e-9)
    assert pulling[0] == pytest.approx(EPS0 / 2 * gaps.contact_fraction / COATING**2, rel=1e-14)


def test_spots_are_objects_by_name():
    assert read_model(ContactSpots, {"model": "IdleSpots"}).leak is None
    assert read_model(ContactSpots, {"model": "PullingSpots"}).leak == 0
    assert read_model(ContactSpots, {"model": "LeakingSpots", "resistivity": "2 ohm m"}).leak == 0.5
    with pytest.raises(InputError, match="needs a name"):
        read_model(ContactSpots, {})


@pytest.mark.parametrize(
    ("mean", "rms", "words"),
    [(-1e-6, 1e-6, "mean = -1e-06"), (math.nan, 1e-6, "mean = nan"), (1e-6, 0.0, "rms = 0.0")],
)
def test_what_is_no_distribution_is_refused(mean, rms, words):
    with pytest.raises(InputError, match=words):
        GaussianGaps(mean=mean, rms=rms)


def test_real_contact_between_its_limits():
    """For small pressures 1.596 p/(E* h'), for large ones 1; never more than proportional to the pressure."""
    pressure = np.geomspace(1.0, 1e9, 200)
    share = contact_fraction(pressure, modulus=1e7, slope=0.5)
    proportional = 1.596 * pressure / (1e7 * 0.5)
    assert share[0] == pytest.approx(proportional[0], rel=3e-4)  # four digits
    assert share[0] != pytest.approx(1.01 * proportional[0], rel=3e-4)
    assert share[-1] == 1
    assert np.all(np.diff(share) >= 0)
    assert np.all(share <= proportional * 1.0003)


def test_nan_in_a_frequency_is_handed_on():
    for spots in (PullingSpots(), IdleSpots(), LeakingSpots(resistivity=1e8)):
        share = spots.field_share(np.array([1.0, np.nan]))
        assert np.isfinite(share[0])
        assert np.isnan(share[1])
