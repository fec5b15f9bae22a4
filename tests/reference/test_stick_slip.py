"""Skin that sticks and slips: closed forms, the linear criterion, the order, the energy, and a second route."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenario_parts import largest, powers
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from electrovib.core.errors import InputError
from electrovib.physics.friction import Coulomb, Dahl, LuGre
from electrovib.scenario import load
from electrovib.solve.mechanics.skin import DAMPER, HEAT, OVER_PLATE, WORK, SlidingSkin, skin_of
from electrovib.solve.mechanics.sliding import Sliding, sliding
from electrovib.solve.simulate import simulate

COULOMB = Coulomb(coefficient=0.5)
STRENGTH = 0.3
BALANCE = 1e-6
"""Of the work done: the target."""
FINGER = {"mass": 1.5e-3, "stiffness": 1000.0, "damping": 0.05}
SOFT, LIVELY = FINGER | {"damping": 3.0}, FINGER | {"damping": 1.0}
STICKY = LuGre(steady=COULOMB, stiffness=1e4, static_ratio=1.5, stribeck_speed=2e-2)


def always(value):
    return lambda time: value + 0 * np.asarray(time, dtype=float)


def slid(law, times, *, speed=0.02, strength=STRENGTH, **more):
    """Slide at a speed under a strength, each a number or a function of time; its energies balance."""
    given_ = [each if callable(each) else always(each) for each in (speed, strength)]
    slide = sliding(law, speed=given_[0], strength=given_[1], times=times, **more)
    if more.get("tolerance") != LOOSE:
        assert slide.energy_residual < BALANCE
    return slide


def rung(since, *, place, along):
    """Free damped motion of the skin of FINGER, from a place and a speed."""
    decay = 0.05 / 2 / 1.5e-3
    turn = np.sqrt(1000 / 1.5e-3 - decay**2)
    swing = (along + decay * place) / turn
    return np.exp(-decay * since) * (place * np.cos(turn * since) + swing * np.sin(turn * since))


def dahl_curve(distance, *, stiffness, exponent):
    """Force over distance from rest: (1 - r)^(1 - n) = 1 - (1 - n) stiffness distance/strength; exponential for n = 1."""
    share = stiffness * distance / STRENGTH
    if exponent == 1:
        return STRENGTH * -np.expm1(-share)
    left = np.maximum(1 - (1 - exponent) * share, 0) ** (1 / (1 - exponent))
    return STRENGTH * (1 - left)


@pytest.mark.parametrize("exponent", [0.5, 0.7, 1.0, 1.5, 2.0])
def test_dahl_before_sliding(exponent):
    """A rigid finger that speeds up and slows down: only the distance counts."""
    law = Dahl(steady=COULOMB, stiffness=500.0, exponent=exponent)
    times = np.linspace(0, 0.2, 101)
    slide = slid(
        law, times, speed=lambda time: 0.02 * np.interp(time, [0, 0.1, 0.2], [0, 1, 0]), breaks=(0.1,)
    )
    distance = np.where(times < 0.1, 0.1 * times**2, 2e-3 - 0.1 * (0.2 - times) ** 2)
    exact = dahl_curve(distance, stiffness=500.0, exponent=exponent)
    np.testing.assert_allclose(slide.lateral_force, exact, rtol=0, atol=2e-7 * STRENGTH)  # ten local errors
    wrong = dahl_curve(distance, stiffness=500.0, exponent=exponent + 0.1)
    assert largest(slide.lateral_force - wrong) > 1e-3 * STRENGTH
    assert np.all(slide.skin_displacement == 0)
    work = np.trapezoid(exact, distance)
    assert slide.states[WORK][-1] == pytest.approx(work, rel=1e-3)  # trapezoidal rule of 100 steps


@pytest.mark.parametrize("speed", [1e-3, 5e-3, 0.05])
def test_lugre_friction_over_speed(speed):
    """Onset F = g (1 - exp(-stiffness u t/g)) + viscous u, and after it the steady curve, where a settled slide begins."""
    law = LuGre(steady=COULOMB, stiffness=2e3, static_ratio=1.6, stribeck_speed=5e-3, viscous_damping=0.7)
    steady = STRENGTH * (1 + 0.6 * np.exp(-((speed / 5e-3) ** 2)))
    times = np.linspace(0, 0.02 / speed * steady, 51)
    onset = steady * -np.expm1(-2e3 * speed * times / steady) + 0.7 * speed
    found = slid(law, times, speed=speed).lateral_force
    np.testing.assert_allclose(found, onset, rtol=0, atol=2e-7 * steady)
    settled = slid(law, times, speed=speed, settled=True, **FINGER | {"damping": 9.0})
    np.testing.assert_allclose(settled.lateral_force, steady + 0.7 * speed, rtol=1e-12)
    np.testing.assert_allclose(settled.skin_displacement, (steady + 0.7 * speed) / 1000, rtol=1e-12)
    assert largest(settled.skin_speed) < 1e-12


def test_skin_rings_on_constant_friction():
    """A step of the strength under a fast slide: damped harmonic motion, as far as the bristles are stiff."""
    times = np.linspace(0, 0.05, 501)
    slide = slid(
        Dahl(steady=COULOMB, stiffness=1e8),
        times,
        speed=0.5,
        strength=lambda time: np.where(np.asarray(time) < 0.01, STRENGTH, 1.1 * STRENGTH),
        breaks=(0.01,),
        settled=True,
        **FINGER,
    )
    assert slide.events == ()
    exact = (1.1 * STRENGTH + rung(np.maximum(times - 0.01, 0), place=-0.1 * STRENGTH, along=0.0)) / 1000
    # the force follows within strength/stiffness/speed = 6 ns, against 1/turn = 1.2 ms
    np.testing.assert_allclose(slide.skin_displacement, exact, rtol=0, atol=1e-5 * np.ptp(exact))


# ------------------------------------------------------------------ sticking and slipping


def linearised(law, speed, *, mass, stiffness, damping):
    """Jacobian of (displacement, speed, deflection) about a steady slide, by hand."""
    excess = (law.static_ratio - 1) * np.exp(-((speed / law.stribeck_speed) ** 2))
    strength = STRENGTH * (1 + excess)
    slope = -2 * speed / law.stribeck_speed**2 * STRENGTH * excess
    fed, lost = speed * slope / strength, speed * law.stiffness / strength
    moved = [stiffness / mass, -damping / mass, -law.stiffness / mass]
    return np.array([[0, -1, 0], moved, [0, fed, -lost]])


def growth(law, speed, finger):
    return np.max(np.linalg.eigvals(linearised(law, speed, **finger)).real)


def critical_speed(law, finger):
    """Speed above which a steady slide is stable."""
    return brentq(lambda speed: growth(law, speed, finger), law.stribeck_speed, 5 * law.stribeck_speed)


@pytest.mark.parametrize(("share", "grows"), [(0.9, True), (1.1, False)])
def test_small_ripples_grow_below_the_critical_speed_only(share, grows):
    """Rate of growth and frequency are the eigenvalue's: two terms of linear prediction from the skin's speed."""
    speed = share * critical_speed(STICKY, SOFT)
    values = np.linalg.eigvals(linearised(STICKY, speed, **SOFT))
    value = values[np.argmax(values.imag)]
    assert (value.real > 0) == grows
    times = np.linspace(0, 0.05, 1001)
    ripple = slid(
        STICKY,
        times,
        speed=speed,
        strength=lambda time: np.where(np.asarray(time) < 1e-3, 1 + 1e-5, 1.0) * STRENGTH,
        breaks=(1e-3,),
        tolerance=1e-10,
        settled=True,
        **SOFT,
    ).skin_speed[200:]
    lag = 10
    pair = np.transpose([ripple[lag:-lag], ripple[: -2 * lag]])
    terms = np.linalg.lstsq(pair, ripple[2 * lag :], rcond=None)[0]
    roots = np.log(np.roots([1, *-terms]).astype(complex)) / (lag * times[1])
    assert roots[np.argmax(roots.imag)] == pytest.approx(value, rel=1e-3)  # ripples of 1e-5 are nearly linear


@pytest.mark.parametrize("share", [0.1, 0.5, 1.5])
@pytest.mark.parametrize("ratio", [1.5, pytest.param(1.0, marks=pytest.mark.slow)])
def test_limit_cycle_where_a_steady_slide_is_unstable_only(ratio, share):
    """From rest: below the critical speed, unless so slow that the excess hardly falls; without excess never."""
    speed = share * critical_speed(STICKY, LIVELY)
    law = STICKY.model_copy(update={"static_ratio": ratio})
    slips = growth(law, speed, LIVELY) > 0
    assert slips == (ratio > 1 and share == 0.5)
    slide = slid(law, np.linspace(0, 0.3, 1501), speed=speed, tolerance=1e-7, **LIVELY)
    late = slide.skin_displacement[1000:]
    if slips:
        assert np.ptp(late[:250]) == pytest.approx(np.ptp(late[250:]), rel=1e-2)  # of 50 samples a cycle
        assert np.ptp(late) > 0.1 * STRENGTH / 1000
        over_plate = speed - slide.skin_speed[1000:]
        assert over_plate.min() < 0  # it sticks
        assert over_plate.max() > 2 * speed  # and slips
    else:
        assert np.ptp(late) < 0.01 * STRENGTH / 1000


ORDER = 5
"""Of Radau's method with three stages, where the rate is smooth."""
LOOSE = 1e-4
"""A tolerance with which the largest step alone sets the steps."""
STEPS = [2e-4, 1e-4, 5e-5, 2.5e-5]


