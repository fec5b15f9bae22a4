"""The finger, how it is pressed, held off and moved, and frictions without memory, with relaxations and with bristles.

Equations are held by tests/contract; here are published numbers, ends and what is refused.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.papers import balasubramanian_2025
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.finger import Finger, GrowthWithSpeed, MassSpringDamper
from electrovib.physics.friction import (
    AdhesiveShear,
    Coulomb,
    Creep,
    Dahl,
    FirstOrderLag,
    Friction,
    Load,
    LuGre,
    PowerLaw,
)
from electrovib.physics.motion import Distance, Motion, TouchAndLift, TremblingDistance
from electrovib.physics.relaxation import release_seen_by_sensor
from electrovib.physics.time_profile import Corners, LiftOff, Press, Steady, Swipe, TimeProfile

FINGER = MassSpringDamper(mass="0.15 g", stiffness="1 kN/m", damping="1 N s/m")
GROWING = FINGER.replace({"growth": GrowthWithSpeed(known_at="50 mm/s")})
NONE = np.nan
STEADY = Coulomb(coefficient=0.5)


def test_a_finger_is_overdamped_and_lumped():
    assert FINGER.natural_frequency() == pytest.approx(410.94, rel=1e-4)  # sqrt(1000/1.5e-4)/(2 pi)
    assert FINGER.damping_ratio() == pytest.approx(1.2910, rel=1e-4)
    assert np.angle(FINGER.compliance(FINGER.natural_frequency())) == pytest.approx(-np.pi / 2)
    frequency = np.geomspace(0.1, 1e5, 50)
    scaled = FINGER.compliance_at_rest() * FINGER.resonance().at(frequency)
    assert np.abs(scaled / FINGER.compliance(frequency) - 1).max() < 1e-13
    # what a skin without a formula of its own takes to a friction whose contact deflects
    assert Finger.lumped(FINGER) == pytest.approx(FINGER.lumped(), rel=1e-13)
    required = {name for name, field in MassSpringDamper.model_fields.items() if field.is_required()}
    assert required == {"mass", "stiffness", "damping"}  # no value is assumed


def test_growth_with_sliding_speed_is_that_of_the_paper():
    """Slopes of the abstract: per mm/s 3.23e-5 kg and 4.04 N/m; nothing else moves."""
    assert GROWING.growth.mass_slope == balasubramanian_2025.MASS_SLOPE
    assert GROWING.growth.stiffness_slope == balasubramanian_2025.STIFFNESS_SLOPE
    faster = GROWING.at_speed(0.060)
    assert faster.mass == pytest.approx(1.5e-4 + 10 * 3.23e-5)
    assert faster.stiffness == pytest.approx(1000 + 10 * 4.04)
    assert (faster.damping, faster.growth) == (FINGER.damping, None)
    assert GROWING.at_speed(0.050).mass == GROWING.mass
    assert GROWING.at_speed(0.0455).mass > 0
    assert FINGER.at_speed(0.3) is FINGER
    assert Finger.at_speed(FINGER, None) is FINGER


@pytest.mark.parametrize(
    ("growth", "speed", "words"),
    [
        ({}, 0.045, "must stay positive"),  # 0.15 g at 50 mm/s falls to nothing 4.6 mm/s below
        ({}, None, r"finger\.growth needs motion\.speed"),
        (
            {"mass_slope": 0.0, "stiffness_slope": 1e6},
            100.0,
            r"finger\.growth: at 100 m/s stiffness = .* between",
        ),
    ],
)
def test_a_growth_that_leaves_the_range_is_told(growth, speed, words):
    with pytest.raises(InputError, match=words):
        FINGER.replace({"growth": {"known_at": 0.05} | growth}).at_speed(speed)


def test_frictions_without_memory():
    # Seo 2009, abstract: friction on aluminium falls by 46 % from 1 to 20 N; the exponent of the docstring
    law = PowerLaw(coefficient=0.6, at_force=1.0, exponent=-0.206)
    assert law.lateral_force(20.0, 0.0, NONE) / 20 / 0.6 == pytest.approx(0.54, abs=0.002)
    shear = AdhesiveShear(shear_strength=5e6)
    assert shear.needs_real_area
    assert shear.lateral_force(7.0, 3.0, 2e-8) == pytest.approx(0.1)


def test_the_corner_rises_as_measured():
    """13.8 Hz for each mm/s."""
    renewal = 1 / balasubramanian_2025.CUT_OFF_SLOPE
    law = FirstOrderLag(steady=STEADY, cut_off=100.0, at_speed=0.02, renewal_length=renewal)
    assert law.corner(0.1) - law.corner(0.02) == pytest.approx(13.8 * 80)
    assert FirstOrderLag(steady=STEADY, cut_off=100.0).corner(0.1) == 100.0


@pytest.mark.parametrize(
    "relaxations", [[], [(0.6, 1e-3), (0.6, 2e-3)], [(0.1, 2e-3), (0.1, 1e-3)], [(1.0, 1e-3)]]
)
def test_relaxations_have_an_order_and_are_at_most_all_there_is(relaxations):
    relaxations = [{"share": share, "time": time} for share, time in relaxations]
    content = {
        "model": "Creep",
        "steady": {"model": "Coulomb", "coefficient": 0.5},
        "relaxations": relaxations,
    }
    if len(relaxations) == 1:
        assert read_model(Friction, content) == Creep(steady=STEADY, relaxations=relaxations)
        return
    with pytest.raises(InputError, match="relaxations"):
        read_model(Friction, content)


@given(speed=st.floats(1e-6, 1.0), strength=st.floats(1e-3, 10.0), direction=st.sampled_from([-1.0, 1.0]))
def test_lugre_slides_steadily_at_its_strength(speed, strength, direction):
    law = LuGre(steady=STEADY, stiffness=500.0, static_ratio=1.5, stribeck_speed=5e-3, viscous_damping=0.1)
    limit = law.strength_at(speed, strength)
    deflection = direction * limit / law.stiffness
    assert abs(law.deflection_rate(deflection, direction * speed, strength, direction)) <= 1e-12 * speed
    force = law.force(deflection, 0.0, direction * speed)
    assert force == pytest.approx(direction * (limit + 0.1 * speed))
    assert strength <= limit <= 1.5 * strength * (1 + 1e-12)


@given(
    deflection=st.floats(-5e-3, 5e-3),
    speed=st.floats(-0.5, 0.5),
    strength=st.floats(1e-3, 5.0),
    exponent=st.floats(0.5, 3),
)
def test_bristles_only_take_energy(deflection, speed, strength, exponent):
    """Force times speed is at least what the bristles store, at every instant."""
    direction = 1.0 if speed >= 0 else -1.0
    lugre = LuGre(steady=STEADY, stiffness=500.0, static_ratio=1.5, stribeck_speed=5e-3)
    for law in (lugre, Dahl(steady=STEADY, stiffness=500.0, exponent=exponent)):
        rate = law.deflection_rate(deflection, speed, strength, direction)
        taken = law.force(deflection, rate, speed) * speed
        stored = law.stiffness * deflection * rate
        assert taken - stored >= -1e-12 * (abs(taken) + abs(stored))


def test_a_friction_says_what_it_remembers_and_whether_it_deflects():
    lag, dahl = FirstOrderLag(steady=STEADY, cut_off=100.0), Dahl(steady=STEADY, stiffness=500.0)
    found = [(each.has_memory, each.deflects, len(each.memory(0.03))) for each in (STEADY, lag, dahl)]
    assert found == [(False, False, 0), (True, False, 1), (True, True, 0)]


def test_shares_of_a_load():
    """Where a swipe does not hold, at the ends of a press, and profiles that never change."""
    swipe = Swipe(rise=0.1, hold=0.0, fall=0.1)
    np.testing.assert_allclose(swipe.share([0, 0.1, 0.15, 1]), [0, 1, 0.5, 0], atol=1e-12)
    load = Load(normal_force=0.4, time_profile=Press(rise=0.1))
    np.testing.assert_allclose(load.forces([0.0, 0.05, 1.0]), [0.0, 0.2, 0.4])
    half = Corners(points=({"time": 0.1, "share": 0.5}, {"time": 0.2, "share": 0.5}))
    profiles = (Steady(), half, Press(rise=0.1), LiftOff(begin=0.1, fall=0.1), swipe)
    assert [each.is_constant for each in profiles] == [True, True, False, False, False]


TOUCH = TouchAndLift(far=1e-3, near=1e-6, begin=0.1, approach=0.2, touch=0.1, lift=0.2)
TREMBLING = TremblingDistance(mean=100e-6, amplitude=30e-6, frequency=8.0)


def test_distances_of_a_finger_held_off():
    np.testing.assert_allclose(
        TOUCH.gap([0.0, 0.2, 0.35, 1.0]), [1e-3, np.sqrt(1e-9), 1e-6, 1e-3], rtol=1e-12
    )
    assert TOUCH.breaks() == pytest.approx((0.1, 0.3, 0.4, 0.6))
    assert np.all(TOUCH.rate(np.array([0.0, 0.35, 0.65])) == 0)  # where the finger stays
    assert TREMBLING.gap(1 / 32) == pytest.approx(130e-6)
    times, step = np.linspace(0, 0.7, 1000), 1e-6
    for distance in (TOUCH, TREMBLING):
        expected = (distance.gap(times + step) - distance.gap(times - step)) / (2 * step)
        assert np.max(np.abs(distance.rate(times) - expected)) < 1e-6 * np.max(np.abs(expected))
        assert np.isnan(distance.rate(np.nan))


TREMOR = {"model": "TremblingDistance", "mean": 1e-4, "amplitude": 1e-4, "frequency": 8}
BACK = [{"time": 0.2, "share": 1.0}, {"time": 0.1, "share": 0.0}]


@pytest.mark.parametrize(
    ("kind", "content", "word"),
    [
        (TimeProfile, {"model": "Corners", "points": BACK}, "order"),
        (Distance, TREMOR, "amplitude"),
        (Motion, {"speed": 0.03, "renews_film": True, "distance": TREMOR | {"amplitude": 1e-5}}, "distance"),
    ],
)
def test_what_cannot_be_followed_is_refused(kind, content, word):
    with pytest.raises(InputError, match=word):
        read_model(kind, content)


def test_an_amplifier_aims_clips_and_sinks():
    amplifier = Amplifier(gain=100.0, saturation=150.0)
    np.testing.assert_allclose(amplifier.aim([-2.0, 1.0, 2.0, np.nan]), [-150.0, 100.0, 150.0, np.nan])
    assert amplifier.is_limited
    assert not Amplifier(gain=2.0, bandwidth=1e4).is_limited
    assert amplifier.current_limits == (-np.inf, np.inf)
    assert Amplifier(source_current=1e-3).current_limits == (-1e-3, 1e-3)
    assert Amplifier(source_current=1e-3, sink_current=1e-4).current_limits == (-1e-4, 1e-3)


@pytest.mark.parametrize("quality", [0.6, 3.0, 30.0])
@pytest.mark.parametrize("fall_time", [1e-5, 3e-4, 5e-3])
def test_a_release_seen_by_a_sensor_solves_its_equation(quality, fall_time):
    time, start, natural = np.linspace(0, 12e-3, 300), 1e-3, 2 * np.pi * 350

    def slope(now, state):
        force = np.exp(-max(now - start, 0) / fall_time)
        return [state[1], natural**2 * (force - state[0]) - natural / quality * state[1]]

    after = time[time >= start]
    accuracy = {"rtol": 1e-11, "atol": 1e-13, "method": "DOP853"}
    solved = solve_ivp(slope, (start, after[-1]), [1, 0], t_eval=after, **accuracy)
    found = release_seen_by_sensor(time, start=start, fall_time=fall_time, frequency=350.0, quality=quality)
    # the integrator was asked for 1e-11 a step
    np.testing.assert_allclose(found[time >= start], solved.y[0], atol=1e-9)
    np.testing.assert_array_equal(found[time < start], 1.0)


def test_a_step_overshoots_as_in_a_textbook():
    time, ratio = np.linspace(0, 5e-3, 50_001), 1 / 6
    found = release_seen_by_sensor(time, start=0.0, fall_time=1e-9, frequency=350.0, quality=3.0)
    # exp(-pi zeta / sqrt(1 - zeta^2)); a fall in 1 ns moves it by 2e-6
    assert found.min() == pytest.approx(-np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)), rel=1e-5)
