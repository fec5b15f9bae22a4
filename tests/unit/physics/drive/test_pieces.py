"""Straight pieces, tones and formulas, and the extremes of their sums: however short, and wherever one looks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.model import read_model
from electrovib.core.samples import Samples
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Linear, Smooth, Tones, even_step
from electrovib.physics.drive.sampled import Sampled

ONCE = Linear(np.array([0.0, 1.0, 3.0]), np.array([0.0, 4.0, -2.0]), np.array([2.0, 6.0, 5.0]))
AGAIN = Linear(ONCE.times, ONCE.before, ONCE.after, 3.0)
STEP = Linear(np.zeros(1), np.zeros(1), np.array([7.0]))


def test_pieces_and_their_ends():
    time = np.array([-0.5, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0])
    assert ONCE.value(time) == pytest.approx([0, 2, 3, 6, 2, 5, 5], abs=1e-15)
    assert ONCE.slope(time) == pytest.approx([0, 2, 2, -4, -4, 0, 0], abs=1e-15)
    assert np.array_equal(STEP.value(time), [0, 7, 7, 7, 7, 7, 7])
    assert (STEP.is_step, ONCE.is_step) == (True, False)
    time = np.array([-0.5, 0.0, 2.0, 3.0, 3.5, 301.0])
    assert AGAIN.value(time) == pytest.approx([0, 2, 2, 2, 3, 6], abs=1e-12)
    assert AGAIN.slope(time) == pytest.approx([-4, 2, -4, 2, 2, -4], abs=1e-12)
    wave = Linear(ONCE.times, np.array([-1.0, 4.0, -2.0]), np.array([2.0, 6.0, 2.0]), 3.0)
    just_before = wave.value_before(np.array([0.5, 1.0, 2.0, 3.0, 4.0, 300.0]))
    assert just_before == pytest.approx([3, 4, 2, -2, 4, -2])
    assert STEP.value_before(np.array([1.0]))[0] == 7
    index, elapsed = ONCE.locate(np.array([0.0, 0.25, 1.0, 1.0 - 1e-16, 2.5, 3.5]))
    assert np.array_equal(index, [0, 0, 1, 1, 1, 2])
    assert elapsed == pytest.approx([0, 0.25, 0, 0, 1.5, 0.5], abs=1e-15)
    assert np.all(elapsed >= 0)


@pytest.mark.parametrize("end", [0.1, 2.999, 3.0, 3.001, 100.0])
def test_repetition_written_out(end):
    long = AGAIN.until(end)
    assert long.period is None
    assert end <= long.times[-1] < end + 3.0
    time = np.linspace(0, end, 1013, endpoint=False)
    assert np.max(np.abs(long.value(time) - AGAIN.value(time))) < 1e-12
    assert long.before[0] == 0  # off before it begins
    assert np.array_equal(long.before[len(AGAIN.times) - 1 :: 2], np.full(len(long.times[2::2]), -2.0))
    assert ONCE.until(end) is ONCE


@pytest.mark.parametrize("frequency", [60, 7, 0.1, 12345.6])
def test_a_rounded_time_of_a_jump_counts_as_the_jump(frequency):
    """k/f computed by two formulas differs by a rounding and may lie on either side of a step: the value is that after it."""
    period = 1 / frequency
    levels = np.array([-1.0, 1.0, -1.0])
    wave = Linear(np.array([0, period / 2, period]), levels, -levels, period)
    count = np.arange(2000)
    for rising in (count / frequency, count * period, np.linspace(0, 1999 / frequency, 2000)):
        assert np.all(wave.value(rising) == 1)
    for falling in ((count + 0.5) / frequency, (2 * count + 1) * (period / 2)):
        assert np.all(wave.value(falling) == -1)
        assert np.all(wave.value(falling - 1e-6 * period * (count + 1) / 1000) == 1)


def test_tones_and_formulas_between_two_times():
    tones = Tones(np.array([0.0, 10.0]), np.array([3.0, 2.0 - 1.0j]), 0.1, 0.4)
    time = np.array([[0.05, 0.1, 0.25], [0.4, 0.5, np.nan]])
    angle = 2 * np.pi * 10 * time
    on = np.array([[0, 1, 1], [0, 0, 1]])
    expected = on * (3 + 2 * np.cos(angle) + np.sin(angle))
    assert tones.value(time) == pytest.approx(expected, abs=1e-13, nan_ok=True)
    expected = on * 2 * np.pi * 10 * (-2 * np.sin(angle) + np.cos(angle))
    assert tones.slope(time) == pytest.approx(expected, abs=1e-11, nan_ok=True)
    part = Smooth(np.square, lambda t: 2 * t, 1.0, 3.0, 1.0)
    time = np.array([0.5, 1.0, 2.0, 3.0, np.nan])
    assert part.value(time) == pytest.approx([0, 1, 4, 0, np.nan], nan_ok=True)
    assert part.slope(time[:4]) == pytest.approx([0, 2, 4, 0])


def trapezium(high, rise, hold, fall, **more):
    return {"model": "Trapezium", "high": high, "rise": rise, "hold": hold, "fall": fall, **more}


def sine(amplitude, frequency, phase=0.0):
    return {"model": "Sine", "amplitude": amplitude, "frequency": frequency, "phase": phase}


def burst(amplitude, frequency, cycles, delay=0.0):
    content = {"amplitude": amplitude, "frequency": frequency, "cycles": cycles, "delay": delay}
    return {"model": "Burst"} | content


def chirp(amplitude, first, last, length):
    return {"model": "Chirp", "amplitude": amplitude, "first": first, "last": last, "length": length}


def on(content, level):
    return {"model": "Offset", "drive": content, "level": level}


def drive(*contents):
    content = contents[0] if len(contents) == 1 else {"model": "Sum", "drives": list(contents)}
    return read_model(Drive, content)


SHORT = trapezium(100, 0, 8e-6, 0, delay=20e-3)
PULSES = {"model": "PulseTrain", "high": 80, "low": -90, "width": 1e-6, "frequency": 3, "edge": 1e-9}


@pytest.mark.parametrize(
    ("content", "low", "high"),
    [
        (SHORT, 0, 100),
        (on(SHORT, 50), 50, 150),
        (on(SHORT, -50), -50, 50),
        (SHORT | {"repeat": 0.1, "low": -30}, -30, 100),
        (PULSES, -90, 80),
        ({"model": "Step", "level": -40}, -40, -40),
        (on(sine(70, 123.4), 10), -60, 80),
        (burst(30, 250, 3, 1), -30, 30),
        ({"model": "Sampled", "time_samples": [0, 1e-3, 3e-3], "voltage_samples": [5, -7, 2]}, -7, 5),
        (chirp(25, 10, 1000, 0.2), -25, 25),
    ],
)
def test_known_extremes(content, low, high):
    assert drive(content).extremes() == pytest.approx((low, high), rel=1e-11, abs=1e-11)
    assert drive(content).largest() == pytest.approx(max(-low, high), rel=1e-11)


def test_extremes_of_tones():
    """cos x + cos 2x is between -9/8 and 2; a carrier at its crest with the modulation's, 1 + m times itself."""
    modulated = {"carrier": 2e3, "modulation": 90, "depth": 0.5}
    assert drive({"model": "AmplitudeModulation", "amplitude": 10} | modulated).largest() == pytest.approx(15)
    both = drive(sine(1, 50, np.pi / 2), sine(1, 100, np.pi / 2))
    assert both.extremes() == pytest.approx((-9 / 8, 2), rel=1e-12)
    slow = drive(sine(10, 1.0))  # on for part of a cycle
    assert slow.extremes(0, slow.period / 2) == pytest.approx((0, 10), abs=1e-12)
    assert slow.extremes(0, 0.74 * slow.period)[0] > -9.99
    assert slow.extremes(0, 1 / 12) == pytest.approx((0, 5), abs=1e-12)
    assert slow.extremes(0.5, 7 / 12) == pytest.approx((-5, 0), abs=1e-12)
    assert slow.extremes(0.3, 0.3)[0] == pytest.approx(10 * np.sin(0.6 * np.pi))


