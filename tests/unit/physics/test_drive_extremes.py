"""The largest value of a drive is that of the drive, however briefly it is there and wherever one looks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.pieces import Linear

SHORT = {"model": "Trapezium", "high": 100, "delay": 20e-3, "rise": 0, "hold": 8e-6, "fall": 0}


def drive(content):
    return read_model(Drive, content)


def plus(*drives):
    return drive({"model": "Sum", "drives": list(drives)})


def sine(amplitude, frequency, phase=0.0):
    return {"model": "Sine", "amplitude": amplitude, "frequency": frequency, "phase": phase}


def on(content, level):
    return {"model": "Offset", "drive": content, "level": level}


@pytest.mark.parametrize(
    ("content", "low", "high"),
    [
        (SHORT, 0, 100),
        (on(SHORT, 50), 50, 150),
        (on(SHORT, -50), -50, 50),
        (SHORT | {"repeat": 0.1, "low": -30}, -30, 100),
        (
            {"model": "PulseTrain", "high": 80, "low": -90, "width": 1e-6, "frequency": 3, "edge": 1e-9},
            -90,
            80,
        ),
        ({"model": "Step", "level": -40}, -40, -40),
        (sine(70, 123.4), -70, 70),
        (on(sine(70, 123.4), 10), -60, 80),
        ({"model": "Burst", "amplitude": 30, "frequency": 250, "cycles": 3, "delay": 1}, -30, 30),
        ({"model": "Sampled", "time_samples": [0, 1e-3, 3e-3], "voltage_samples": [5, -7, 2]}, -7, 5),
        ({"model": "Chirp", "amplitude": 25, "first": 10, "last": 1000, "length": 0.2}, -25, 25),
    ],
)
def test_known_extremes(content, low, high):
    assert drive(content).extremes() == pytest.approx((low, high), rel=1e-11, abs=1e-11)
    assert drive(content).largest() == pytest.approx(max(-low, high), rel=1e-11)


def test_two_tones():
    """cos x + cos 2x is between -9/8 and 2; a carrier at its crest with the modulation's, 1 + m times itself."""
    modulated = {
        "model": "AmplitudeModulation",
        "amplitude": 10,
        "carrier": 2e3,
        "modulation": 90,
        "depth": 0.5,
    }
    assert drive(modulated).largest() == pytest.approx(15, rel=1e-12)
    both = plus(sine(1, 50, np.pi / 2), sine(1, 100, np.pi / 2))
    assert both.extremes() == pytest.approx((-9 / 8, 2), rel=1e-12)


def test_a_tone_that_is_on_for_part_of_a_cycle():
    assert drive(sine(10, 1.0)).extremes(0, 1 / 12) == pytest.approx((0, 5), abs=1e-12)
    assert drive(sine(10, 1.0)).extremes(0.5, 7 / 12) == pytest.approx((-5, 0), abs=1e-12)
    assert drive(sine(10, 1.0)).extremes(0.3, 0.3)[0] == pytest.approx(10 * np.sin(0.6 * np.pi))


def test_a_tone_on_a_ramp():
    """v = 100 t + sin(2 pi t)/pi: flat where cos(2 pi t) = -50, that is nowhere; with 1 t, crests at 1/3 + k."""
    ramp = {"model": "Trapezium", "high": 4, "rise": 4, "hold": 0, "fall": 4}
    both = plus(ramp, sine(1 / np.pi, 1.0))
    crest = 4 - 2 / 3 + np.sin(2 * np.pi / 3) / np.pi  # t = 3 + 1/3
    assert both.extremes(0, 3.5)[1] == pytest.approx(crest, rel=1e-13)
    steep = plus(ramp | {"high": 400}, sine(1 / np.pi, 1.0))
    assert steep.extremes(0, 3.9)[1] == pytest.approx(390 + np.sin(7.8 * np.pi) / np.pi, rel=1e-13)


def test_more_than_can_be_searched_is_bounded():
    """Frequencies with no common period over very many cycles: the sum of the amplitudes, never less."""
    pair = plus(
        sine(1, 1e7), sine(2, np.pi * 1e7), {"model": "Trapezium", "high": 3, "rise": 1, "hold": 1, "fall": 1}
    )
    assert pair.period is None
    assert pair.extremes() == (-3.0, 6.0)
    fast = plus({"model": "Square", "high": 5, "frequency": 1e7}, sine(2, np.pi))
    assert fast.largest() == 7.0