def march_steps(steps):
    """Place, speed and force at the end of a slide through eight reversals, one row for each step."""
    slides = [slid(STICKY, np.array([0.0, 0.05]), step=step, tolerance=LOOSE, **FINGER) for step in steps]
    ends = [
        [each.skin_displacement[-1] * 1000, each.skin_speed[-1], each.lateral_force[-1]] for each in slides
    ]
    return np.array(ends), len(slides[-1].events)


def slope_of(errors, steps):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


@pytest.mark.slow
def test_order_on_a_stick_slip_cycle(monkeypatch):
    """Fixed steps through a slip and eight reversals: the declared order, and a lower one with kinks not located."""
    ends, reversals = march_steps([*STEPS, STEPS[-1] / 2])
    assert reversals == 8
    errors = np.max(np.abs(ends[:-1] - ends[-1]), axis=1)
    assert slope_of(errors[1:], STEPS[1:]) == pytest.approx(ORDER, abs=0.1)

    def rate(self, state, mode, *, time):
        direction = np.where(state[OVER_PLATE] < 0, -1, 1)
        speed, strength = self.speed(time), self.strength_of(time)
        return self.skin.rate(state, speed=speed, strength=strength, direction=direction, touches=True)

    monkeypatch.setattr(Sliding, "rate", rate)
    monkeypatch.setattr(Sliding, "switches", lambda *_, **__: np.empty(0))
    blind, _ = march_steps(STEPS[:3])
    assert slope_of(np.abs(blind[:, 0] - ends[-2, 0]), STEPS[:3]) < ORDER - 1


