"""Spectra of repeating drives against the FFT and textbook series; the steady response they make."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve.stack.harmonics import count_harmonics, spectrum


def drive(model, **content):
    return read_model(Drive, {"model": model} | content)


def modulated(model, carrier, modulation, depth):
    return drive(model, amplitude=80, carrier=carrier, modulation=modulation, depth=depth)


AM, ROOT = "AmplitudeModulation", "SquareRootModulation"
SINE = drive("Sine", amplitude=100, frequency=125, phase=0.7)
TONES = {
    "sine": SINE,
    "offset": drive("Offset", level=30, drive=SINE.to_dict()),
    "modulated": modulated(AM, 2000, 125, 0.6),
    "carrier below the modulation": modulated(AM, 125, 500, 1),
    "carrier at the modulation": modulated(AM, 250, 250, 1),
    "root": modulated(ROOT, 2000, 125, 0.9),
    "full root": modulated(ROOT, 2000, 250, 1),
    "root below its sidebands": modulated(ROOT, 250, 125, 0.7),
    "sum": drive("Sum", drives=[SINE.to_dict(), {"model": "Sine", "amplitude": 20, "frequency": 375}]),
}
RISING = {"delay": 1e-3, "rise": 2e-3, "hold": 4e-3, "fall": 3e-3, "repeat": 0.02}
EDGES = {
    "triangle": drive("Square", high=100, low=-20, frequency=50, edge=0.01),
    "square": drive("Square", high=100, low=-20, frequency=50),
    "edges": drive("Square", high=100, frequency=50, edge=1e-3),
    "pulses": drive("PulseTrain", high=100, low=5, width=3e-3, frequency=50, edge=1e-3),
    "trapezium": drive("Trapezium", high=100, low=-7, **RISING),
    "full": drive("Trapezium", high=100, rise=0.005, hold=0.01, fall=0.005, repeat=0.02),
}


@pytest.mark.parametrize("name", TONES)
def test_tones_against_the_transform(name):
    """Exact: every frequency of the drive lies on a line of the transform over 8 ms, up to 512 kHz."""
    one, count = TONES[name], 8192
    lines = np.fft.rfft(one.voltage(np.arange(count) * 8e-3 / count)) / count
    lines[1:] *= 2
    frequencies, amplitudes = spectrum(one, harmonics=1)
    assert np.all(np.diff(frequencies) > 0)
    assert np.all(frequencies >= 0)
    found = np.zeros(len(lines), complex)
    places = np.round(frequencies * 8e-3).astype(int)
    assert frequencies * 8e-3 == pytest.approx(places, abs=1e-9)
    inside = places < count // 2
    np.add.at(found, places[inside], np.where(places == 0, amplitudes.real, amplitudes)[inside])
    assert np.max(np.abs(found - lines)) < 1e-12 * 100


@pytest.mark.parametrize("name", EDGES)
def test_edges_against_the_transform(name):
    """A transform of straight pieces folds harmonics 2**18 apart: below 1e-9 for bends, 1e-5 at a jump."""
    count = 1 << 18
    lines = (
        np.fft.rfft(EDGES[name].voltage((np.arange(count) + 0.5) * 0.02 / count)) / count
    )  # breaks between
    lines[1:] *= 2
    lines *= np.exp(-1j * np.pi * np.arange(len(lines)) / count)
    frequencies, amplitudes = spectrum(EDGES[name], harmonics=40)
    assert frequencies == pytest.approx(50 * np.arange(41), rel=1e-12)
    assert np.max(np.abs(amplitudes - lines[:41])) < 1e-8 * 100


def test_square_wave_of_the_textbook():
    frequencies, amplitudes = spectrum(EDGES["square"], harmonics=9)
    order = np.arange(1, 10)
    expected = np.where(order % 2, -1j * 4 * 60 / (np.pi * order), 0)  # 40 V +- 60 V, sines
    assert amplitudes[0] == pytest.approx(40, rel=1e-14)
    assert np.max(np.abs(amplitudes[1:] - expected)) < 1e-13 * 100
    assert frequencies[-1] == 450


@pytest.mark.parametrize(
    ("count", "ones"),
    [
        (1, [SINE, drive("Offset", level=0, drive=SINE.to_dict()), modulated(AM, 2000, 125, 0)]),
        (2, [TONES["offset"], TONES["full root"], TONES["sum"]]),
        (2, [drive("Sum", drives=[SINE.to_dict(), {"model": "Step", "level": 5}])]),
        (3, [TONES["modulated"]]),
        (
            None,
            [EDGES["square"], drive("Step", level=10), drive("Burst", amplitude=1, frequency=10, cycles=3)],
        ),
    ],
)
def test_number_of_harmonics(count, ones):
    for one in ones:
        assert count_harmonics(one) == count


def test_a_part_that_does_not_repeat_is_refused():
    with pytest.raises(InputError, match="does not repeat"):
        spectrum(drive("Chirp", amplitude=1, first=1, last=2, length=1), harmonics=3)
