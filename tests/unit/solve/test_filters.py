"""Filters of declared stages against closed forms, over frequency, and decimated."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.drive.pieces import Linear
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.physics.stages import CreepResponse, HighPass, LowPass, Resonance, response
from electrovib.solve.mechanics import filters
from electrovib.solve.mechanics.filters import (
    Filter,
    cascade,
    filtered,
    first_order,
    high_pass,
    of_stages,
    relaxing,
    second_order,
    through_pieces,
)

SENSOR = 1e-10
"""Largest error of a second-order sensor allowed, of the input: the target of the project."""
ROUNDING = 2e-12
"""What it really is: some ten roundings times gains of up to 350 near critical damping."""
DAMPINGS = [0.01, 0.44, 0.999, 1 - 2e-6, 1 - 3e-7, 1.0, 1 + 1e-9, 1 + 8e-7, 1 + 2e-6, 1.5, 50.0]
NATURAL = 4400.0
FREQUENCY = np.geomspace(1.0, 1e6, 400)
STEP = Linear(np.zeros(1), np.zeros(1), np.ones(1))
RAMP = Linear(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.array([0.0, 1.0]))


def sensor_of(damping, frequency=NATURAL):
    return second_order(natural_frequency=frequency, damping_ratio=damping)


def from_rest(filter_, part, times):
    """Output for straight pieces, from rest."""
    return through_pieces(filter_, part, np.asarray(times, dtype=float), filter_.state(0.0))


def exact(time, damping, *, ramp=False):
    """Answer to a step of 1, or to a ramp of 1 per second, of w0^2/(s^2 + 2 zeta w0 s + w0^2), in 50 digits.

    Step: 1 - e^(-zeta x)(cosh(r x) + zeta sinh(r x)/r), r = sqrt(zeta^2 - 1), x = w0 t. Ramp: its integral,
    t - 2 zeta/w0 + e^(-zeta x)(2 zeta cosh(r x) + (2 zeta^2 - 1) sinh(r x)/r)/w0.
    """
    with mpmath.workdps(50):
        zeta, angular, time = mpmath.mpf(damping), 2 * mpmath.pi * mpmath.mpf(NATURAL), mpmath.mpf(time)
        x, r = angular * time, mpmath.sqrt(mpmath.mpc(zeta**2 - 1))
        even, odd = mpmath.cosh(r * x), mpmath.sinh(r * x) / r if r else x
        fade = mpmath.exp(-zeta * x)
        if not ramp:
            return float((1 - fade * (even + zeta * odd)).real)
        return float((time - (2 * zeta - fade * (2 * zeta * even + (2 * zeta**2 - 1) * odd)) / angular).real)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("ramp", [False, True])
def test_second_order_sensor_against_closed_form(damping, ramp):
    """At even times by `filtered`, at uneven times by `through_pieces`, and decimated; over frequency."""
    sensor, step, count = sensor_of(damping), 2.0**-20, 1500
    even = np.arange(count) * step
    wanted = np.array([exact(time, damping, ramp=ramp) for time in even[::7]])
    scale = np.abs(wanted).max()
    found = filtered(sensor, even if ramp else np.ones(count), step=step, settled=False)
    assert np.abs(found[::7] - wanted).max() < ROUNDING * scale < SENSOR * scale
    assert np.abs(found[::7] * (1 + 1e-8) - wanted).max() > SENSOR * scale

    random = np.random.default_rng(4)
    uneven = random.permutation(np.cumsum(random.exponential(5e-6, 200)))
    wanted = np.array([exact(time, damping, ramp=ramp) for time in uneven])
    found = from_rest(sensor, RAMP if ramp else STEP, uneven)
    assert np.abs(found - wanted).max() < ROUNDING * np.abs(wanted).max()

    formula = Resonance(NATURAL, damping).at(
        FREQUENCY
    )  # gains of 350 cancel at high frequency, near critical
    assert np.abs(sensor.at(FREQUENCY) - formula).max() < ROUNDING * np.abs(formula).max()


def test_interpolation_at_critical_damping_keeps_what_it_states(monkeypatch):
    """Error 0.6 CRITICAL^2 (the curvature is largest at w0/sqrt 2, 32/27): seen with a hundredfold CRITICAL."""
    monkeypatch.setattr(filters, "CRITICAL", 1e-4)
    off = np.abs(sensor_of(1.0).at(FREQUENCY) - Resonance(NATURAL, 1.0).at(FREQUENCY)).max()
    assert off == pytest.approx(16 / 27 * 1e-8, rel=1e-3)


STAGES = (
    Resonance(NATURAL, 0.44),
    Resonance(90.0, 3.0),
    LowPass(6.4e3),
    HighPass(0.7),
    CreepResponse((0.02, -0.01), (3.0, 0.05)),
)
CHAIN = of_stages(STAGES)


def test_stages_and_their_filter_agree_over_frequency_and_a_rate_is_the_derivative():
    frequency = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 500)])
    formula, found = response(STAGES, frequency), CHAIN.at(frequency)
    assert np.abs(found - formula).max() < 1e-13 * np.abs(formula).max()
    assert np.abs(found - response(STAGES[:-1], frequency)).max() > 1e-3
    assert of_stages(()).at(3.0) == 1.0
    sensor = cascade(sensor_of(0.3, 200.0), first_order(900.0))
    expected = 2j * np.pi * frequency * sensor.at(frequency)
    assert np.abs(sensor.rate().at(frequency) - expected).max() < 1e-12 * np.abs(expected).max()


@settings(deadline=None, max_examples=60)
@given(st.floats(0.05, 20.0), st.floats(0.0, 5.0), st.integers(0, 2**32 - 1))
def test_one_after_the_other_is_the_cascade(damping, ratio, seed):
    sensor, low = sensor_of(damping, 1000.0), first_order(100.0 * 10**ratio)
    try:
        both = cascade(sensor, low)
    except InputError:
        return
    frequency = 10 ** np.random.default_rng(seed).uniform(0, 6, 50)
    assert np.abs(both.at(frequency) - sensor.at(frequency) * low.at(frequency)).max() < 1e-9


def test_settled_is_what_a_long_hold_ends_in():
    found = filtered(CHAIN, np.full(100, 3.0), step=1e-4, settled=True)
    assert found == pytest.approx(3.0 * CHAIN.at_rest(), abs=1e-13)
    samples = np.append(3.0, np.random.default_rng(8).normal(size=300))
    times = 1e4 + np.arange(301) * 1e-4
    long = Linear(np.append(0.0, times), np.append(0.0, samples), np.append(3.0, samples))
    found = from_rest(CHAIN, long, times)
    # time stamps near 1e4 s are rounded to 2e-12 s, of slopes of 3e4 per second
    assert filtered(CHAIN, samples, step=1e-4, settled=True) == pytest.approx(found, abs=1e-6)
    assert np.abs(filtered(CHAIN, samples, step=1e-4, settled=False) - found).max() > 0.1
    for held in (0.0, 1e-3, 0.4, 1e3, math.inf):  # the state after a hold is that of a step a while ago
        state = CHAIN.state(2.0, held=held)
        now = CHAIN.direct * 2.0 + np.sum(np.where(CHAIN.poles.imag == 0, 1, 2) * CHAIN.gains * state).real
        assert now == pytest.approx(2 * from_rest(CHAIN, STEP, [min(held, 1e5)])[0], abs=1e-12)


def test_straight_pieces_with_jumps_and_a_period():
    """A square wave, at times that meet its edges and at others; against every edge as a step."""
    lag, period = first_order(50.0), 0.01
    breaks = np.array([0.0, 0.5, 1.0]) * period
    square = Linear(breaks, np.array([0.0, 1.0, -1.0]), np.array([1.0, -1.0, -1.0]), period)
    times = np.sort(np.concatenate([np.arange(9) * period / 2, np.linspace(0, 4.2 * period, 57)]))
    expected = np.zeros(times.size)
    for edge in range(9):
        since = np.maximum(times - edge * period / 2, 0)
        expected -= (1.0 if edge == 0 else 2.0 * (-1) ** edge) * np.expm1(-2 * np.pi * 50.0 * since)
    assert from_rest(lag, square, times) == pytest.approx(expected, abs=1e-12)


def test_one_sample_and_no_stage():
    sensor = sensor_of(0.5, 10.0)
    for settled, output in ((True, 2.0), (False, 0.0)):
        assert filtered(sensor, [2.0], step=1e-3, settled=settled).tolist() == pytest.approx([output])
    assert filtered(cascade(), [2.0, 3.0, 4.0], step=1e-3, settled=True).tolist() == [2.0, 3.0, 4.0]
    assert from_rest(high_pass(1.0), STEP, [0.0]).tolist() == [1.0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Filter([1.0], [1.0]), "real parts must be negative"),
        (lambda: Filter([-1 - 1j], [1.0]), "positive imaginary part"),
        (lambda: Filter([-1.0], [1j]), "gain of a real pole must be real"),
        (lambda: Filter([-1.0], [1.0, 2.0]), "one for each pole"),
        (lambda: sensor_of(0.0), "must be positive"),
        (lambda: sensor_of(1.0, math.nan), "must be positive"),
        (lambda: cascade(first_order(10.0), first_order(10.0)), "too close to be separated"),
        (lambda: cascade(sensor_of(0.1), sensor_of(0.1)), "too close to be separated"),
        (lambda: filtered(first_order(1.0), [0.0, np.nan], step=1.0, settled=True), "sample 1 is nan"),
        (lambda: filtered(first_order(1.0), [], step=1.0, settled=True), "at least one"),
        (lambda: relaxing([0.1], [-1.0]), "real parts must be negative"),
        (lambda: high_pass(1.0).rate(), "rate of a discontinuous output"),
    ],
)
def test_what_is_no_filter_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_release_is_what_the_closed_form_of_the_resonance_says():
    """Two routes to one reading: the declared resonance behind straight pieces, and its closed form."""
    frequency, quality, start, fall = 390.0, 3.3, 2e-3, 0.5e-3
    stamps = np.concatenate([[0.0], start + np.linspace(0, 20e-3, 40_001)])
    force = np.append(1.0, np.where(stamps <= start, 1.0, np.exp(-(stamps - start) / fall)))
    wanted = np.linspace(0, 20e-3, 301)
    found = from_rest(
        sensor_of(1 / (2 * quality), frequency),
        Linear(np.append(-1.0, stamps) + 1.0, force, force),
        wanted + 1.0,
    )
    expected = release_seen_by_sensor(
        wanted, start=start, fall_time=fall, frequency=frequency, quality=quality
    )
    # one second of 1 before: the beginning is forgotten; pieces of 0.5 us bend by 1e-7
    np.testing.assert_allclose(found, expected, atol=1e-6)