# ------------------------------------------------------------------ energy, and a second route


def second_route(law, *, speed, strength, times, method, mass, stiffness, damping):
    """The same equations written anew with |w|, by another method at a tight tolerance."""

    def rate(now, state):
        place, over_plate, deflection = state
        excess = (law.static_ratio - 1) * np.exp(-((over_plate / law.stribeck_speed) ** 2))
        bristles = over_plate - abs(over_plate) * law.stiffness * deflection / (strength(now) * (1 + excess))
        force = law.stiffness * deflection + law.bristle_damping * bristles + law.viscous_damping * over_plate
        lag = speed(now) - over_plate
        return [lag, (stiffness * place + damping * lag - force) / mass, bristles]

    tight = {"rtol": 1e-10, "atol": [1e-16, 1e-14, 1e-17], "max_step": 2e-4}
    return solve_ivp(rate, (0, times[-1]), [0.0] * 3, method=method, t_eval=times, **tight).y


def toned(size, turn):
    return lambda time: STRENGTH * (1 + size * np.sin(turn * np.asarray(time)))


CASES = {
    "steady speed": (always(0.02), always(STRENGTH)),
    "driven at 100 Hz": (always(0.03), toned(0.4, 2 * np.pi * 100)),
    "there and back": (lambda time: 0.05 * np.cos(2 * np.pi * 20 * np.asarray(time)), always(STRENGTH)),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", ["LSODA", "DOP853"])
def test_another_integrator_agrees(case, method):
    speed, strength = CASES[case]
    law = STICKY.model_copy(update={"bristle_damping": 0.3, "viscous_damping": 0.05})
    times = np.linspace(0, 0.05, 201)
    slide = slid(law, times, speed=speed, strength=strength, tolerance=1e-9, **FINGER)
    expected = second_route(law, speed=speed, strength=strength, times=times, method=method, **FINGER)
    over_plate = speed(times) - slide.skin_speed
    for found, exact in zip(
        (slide.skin_displacement, over_plate, slide.bristle_deflection), expected, strict=True
    ):
        # some thousand steps of 1e-9 and 1e-10, in a motion that forgets little
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-7 * largest(exact))
    assert slide.events