def test_a_tone_on_a_ramp():
    """v = 100 t + sin(2 pi t)/pi: flat where cos(2 pi t) = -50, that is nowhere; with 1 t, crests at 1/3 + k."""
    both = drive(trapezium(4, 4, 0, 4), sine(1 / np.pi, 1.0))
    crest = 4 - 2 / 3 + np.sin(2 * np.pi / 3) / np.pi  # t = 3 + 1/3
    assert both.extremes(0, 3.5)[1] == pytest.approx(crest, rel=1e-13)
    steep = drive(trapezium(400, 4, 0, 4), sine(1 / np.pi, 1.0))
    assert steep.extremes(0, 3.9)[1] == pytest.approx(390 + np.sin(7.8 * np.pi) / np.pi, rel=1e-13)


def test_more_than_can_be_searched_is_bounded():
    """Frequencies with no common period over very many cycles: the sum of the amplitudes, never less."""
    pair = drive(sine(1, 1e7), sine(2, np.pi * 1e7), trapezium(3, 1, 1, 1))
    assert pair.period is None
    assert pair.extremes() == (-3.0, 6.0)
    assert drive({"model": "Square", "high": 5, "frequency": 1e7}, sine(2, np.pi)).largest() == 7.0


def of_times(low, high, delay, rise, hold, fall, rest):
    repeat = None if rest is None else delay + rise + hold + fall + rest
    return trapezium(high, rise, hold, fall, low=low, delay=delay, repeat=repeat)


