"""Intervals from profiles with known ends."""

import math

import pytest

from electrovib.recordings.interval import profile_interval


def test_a_parabola_gives_the_symmetric_interval():
    found = profile_interval(
        lambda x: ((x - 2) / 0.5) ** 2, 2.0, deviation=0.3, bounds=(-math.inf, math.inf), allowed=3.8415
    )
    assert (found.lower, found.upper) == pytest.approx((2 - 1.96 * 0.5, 2 + 1.96 * 0.5), rel=1e-3)


def test_a_parabola_in_the_logarithm_gives_equal_factors():
    found = profile_interval(
        lambda x: (math.log(x / 3) / 2) ** 2,
        3.0,
        deviation=math.inf,
        bounds=(0.0, math.inf),
        allowed=4.0,
        logarithmic=True,
    )
    assert (found.lower, found.upper) == pytest.approx((3 * math.exp(-4), 3 * math.exp(4)), rel=1e-2)


@pytest.mark.parametrize("logarithmic", [True, False])
def test_what_saturates_or_meets_a_bound_is_open(logarithmic):
    found = profile_interval(
        lambda x: 3 * (1 - 1 / x) if x > 1 else 100 * (1 - x) ** 2,
        1.0,
        deviation=0.1,
        bounds=(0.5, 1e9),
        allowed=4.0,
        logarithmic=logarithmic,
    )
    assert (found.upper, found.open_above) == (1e9, True)
    assert (found.lower, found.open_below) == (pytest.approx(0.8, rel=1e-2), False)


def test_a_profile_that_ends_where_there_is_no_prediction_is_open_there():
    found = profile_interval(
        lambda x: math.inf if x > 2 else (x - 1) ** 2, 1.0, deviation=0.4, bounds=(0.0, 9.0), allowed=3.0
    )
    assert found.open_above
    assert 1 < found.upper <= 2
    assert (found.lower, found.open_below) == (0.0, True)