@settings(max_examples=6)
@given(
    speed=powers(-3, -1),
    stiffness=powers(3, 5),
    ratio=st.floats(1, 2),
    damping=powers(-2, 0.5),
    modulation=st.floats(0, 0.9),
)
def test_friction_takes_energy_and_none_is_lost(speed, stiffness, ratio, damping, modulation):
    """Without bristle damping the heat of the contact never falls, nor that of the damper."""
    law = LuGre(steady=COULOMB, stiffness=stiffness, static_ratio=ratio, stribeck_speed=1e-2)
    times, strength = np.linspace(0, 0.02, 201), toned(modulation, 700)
    slide = slid(law, times, speed=speed, strength=strength, **FINGER | {"damping": damping})
    heats = slide.states[HEAT], slide.states[DAMPER]
    for heat in heats:
        assert np.all(np.diff(heat) >= -BALANCE * max(heats[0][-1], heats[1][-1]))
    assert largest(slide.lateral_force) <= ratio * (1 + modulation) * STRENGTH * (1 + 1e-9)


def test_a_wrong_heat_is_noticed(monkeypatch):
    """The balance fails where a law's heat is counted one percent too low."""
    honest = SlidingSkin.rate

    def rate(self, now, **at):
        return (honest(self, now, **at).T * [1, 1, 1, 1, 1, 0.99]).T

    monkeypatch.setattr(SlidingSkin, "rate", rate)
    times = np.linspace(0, 0.05, 11)
    slide = sliding(STICKY, speed=always(0.02), strength=always(STRENGTH), times=times, **FINGER)
    assert slide.energy_residual > 1000 * BALANCE


@pytest.mark.parametrize("unit", [1e-3, pytest.param(1e3, marks=pytest.mark.slow)])
def test_nothing_depends_on_the_size(unit):
    """All forces, masses and stiffnesses times one number: the same motion."""
    times = np.linspace(0, 0.03, 61)
    one = slid(STICKY, times, **FINGER)
    finger = {name: value * unit for name, value in FINGER.items()}
    law = STICKY.model_copy(update={"stiffness": 1e4 * unit})
    other = slid(law, times, strength=STRENGTH * unit, **finger)
    assert abs(one.steps - other.steps) <= 0.02 * one.steps
    np.testing.assert_allclose(other.lateral_force / unit, one.lateral_force, rtol=0, atol=1e-6 * STRENGTH)