NUMBERS = st.floats(-100, 100, allow_subnormal=False)  # whose products keep their digits
POSITIVE, TIMES = st.floats(0, 100, allow_subnormal=False), st.floats(1e-4, 3e-2)
EDGES = st.just(0.0) | TIMES
KINDS = st.one_of(
    st.builds(of_times, NUMBERS, NUMBERS, TIMES, EDGES, TIMES, EDGES, st.none() | TIMES),
    st.builds(sine, POSITIVE, st.floats(5, 300), st.floats(-3, 3)),
    st.builds(burst, POSITIVE, st.floats(30, 300), st.integers(1, 5), TIMES),
    st.builds(chirp, POSITIVE, st.floats(0, 300), st.floats(1, 300), TIMES),
    st.builds(lambda level: {"model": "Step", "level": level}, NUMBERS),
)
SUMS = st.lists(KINDS, min_size=1, max_size=4)


@given(kinds=SUMS, end=st.floats(5e-3, 0.1))
@settings(max_examples=80)
def test_random_drives_against_many_looks(kinds, end):
    """Never below what any look finds, and above it by no more than looks can miss."""
    one = drive(*kinds)
    corners = one.corners(end)[0]
    looks = np.concatenate([np.linspace(0, end, 20_001), corners * (1 - 1e-9), corners])
    looks = np.unique(looks[looks <= end])
    seen = one.voltage(looks)
    low, high = one.extremes(0.0, end)
    size = sum(part.bound() for part in one.parts())
    phases = [2 * np.pi * part.highest_frequency * end / 20_000 for part in one.parts()]
    sharp = sum(part.bound() * phase**2 for part, phase in zip(one.parts(), phases, strict=True))
    sharp += 1e-9 * end * 2 * size / 1e-4 + 1e-9 * size  # the steepest edge and tone just before a corner
    assert np.min(seen) - sharp <= low <= np.min(seen) + 1e-9 * size
    assert np.max(seen) - 1e-9 * size <= high <= np.max(seen) + sharp


@given(kinds=SUMS, end=st.floats(5e-3, 0.1))
def test_corners_are_where_it_jumps_and_bends(kinds, end):
    one = drive(*kinds)
    times, heights = one.corners(end)
    assert np.all(np.diff(times) > 0)
    assert np.all((times > 0) & (times <= end))
    size = sum(part.bound() for part in one.parts()) or 1.0
    tiny = 1e-10
    found = one.voltage(times) - one.voltage(times - tiny)
    if not len(times) or np.min(np.diff(times, prepend=0.0, append=np.inf)) > tiny:
        np.testing.assert_allclose(heights, found, rtol=0, atol=3e-6 * size)


def test_breaks_that_differ_by_rounding_are_one_corner_with_the_sum_of_their_steps():
    close = np.array([0.0, 1.0, 1.0 + 3e-15, 2.0])
    voltage = np.array([0.0, 10.0, 30.0, 30.0])
    one = Sampled(time_samples=Samples(close), voltage_samples=Samples(voltage))
    assert list(one.corners(2.0)[0]) == [1.0, 2.0]


@pytest.mark.parametrize(("off", "expected"), [(0.0, 1e-3), (1e-9, None), (-1e-9, None), (np.nan, None)])
def test_one_time_beside_an_even_grid_makes_it_uneven(off, expected):
    times = 1e-3 * np.arange(10_001)
    times[4321] += off
    assert even_step(times) == (None if expected is None else pytest.approx(expected))


def test_frequency_and_shortest_piece():
    one = drive(SHORT, sine(1, 30), burst(1, 90, 1))
    assert one.highest_frequency == 90
    assert one.shortest_piece(1.0) == pytest.approx(8e-6)
    assert drive(SHORT).highest_frequency == 0
    assert drive({"model": "Step", "level": 1}).shortest_piece(1.0) == np.inf
    three = drive(burst(1, 100, 3, 0.5))
    found = [three.shortest_piece(end) for end in (10, 0.51, 0.1)]
    assert found == pytest.approx([0.03, 0.01, np.inf])
