"""Straight pieces, tones and formulas: values at jumps, repetition written out, switching."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.physics.drive.parts import Smooth, Tones
from electrovib.physics.drive.pieces import Linear

ONCE = Linear(np.array([0.0, 1.0, 3.0]), np.array([0.0, 4.0, -2.0]), np.array([2.0, 6.0, 5.0]))
AGAIN = Linear(np.array([0.0, 1.0, 3.0]), ONCE.before, ONCE.after, 3.0)
STEP = Linear(np.zeros(1), np.zeros(1), np.array([7.0]))


def test_pieces_and_their_ends():
    time = np.array([-0.5, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0])
    assert ONCE.value(time) == pytest.approx([0, 2, 3, 6, 2, 5, 5], abs=1e-15)
    assert ONCE.slope(time) == pytest.approx([0, 2, 2, -4, -4, 0, 0], abs=1e-15)
    assert np.array_equal(STEP.value(time), [0, 7, 7, 7, 7, 7, 7])
    assert STEP.is_step
    assert not ONCE.is_step


def test_repeated_pieces():
    time = np.array([-0.5, 0.0, 2.0, 3.0, 3.5, 301.0])
    assert AGAIN.value(time) == pytest.approx([0, 2, 2, 2, 3, 6], abs=1e-12)
    assert AGAIN.slope(time) == pytest.approx([-4, 2, -4, 2, 2, -4], abs=1e-12)


@pytest.mark.parametrize("end", [0.1, 2.999, 3.0, 3.001, 100.0])
def test_repetition_written_out(end):
    long = AGAIN.until(end)
    assert long.period is None
    assert long.times[-1] >= end
    assert long.times[-1] < end + 3.0
    time = np.linspace(0, end, 1013, endpoint=False)
    assert np.max(np.abs(long.value(time) - AGAIN.value(time))) < 1e-12
    assert long.before[0] == 0  # off before it begins
    assert np.array_equal(long.before[len(AGAIN.times) - 1 :: 2], np.full(len(long.times[2::2]), -2.0))
    assert ONCE.until(end) is ONCE


@pytest.mark.parametrize("frequency", [60, 50, 7, 0.1, 12345.6])
def test_a_rounded_time_of_a_jump_counts_as_the_jump(frequency):
    """k/f computed by two formulas differs by a rounding and may lie on either side of a step: the value is that after it."""
    period = 1 / frequency
    wave = Linear(
        np.array([0, period / 2, period]), np.array([-1.0, 1.0, -1.0]), np.array([1.0, -1.0, 1.0]), period
    )
    count = np.arange(2000)
    for rising in (count / frequency, count * period, np.linspace(0, 1999 / frequency, 2000)):
        assert np.all(wave.value(rising) == 1)
    for falling in ((count + 0.5) / frequency, (2 * count + 1) * (period / 2)):
        assert np.all(wave.value(falling) == -1)
        assert np.all(wave.value(falling - 1e-6 * period * (count + 1) / 1000) == 1)


def test_locate():
    index, elapsed = ONCE.locate(np.array([0.0, 0.25, 1.0, 1.0 - 1e-16, 2.5, 3.5]))
    assert np.array_equal(index, [0, 0, 1, 1, 1, 2])
    assert elapsed == pytest.approx([0, 0.25, 0, 0, 1.5, 0.5], abs=1e-15)
    assert np.all(elapsed >= 0)


def test_tones_between_two_times():
    tones = Tones(np.array([0.0, 10.0]), np.array([3.0, 2.0 - 1.0j]), 0.1, 0.4)
    time = np.array([[0.05, 0.1, 0.25], [0.4, 0.5, np.nan]])
    angle = 2 * np.pi * 10 * time
    on = np.array([[0, 1, 1], [0, 0, 1]])
    expected = on * (3 + 2 * np.cos(angle) + np.sin(angle))
    assert tones.value(time) == pytest.approx(expected, abs=1e-13, nan_ok=True)
    expected = on * 2 * np.pi * 10 * (-2 * np.sin(angle) + np.cos(angle))
    assert tones.slope(time) == pytest.approx(expected, abs=1e-11, nan_ok=True)


def test_formula_between_two_times():
    part = Smooth(np.square, lambda t: 2 * t, 1.0, 3.0, 1.0)
    time = np.array([0.5, 1.0, 2.0, 3.0, np.nan])
    assert part.value(time) == pytest.approx([0, 1, 4, 0, np.nan], nan_ok=True)
    assert part.slope(time[:4]) == pytest.approx([0, 2, 4, 0])