def test_scales_are_positive_at_rest_and_without_friction():
    """A skin released from its stretch is as fast as F/sqrt(k m), one that is stopped pulls as strongly as u sqrt(k m)."""
    impedance = np.sqrt(1.5e-3 * 1000)
    skin, rigid = skin_of(STICKY, **FINGER), skin_of(STICKY, mass=None, stiffness=None, damping=None)
    assert skin.scales(3.0, 2.0) == rigid.scales(3.0, 2.0) == (3.0, 2.0)
    assert skin.scales(3.0, 0.0) == pytest.approx((3.0, 3.0 / impedance))
    assert skin.scales(0.0, 2.0) == pytest.approx((2.0 * impedance, 2.0))
    assert skin.scales(0.0, 0.0) == pytest.approx((1.0, 1.0 / impedance))
    assert rigid.scales(0.0, 0.0) == (1.0, 1.0)


# ------------------------------------------------------------------ lifted off, and driven


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.01, 0.05])
def test_a_lifted_finger_rings_freely(speed):
    """Load to nothing: no friction, no NaN, and the skin decays as mass, spring and damper alone."""
    times = np.linspace(0, 0.16, 801)
    slide = slid(
        STICKY,
        times,
        speed=speed,
        strength=lambda time: STRENGTH * np.clip((0.06 - np.asarray(time)) / 0.02, 0, 1),
        breaks=(0.04, 0.06),
        tolerance=1e-9,
        **FINGER,
    )
    assert np.all(np.isfinite(slide.lateral_force))
    off = times > 0.0601
    assert largest(slide.lateral_force[off]) < 1e-8 * STRENGTH
    place, along = slide.skin_displacement[off], slide.skin_speed[off]
    free = rung(times[off] - times[off][0], place=place[0], along=along[0])
    np.testing.assert_allclose(place, free, rtol=0, atol=1e-6 * largest(free))


@pytest.mark.parametrize("settled", [False, True])
@pytest.mark.parametrize("finger", [{}, FINGER], ids=["rigid", "finger"])
def test_never_touched(finger, settled):
    slide = slid(STICKY, np.linspace(0, 0.05, 51), strength=0.0, settled=settled, **finger)
    assert np.all(np.isfinite(slide.lateral_force))
    assert largest(slide.lateral_force) < 1e-7 * STRENGTH


def test_small_modulation_is_passed_on_linearly():
    """Attraction of 1e-4 of the strength at 100 Hz over a stable slide: the force is the linear response."""
    speed, size, turn = 0.2, 1e-4, 2 * np.pi * 100
    times = np.linspace(0, 0.2, 2001)
    slide = slid(STICKY, times, speed=speed, strength=toned(size, turn), tolerance=1e-9, settled=True, **SOFT)
    late = times >= 0.1 - 1e-9
    wave = np.exp(-1j * turn * times[late][:-1])
    found = 2j * np.mean((slide.lateral_force[late][:-1] - STRENGTH) * wave)
    matrix = linearised(STICKY, speed, **SOFT)
    pushed = np.array([0, 0, speed * size])  # dz'/dg dg = u size
    expected = STICKY.stiffness * np.linalg.solve(1j * turn * np.eye(3) - matrix, pushed)[2]
    assert found == pytest.approx(expected, rel=1e-3)
    assert abs(expected - STRENGTH * size) > 1e-2 * STRENGTH * size  # not the quasi-static answer


