"""Drives made of straight pieces: their corners, what fits in a period, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.edges import PulseTrain, Square, Step, Trapezium


def at(drive, *times):
    return drive.voltage(np.array(times))


def test_constant():
    drive = read_model(Step, {"level": -5})
    assert np.array_equal(at(drive, -1e-12, 0, 1e9), [0, -5, -5])
    assert drive.period is None


def test_trapezium_once():
    drive = read_model(Trapezium, {"high": 10, "low": 2, "delay": 1, "rise": 2, "hold": 3, "fall": 4})
    expected = [0, 2, 2, 6, 10, 10, 6, 2, 2]
    assert at(drive, -1, 0, 1, 2, 3, 6, 8, 10, 99) == pytest.approx(expected, abs=1e-14)
    assert drive.period is None
    assert drive.duration == 13


def test_trapezium_repeated():
    drive = read_model(Trapezium, {"high": 10, "rise": 1, "hold": 1, "fall": 1, "repeat": 5})
    assert at(drive, 0.5, 1.5, 2.5, 4, 5.5, 1001.5) == pytest.approx([5, 10, 5, 0, 5, 10], abs=1e-11)
    assert drive.period == drive.duration == 5


@pytest.mark.parametrize("edges", [(0, 0.01), (0.01, 0), (0, 0)])
def test_trapezium_with_jumps(edges):
    drive = read_model(Trapezium, {"high": 10, "rise": edges[0], "hold": 1, "fall": edges[1], "delay": 1})
    assert at(drive, 1 - 1e-9, 1 + edges[0], 1 + edges[0] + 1 - 1e-9, 2.02) == pytest.approx([0, 10, 10, 0])


def test_times_that_fill_the_period_but_for_rounding():
    """0.1 + 0.2 is above 0.3 by a rounding, and still fits."""
    drive = read_model(Trapezium, {"high": 10, "rise": 0.1, "hold": 0.2, "fall": 0, "repeat": 0.3})
    (part,) = drive.parts()
    assert part.times[-1] == 0.3
    assert np.all(np.diff(part.times) > 1e-3)
    assert at(drive, 0.05, 0.1, 0.29999, 0.35) == pytest.approx([5, 10, 10, 5])
    third = 1 / 3
    drive = read_model(PulseTrain, {"high": 10, "width": 2 * third, "frequency": 1, "edge": 1 - 2 * third})
    assert drive.parts()[0].times[-1] == 1
    drive = read_model(Square, {"high": 10, "frequency": 300, "edge": 1 / 600 * (1 + 1e-15)})
    assert drive.parts()[0].times == pytest.approx([0, 1 / 600, 1 / 300], rel=1e-15)
    with pytest.raises(InputError, match="repeat must be at least"):
        read_model(Trapezium, {"high": 10, "rise": 0.1, "hold": 0.2, "fall": 0, "repeat": 0.3 * (1 - 1e-9)})


def test_square():
    drive = read_model(Square, {"high": 10, "low": -4, "frequency": 0.5})
    assert np.array_equal(at(drive, 0, 0.5, 1, 1.5, 2, 2.5, 3), [10, 10, -4, -4, 10, 10, -4])
    sloped = read_model(Square, {"high": 10, "low": -4, "frequency": 0.5, "edge": 0.5})
    assert at(sloped, 0, 0.25, 0.5, 0.9, 1, 1.25, 1.5, 1.9) == pytest.approx([-4, 3, 10, 10, 10, 3, -4, -4])


def test_triangle():
    drive = read_model(Square, {"high": 1, "low": -1, "frequency": 50, "edge": 0.01})
    assert at(drive, 0, 0.005, 0.01, 0.015, 0.02) == pytest.approx([-1, 0, 1, 0, -1], abs=1e-12)


def test_pulses():
    drive = read_model(PulseTrain, {"high": 10, "width": 0.25, "frequency": 1})
    assert np.array_equal(at(drive, 0, 0.2, 0.25, 0.9, 1.1), [10, 10, 0, 0, 10])
    sloped = read_model(PulseTrain, {"high": 10, "low": 1, "width": 0.25, "frequency": 1, "edge": 0.1})
    assert at(sloped, 0, 0.05, 0.1, 0.25, 0.3, 0.35, 0.9) == pytest.approx([1, 5.5, 10, 10, 5.5, 1, 1])
    always = read_model(PulseTrain, {"high": 10, "width": 1, "frequency": 1})
    assert np.array_equal(at(always, 0, 0.5, 1.0, 1.5), [10, 10, 10, 10])


@pytest.mark.parametrize(
    ("kind", "content", "why"),
    [
        (Trapezium, {"high": 1, "rise": 1, "hold": 1, "fall": 1, "repeat": 2}, "at least .* = 3 s"),
        (Square, {"high": 1, "frequency": 50, "edge": 0.011}, "half a period, 0.01 s"),
        (PulseTrain, {"high": 1, "width": 1e-3, "frequency": 50, "edge": 2e-3}, "edge <= width"),
        (PulseTrain, {"high": 1, "width": 0.019, "frequency": 50, "edge": 2e-3}, "width . edge <= period"),
        (
            Square,
            {"high": 1, "frequency": 0},
            "frequency = 0: must lie between 1 mHz and 100 MHz",
        ),
        (Step, {"level": float("nan")}, "must be a finite number"),
    ],
)
def test_refusals(kind, content, why):
    with pytest.raises(InputError, match=why):
        read_model(kind, content)