NUMBERS = st.floats(-100, 100)
TIMES = st.floats(1e-4, 3e-2)
STRAIGHT = st.builds(
    lambda low, high, delay, rise, hold, fall, rest: {
        "model": "Trapezium",
        "low": low,
        "high": high,
        "delay": delay,
        "rise": rise,
        "hold": hold,
        "fall": fall,
        "repeat": None if rest is None else delay + rise + hold + fall + rest,
    },
    NUMBERS,
    NUMBERS,
    TIMES,
    st.just(0.0) | TIMES,
    TIMES,
    st.just(0.0) | TIMES,
    st.none() | TIMES,
)
TONE = st.builds(sine, st.floats(0, 100), st.floats(5, 300), st.floats(-3, 3))
BURST = st.builds(
    lambda amplitude, frequency, cycles, delay: {
        "model": "Burst",
        "amplitude": amplitude,
        "frequency": frequency,
        "cycles": cycles,
        "delay": delay,
    },
    st.floats(0, 100),
    st.floats(30, 300),
    st.integers(1, 5),
    TIMES,
)
CHIRP = st.builds(
    lambda amplitude, first, last, length: {
        "model": "Chirp",
        "amplitude": amplitude,
        "first": first,
        "last": last,
        "length": length,
    },
    st.floats(0, 100),
    st.floats(0, 300),
    st.floats(1, 300),
    TIMES,
)
KINDS = st.one_of(STRAIGHT, TONE, BURST, CHIRP, st.builds(lambda v: {"model": "Step", "level": v}, NUMBERS))


@given(kinds=st.lists(KINDS, min_size=1, max_size=4), end=st.floats(5e-3, 0.1))
@settings(max_examples=80)
def test_random_drives_against_many_looks(kinds, end):
    """Never below what any look finds, and above it by no more than looks can miss."""
    one = plus(*kinds)
    corners = one.corners(end)[0]
    before = np.concatenate([corners * (1 - 1e-9), corners])
    looks = np.unique(np.concatenate([np.linspace(0, end, 20_001), before]))
    seen = one.voltage(looks[looks <= end])
    low, high = one.extremes(0.0, end)
    size = sum(part.bound() for part in one.parts())
    sharp = sum(
        part.bound() * (2 * np.pi * part.highest_frequency * (looks[1] - looks[0])) ** 2
        for part in one.parts()
    )
    sharp += 1e-9 * end * 2 * size / 1e-4 + 1e-9 * size  # the steepest edge and tone just before a corner
    assert low <= np.min(seen) + 1e-9 * size
    assert high >= np.max(seen) - 1e-9 * size
    assert low >= np.min(seen) - sharp
    assert high <= np.max(seen) + sharp


@given(kinds=st.lists(KINDS, min_size=1, max_size=4), end=st.floats(5e-3, 0.1))
def test_corners_are_where_it_jumps_and_bends(kinds, end):
    one = plus(*kinds)
    times, heights = one.corners(end)
    assert np.all(np.diff(times) > 0)
    assert np.all((times > 0) & (times <= end))
    size = sum(part.bound() for part in one.parts()) or 1.0
    tiny = 1e-10
    found = one.voltage(times) - one.voltage(times - tiny)
    alone = np.min(np.diff(times, prepend=0.0, append=np.inf)) > tiny if len(times) else True
    if alone:
        np.testing.assert_allclose(heights, found, rtol=0, atol=3e-6 * size)


def test_frequency_and_pieces():
    one = plus(
        SHORT, sine(1, 30), {"model": "Burst", "amplitude": 1, "frequency": 90, "cycles": 1, "delay": 0}
    )
    assert one.highest_frequency == 90
    assert one.shortest_piece(1.0) == pytest.approx(8e-6)
    assert drive(SHORT).highest_frequency == 0
    assert drive({"model": "Step", "level": 1}).shortest_piece(1.0) == np.inf
    burst = drive({"model": "Burst", "amplitude": 1, "frequency": 100, "cycles": 3, "delay": 0.5})
    assert burst.shortest_piece(10) == pytest.approx(0.03)
    assert burst.shortest_piece(0.51) == pytest.approx(0.01)
    assert burst.shortest_piece(0.1) == np.inf


def test_just_before_a_jump():
    wave = Linear(np.array([0.0, 1.0, 3.0]), np.array([-1.0, 4.0, -2.0]), np.array([2.0, 6.0, 2.0]), 3.0)
    assert wave.value_before(np.array([0.5, 1.0, 2.0, 3.0, 4.0, 300.0])) == pytest.approx(
        [3, 4, 2, -2, 4, -2]
    )
    step = Linear(np.zeros(1), np.zeros(1), np.array([7.0]))
    assert step.value_before(np.array([1.0]))[0] == 7