@pytest.mark.slow
def test_attraction_at_100_hertz_makes_it_stick_and_slip():
    """Above the critical speed: steady without attraction, with it reversals and a force at 100 Hz and its multiples."""
    speed, turn = 1.1 * critical_speed(STICKY, LIVELY), 2 * np.pi * 100
    setting = {
        "speed": speed,
        "times": np.linspace(0, 0.2, 4001),
        "settled": True,
        "tolerance": 1e-7,
        **LIVELY,
    }

    def attracted(time):
        return STRENGTH * (1 + 0.5 * (1 - np.cos(turn * np.asarray(time))))

    assert slid(STICKY, **setting).events == ()
    slide = slid(STICKY, strength=attracted, **setting)
    over_plate = speed - slide.skin_speed[2000:]
    assert over_plate.min() < 0
    assert over_plate.max() > 2 * speed
    assert len(slide.events) >= 20  # two reversals a period
    late = slide.lateral_force[2000:-1]
    power = np.abs(np.fft.rfft(late - late.mean())) ** 2
    assert power[::10].sum() > 0.999 * power.sum()  # 10 Hz a line
    assert np.argmax(power) == 10
    assert 0.1 < 1 - power[10] / power.sum() < 0.9  # far from a sine


def test_a_steady_slide_costs_nothing():
    """A million samples of a settled slide take a handful of steps."""
    slide = slid(STICKY, np.linspace(0, 1, 1_000_001), speed=0.2, settled=True, **SOFT)
    assert slide.steps < 20
    np.testing.assert_allclose(slide.lateral_force, STRENGTH, rtol=1e-9)


@pytest.mark.parametrize(
    ("given_numbers", "sentence"),
    [
        ({"mass": 0.0, "stiffness": 1.0, "damping": 0.0}, "finger.mass"),
        ({"mass": 1e-3, "stiffness": 0.0, "damping": 0.1}, "stiffness = 0"),
        ({"strength": -1.0}, "friction.steady"),
        ({"strength": np.nan}, "friction.steady"),
    ],
)
def test_refusals(given_numbers, sentence):
    with pytest.raises(InputError, match=sentence):
        slid(STICKY, np.linspace(0, 1, 11), **given_numbers)


@pytest.mark.parametrize(("damping", "speed"), [(1e2, 1e-2), pytest.param(1e4, 0.03, marks=pytest.mark.slow)])
def test_damped_bristles_under_nearly_no_load_miss_no_more_than_is_stated(damping, speed):
    """Twice in each cycle the strength all but vanishes, and the rate of the deflection is that of the speed."""
    friction = {"model": "LuGre", "steady": {"model": "Coulomb", "coefficient": 0.5}, "stiffness": 5e3}
    friction |= {"static_ratio": 1.5, "stribeck_speed": 5e-3, "bristle_damping": damping}
    changes = {"load.normal_force": 1e-7, "motion.speed": speed, "friction": friction}
    slides = load("bau_2010/sine", changes=changes | {"time.initial_state": {"model": "AtRest"}})
    times = np.linspace(0.0, 0.02, 401)
    trace, fine = simulate(slides, time=times), np.linspace(0.0, times[-1], 100_001)
    attraction = simulate(slides.replace({"friction": friction["steady"]}), time=fine).electrostatic_force
    strength = CubicSpline(fine, 0.5 * (1e-7 + attraction.values))
    level = 1 + 0.5 * np.exp(-((speed / 5e-3) ** 2))

    def rate(time, deflection):
        return speed * (1 - 5e3 * deflection / (level * strength(time)))

    found = [level * float(strength(0.0)) / 5e3]
    for begin, end in itertools.pairwise(times):
        solved = solve_ivp(rate, (begin, end), found[-1:], method="Radau", rtol=1e-10, atol=1e-19)
        found.append(solved.y[0, -1])
    expected = 5e3 * np.array(found) + damping * rate(times, np.array(found))
    missed = np.max(np.abs(trace.lateral_force.values - expected)) / np.max(np.abs(expected))
    assert missed < trace.attrs["mechanics_error"] < 1e-4
