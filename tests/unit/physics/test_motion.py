"""TimeProfiles of load and speed, and distances of a finger held off the plate."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.friction import Load
from electrovib.physics.motion import Distance, Motion, TouchAndLift, TremblingDistance
from electrovib.physics.time_profile import Corners, LiftOff, Press, Steady, Swipe, TimeProfile


@pytest.mark.parametrize(
    ("time_profile", "times", "shares"),
    [
        (Steady(), [0, 1], [1, 1]),
        (Press(begin=0.1, rise=0.1), [0, 0.1, 0.15, 0.2, 9], [0, 0, 0.5, 1, 1]),
        (LiftOff(begin=0.1, fall=0.1), [0, 0.1, 0.15, 0.2, 9], [1, 1, 0.5, 0, 0]),
        (Swipe(rise=0.1, hold=0.2, fall=0.1), [0, 0.05, 0.1, 0.3, 0.35, 1], [0, 0.5, 1, 1, 0.5, 0]),
        (Swipe(rise=0.1, hold=0.0, fall=0.1), [0, 0.1, 0.15], [0, 1, 0.5]),
    ],
)
def test_shares(time_profile, times, shares):
    np.testing.assert_allclose(time_profile.share(times), shares, atol=1e-12)


def test_a_load_follows_its_programme():
    load = Load(normal_force=0.4, time_profile=Press(rise=0.1))
    np.testing.assert_allclose(load.forces([0.0, 0.05, 1.0]), [0.0, 0.2, 0.4])


def test_corners_must_be_in_order():
    points = [{"time": 0.2, "share": 1.0}, {"time": 0.1, "share": 0.0}]
    with pytest.raises(InputError, match="order"):
        read_model(TimeProfile, {"model": "Corners", "points": points})


def test_touch_and_lift_goes_near_and_away():
    distance = TouchAndLift(far=1e-3, near=1e-6, begin=0.1, approach=0.2, touch=0.1, lift=0.2)
    found = distance.gap([0.0, 0.1, 0.2, 0.3, 0.35, 0.4, 0.5, 0.6, 1.0])
    middle = np.sqrt(1e-3 * 1e-6)
    np.testing.assert_allclose(found, [1e-3, 1e-3, middle, 1e-6, 1e-6, 1e-6, middle, 1e-3, 1e-3], rtol=1e-12)
    assert distance.breaks() == pytest.approx((0.1, 0.3, 0.4, 0.6))


def test_a_tremor_stays_off_the_plate():
    held = TremblingDistance(mean=100e-6, amplitude=10e-6, frequency=8.0)
    assert held.gap(1 / 32) == pytest.approx(110e-6)
    with pytest.raises(InputError, match="amplitude"):
        read_model(Distance, {"model": "TremblingDistance", "mean": 1e-4, "amplitude": 1e-4, "frequency": 8})


@pytest.mark.parametrize(
    "distance",
    [
        TouchAndLift(far=1e-3, near=1e-6, begin=0.1, approach=0.2, touch=0.1, lift=0.2),
        TremblingDistance(mean=100e-6, amplitude=30e-6, frequency=8.0),
    ],
)
def test_the_rate_is_that_of_the_distance(distance):
    """Against central differences; 0 where the finger stays."""
    times, step = np.linspace(0, 0.7, 1000), 1e-6
    expected = (distance.gap(times + step) - distance.gap(times - step)) / (2 * step)
    found = distance.rate(times)
    assert np.max(np.abs(found - expected)) < 1e-6 * np.max(np.abs(expected))
    assert np.isnan(distance.rate(np.nan))
    if isinstance(distance, TouchAndLift):
        assert np.all(distance.rate(np.array([0.0, 0.35, 0.65])) == 0)


def test_renewal_and_distance_exclude_each_other():
    held = {"model": "TremblingDistance", "mean": 1e-4, "amplitude": 1e-5, "frequency": 8}
    with pytest.raises(InputError, match="distance"):
        read_model(Motion, {"speed": 0.03, "renews_film": True, "distance": held})


def test_an_amplifier_aims_and_clips():
    amplifier = Amplifier(gain=100.0, saturation=150.0)
    np.testing.assert_allclose(amplifier.aim([-2.0, 1.0, 2.0, np.nan]), [-150.0, 100.0, 150.0, np.nan])
    assert amplifier.is_limited
    assert amplifier.current_limits == (-np.inf, np.inf)


def test_a_sink_is_as_strong_as_the_source_unless_said():
    assert Amplifier(source_current=1e-3).current_limits == (-1e-3, 1e-3)
    assert Amplifier(source_current=1e-3, sink_current=1e-4).current_limits == (-1e-4, 1e-3)
    assert not Amplifier(gain=2.0, bandwidth=1e4).is_limited


def test_a_profile_that_never_changes_is_constant():
    half = Corners(points=({"time": 0.1, "share": 0.5}, {"time": 0.2, "share": 0.5}))
    assert Steady().is_constant
    assert half.is_constant
    assert not Press(rise=0.1).is_constant
