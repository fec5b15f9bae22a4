"""The recursion of conjugate pairs, against closed forms, its plain loop and that of real poles."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_recursion import march_loop

from electrovib.core.errors import InputError
from electrovib.solve.recursion import hold_weights, march

SAME = 1e-12  # of the largest possible output, as for real poles
WEIGHT = 4e-15  # of the larger term of a weight: exp and expm1 of complex numbers are good to a few roundings
both_ways = pytest.mark.parametrize("way", [march, march_loop])


def exact_weights(z):
    """decay, first and last in enough digits, and the size of what cancels beyond |z| = 1."""
    with mpmath.workdps(80):
        fall = -mpmath.mpc(z)
        decay = mpmath.exp(-fall)
        mean = (1 - decay) / fall
        size = 1.0 if abs(fall) < 1 else None
        return (decay, mean - decay, 1 - mean), size


angles = st.floats(0.0, np.pi / 2)


@settings(deadline=None, max_examples=300)
@given(st.floats(-20, 2).map(lambda decade: 10.0**decade), angles)
def test_weights_of_a_ringing_mode(size, angle):
    z = complex(-size * np.cos(angle), size * np.sin(angle))
    exact, inside = exact_weights(z)
    for found, wanted in zip(hold_weights(z), exact, strict=True):
        scale = abs(wanted) if inside else 1 + abs(wanted)
        error = abs(mpmath.mpc(complex(found)) - wanted)
        # at |z| up to 100 the angle of exp(z) itself carries the rounding of z
        assert error <= WEIGHT * scale * max(1.0, size / 10)
    assert abs(sum(hold_weights(z)) - 1) < 2e-15


def test_weights_of_real_numbers_are_those_of_relaxing_modes():
    z = -np.geomspace(1e-12, 600.0, 500)
    for pair, real in zip(hold_weights(z + 0j), hold_weights(z), strict=True):
        assert np.all(pair.imag == 0)
        assert np.abs(pair.real / real - 1).max() < 1e-14


POLE = complex(-2e3, 2.5e4)  # 4 kHz, rings for ten periods
STEP = 1e-6


def exact_ring(pole, time, *, slope=False):
    """Twice the real part of the answer of x' = p (x - u) to a step, or to a ramp of 1/s."""
    with mpmath.workdps(40):
        p, t = mpmath.mpc(pole), mpmath.mpf(time)
        left = mpmath.expm1(p * t)
        return float(2 * ((t - left / p) * 1 if slope else -left).real)


@both_ways
@pytest.mark.parametrize("kind", ["even", "uneven"])
@pytest.mark.parametrize("slope", [False, True])
def test_closed_form(way, kind, slope):
    stamps = np.arange(2001) * STEP
    if kind == "uneven":
        stamps = np.delete(stamps, slice(3, 1990, 7))
    drive = stamps if slope else np.ones(stamps.size)
    steps = STEP if kind == "even" else np.diff(stamps)
    output, _ = way([POLE], [[1.0]], [0.0], drive[:-1], drive[1:], steps, [0.0])
    exact = np.array([exact_ring(POLE, stamp, slope=slope) for stamp in stamps])
    # the stamps are rounded: 1e-16 of 2 ms against a step of 1 us
    assert np.abs(output[0] - exact).max() < SAME * np.abs(exact).max()
    assert np.abs(output[0] * (1 + 1e-9) - exact).max() > SAME * np.abs(exact).max()


@st.composite
def records(draw):
    """Random pairs and real modes, a drive with or without jumps, one step or many, from any state."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count, outputs = draw(st.integers(0, 5)), draw(st.integers(1, 3))
    pieces = draw(st.one_of(st.integers(1, 400), st.sampled_from([63, 64, 65, 128, 4096, 4097, 9000])))
    step = 10.0 ** draw(st.floats(-9, 2))
    size, angle = 10.0 ** rng.uniform(-6, 2, count) / step, rng.uniform(0, 1.5, count)
    angle[rng.random(count) < 0.3] = 0.0
    poles = size * (-np.cos(angle) + 1j * np.sin(angle))
    values = rng.uniform(-100, 100, pieces + 1)
    starts, ends = values[:-1], values[1:]
    if draw(st.booleans()):
        ends = np.where(rng.random(pieces) < 0.2, rng.uniform(-100, 100, pieces), ends)
    steps = step * rng.choice([0.0, 0.5, 1.0, 3.0], pieces) * rng.uniform(0.9, 1.1, pieces)
    gains = rng.normal(size=(outputs, count)) + 1j * rng.normal(size=(outputs, count)) * (angle != 0)
    state = rng.uniform(-100, 100, count) + 1j * rng.uniform(-100, 100, count) * (angle != 0)
    many = draw(st.booleans())
    return poles, gains, rng.normal(size=outputs), starts, ends, steps if many else step, state


@settings(deadline=None, max_examples=120)
@given(records())
def test_fast_way_equals_the_loop(record):
    _, gains, direct, *_ = record
    expected, expected_final = march_loop(*record)
    scale = 100.0 * (2 * np.abs(gains).sum(axis=1) + np.abs(direct)).max()
    output, final = march(*record)
    assert output.shape == expected.shape
    assert np.abs(output - expected).max() <= SAME * scale
    assert np.abs(final - expected_final).max(initial=0.0) <= SAME * 200.0


@settings(deadline=None, max_examples=60)
@given(records())
def test_relaxing_modes_are_pairs_without_imaginary_part(record):
    poles, gains, direct, starts, ends, steps, state = record
    real = (poles.real, gains.real, direct, starts, ends, steps, state.real)
    expected, _ = march_loop(*real)
    scale = 100.0 * (np.abs(gains).sum(axis=1) + np.abs(direct)).max()
    for output, final in (march(*real), march(real[0] + 0j, *real[1:])):
        assert np.abs(output - expected).max() <= SAME * scale
        assert np.all(np.imag(final) == 0)


@both_ways
@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"poles": [-1 - 1j]}, "positive imaginary part"),
        ({"poles": [1j]}, "every pole must be negative"),
        ({"poles": [complex(np.nan)]}, "every pole must be negative"),
        ({"gains": [1.0]}, r"march.gains has shape \(1,\), expected \(1, 1\)"),
        ({"initial_state": [0.0, 0.0]}, r"march.initial_state has shape \(2,\)"),
    ],
)
def test_what_does_not_fit_is_refused(way, wrong, message):
    right = {
        "poles": [-1 + 1j],
        "gains": [[1.0]],
        "direct": [0.0],
        "starts": [0.0],
        "ends": [0.0],
        "steps": 0.1,
        "initial_state": [0.0],
    }
    way(**right)
    with pytest.raises(InputError, match=message):
        way(**(right | wrong))
