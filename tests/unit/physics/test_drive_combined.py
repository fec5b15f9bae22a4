"""Sums of drives and offsets: values and periods."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.drive.combined import Offset, Sum

SINE = {"model": "Sine", "amplitude": 3, "frequency": 50}
TIME = np.linspace(0, 0.1, 501)


def together(*drives):
    return read_model(Sum, {"drives": list(drives)})


def test_offset():
    drive = read_model(Offset, {"drive": SINE, "level": -7})
    assert np.max(np.abs(drive.voltage(TIME) - 3 * np.sin(100 * np.pi * TIME) + 7)) < 1e-13
    assert drive.period == 0.02
    assert drive.duration == 0.1
    assert drive.slope(0.0) == pytest.approx(300 * np.pi, rel=1e-12)


def test_sum_of_sums():
    square = {"model": "Square", "high": 1, "frequency": 20}
    inner = {"model": "Sum", "drives": [SINE, square]}
    drive = together(inner, {"model": "Offset", "drive": SINE, "level": 2})
    on = np.arange(501) % 250 < 125
    expected = 6 * np.sin(100 * np.pi * TIME) + 2 + on
    assert np.max(np.abs(drive.voltage(TIME) - expected)) < 1e-12


@pytest.mark.parametrize(
    ("others", "period"),
    [
        ([{"model": "Sine", "amplitude": 1, "frequency": 75}], 0.04),
        ([{"model": "Square", "high": 1, "frequency": 20}], 0.1),
        ([{"model": "Step", "level": 5}], 0.02),
        ([{"model": "Step", "level": 5}, {"model": "Sine", "amplitude": 1, "frequency": 25}], 0.04),
        ([{"model": "Burst", "amplitude": 1, "frequency": 25, "cycles": 1}], None),
        ([{"model": "Trapezium", "high": 1, "rise": 1, "hold": 1, "fall": 1}], None),
        ([{"model": "Sine", "amplitude": 1, "frequency": 50 * np.sqrt(3)}], None),
    ],
)
def test_period(others, period):
    found = together(SINE, *others).period
    assert found == (None if period is None else pytest.approx(period, rel=1e-12))


def test_constants_alone_have_no_period():
    drive = together({"model": "Step", "level": 5}, {"model": "Step", "level": -2})
    assert drive.period is None
    assert np.all(drive.voltage(TIME) == 3)


def test_duration_is_the_longest():
    assert together(SINE, {"model": "Step", "level": 1}, SINE | {"frequency": 10}).duration == 0.5
