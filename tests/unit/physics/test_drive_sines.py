"""Drives made of sines against their formulas, and what their squares are for."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.sines import AmplitudeModulation, Burst, Chirp, Sine, SquareRootModulation

TIME = np.linspace(0, 0.05, 2003)
ROUNDING = 1e-12


def test_sine():
    drive = read_model(Sine, {"amplitude": 3, "frequency": 50})
    assert np.max(np.abs(drive.voltage(TIME) - 3 * np.sin(100 * np.pi * TIME))) < ROUNDING * 3
    cosine = read_model(Sine, {"amplitude": 3, "frequency": 50, "phase": "90 deg"})
    assert np.max(np.abs(cosine.voltage(TIME) - 3 * np.cos(100 * np.pi * TIME))) < ROUNDING * 3


@pytest.mark.parametrize("cycles", [1, 7])
def test_burst_begins_and_ends_at_0_volts(cycles):
    drive = read_model(Burst, {"amplitude": 100, "frequency": 250, "cycles": cycles, "delay": 3.3e-3})
    (part,) = drive.parts()
    assert part.stop - part.start == pytest.approx(cycles / 250, rel=1e-14)
    ends = np.array([part.start, np.nextafter(part.stop, 0), part.stop])
    assert np.max(np.abs(drive.voltage(ends))) < 1e-10 * 100  # phase of 3 ms and seven cycles, rounded
    assert np.all(drive.voltage([0, 3.2e-3, part.stop + 1e-9, 1.0]) == 0)
    inside = np.linspace(part.start, part.stop, 99)[1:-1]
    expected = 100 * np.sin(2 * np.pi * 250 * (inside - 3.3e-3))
    assert np.max(np.abs(drive.voltage(inside) - expected)) < 1e-10 * 100
    assert drive.period is None


@pytest.mark.parametrize(("carrier", "modulation"), [(3000, 100), (100, 250), (250, 250)])
def test_amplitude_modulation(carrier, modulation):
    content = {"amplitude": 10, "carrier": carrier, "modulation": modulation, "depth": 0.8}
    drive = read_model(AmplitudeModulation, content)
    envelope = 1 + 0.8 * np.cos(2 * np.pi * modulation * TIME)
    expected = 10 * envelope * np.cos(2 * np.pi * carrier * TIME)
    assert np.max(np.abs(drive.voltage(TIME) - expected)) < ROUNDING * 20
    assert all(np.all(part.frequencies >= 0) for part in drive.parts())


@pytest.mark.parametrize("depth", [0, 0.1, 0.8, 0.99, 1])
@pytest.mark.parametrize(("carrier", "modulation"), [(3000, 100), (100, 250)])
def test_square_root_modulation(carrier, modulation, depth):
    """Its square is (1 + m cos) times the square of the carrier, to 1e-9 and better."""
    content = {"amplitude": 10, "carrier": carrier, "modulation": modulation, "depth": depth}
    drive = read_model(SquareRootModulation, content)
    envelope = 1 + depth * np.cos(2 * np.pi * modulation * TIME)
    square = 100 * envelope * np.cos(2 * np.pi * carrier * TIME) ** 2
    assert np.max(np.abs(drive.voltage(TIME) ** 2 - square)) < 1e-12 * 200
    assert all(np.all(part.frequencies >= 0) for part in drive.parts())
    if depth < 1:
        expected = 10 * np.sqrt(envelope) * np.cos(2 * np.pi * carrier * TIME)
        assert np.max(np.abs(drive.voltage(TIME) - expected)) < ROUNDING * 14


def test_periods_of_modulations():
    content = {"amplitude": 1, "carrier": 3000, "modulation": 70, "depth": 0.5}
    assert read_model(AmplitudeModulation, content).period == pytest.approx(0.1, rel=1e-12)
    assert read_model(SquareRootModulation, content).period == pytest.approx(0.1, rel=1e-12)
    full = read_model(SquareRootModulation, content | {"depth": 1})
    assert full.period == pytest.approx(
        0.2, rel=1e-12
    )  # the smooth branch of the root has half the frequency
    apart = content | {"carrier": 1000 * np.sqrt(2)}
    assert read_model(AmplitudeModulation, apart).period is None


@pytest.mark.parametrize(("first", "last"), [(10, 1000), (1000, 10), (0, 300)])
def test_chirp(first, last):
    drive = read_model(Chirp, {"amplitude": 5, "first": first, "last": last, "length": 0.04})
    time = TIME[TIME < 0.04]
    phase = 2 * np.pi * (first * time + (last - first) / 0.04 * time**2 / 2)
    assert np.max(np.abs(drive.voltage(time) - 5 * np.sin(phase))) < ROUNDING * 5
    assert np.all(drive.voltage(TIME[TIME > 0.04]) == 0)
    (part,) = drive.parts()
    turns = np.unwrap(np.arctan2(np.sin(phase), np.cos(phase)))
    fastest = np.max(np.abs(np.diff(turns))) / (2 * np.pi * TIME[1])
    assert fastest == pytest.approx(part.highest_frequency, rel=2e-3)


@pytest.mark.parametrize(
    ("kind", "content", "why"),
    [
        (Burst, {"amplitude": 1, "frequency": 50, "cycles": 0}, "cycles must be a whole number"),
        (Burst, {"amplitude": 1, "frequency": 50, "cycles": 2.5}, "cycles"),
        (
            AmplitudeModulation,
            {"amplitude": 1, "carrier": 50, "modulation": 5, "depth": 1.1},
            "between 0 and 1",
        ),
        (Sine, {"amplitude": -1, "frequency": 50}, "amplitude = -1"),
    ],
)
def test_refusals(kind, content, why):
    with pytest.raises(InputError, match=why):
        read_model(kind, content)
