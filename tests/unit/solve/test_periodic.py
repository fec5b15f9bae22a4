"""Spectra of repeating drives against the FFT and textbook series; the steady response they make."""

from __future__ import annotations

import numpy as np
import pytest
from harmonic_response import periodic

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve.stack.harmonics import count_harmonics, spectrum


def drive(model, **content):
    return read_model(Drive, {"model": model} | content)


SINE = drive("Sine", amplitude=100, frequency=125, phase=0.7)
TONES = {
    "sine": SINE,
    "offset": drive("Offset", level=30, drive=SINE.to_dict()),
    "modulated": drive("AmplitudeModulation", amplitude=80, carrier=2000, modulation=125, depth=0.6),
    "carrier below the modulation": drive(
        "AmplitudeModulation", amplitude=80, carrier=125, modulation=500, depth=1
    ),
    "carrier at the modulation": drive(
        "AmplitudeModulation", amplitude=80, carrier=250, modulation=250, depth=1
    ),
    "root": drive("SquareRootModulation", amplitude=80, carrier=2000, modulation=125, depth=0.9),
    "full root": drive("SquareRootModulation", amplitude=80, carrier=2000, modulation=250, depth=1),
    "root below its sidebands": drive(
        "SquareRootModulation", amplitude=80, carrier=250, modulation=125, depth=0.7
    ),
    "sum": drive("Sum", drives=[SINE.to_dict(), {"model": "Sine", "amplitude": 20, "frequency": 375}]),
}
EDGES = {
    "triangle": drive("Square", high=100, low=-20, frequency=50, edge=0.01),
    "square": drive("Square", high=100, low=-20, frequency=50),
    "edges": drive("Square", high=100, frequency=50, edge=1e-3),
    "pulses": drive("PulseTrain", high=100, low=5, width=3e-3, frequency=50, edge=1e-3),
    "trapezium": drive(
        "Trapezium", high=100, low=-7, delay=1e-3, rise=2e-3, hold=4e-3, fall=3e-3, repeat=0.02
    ),
    "full": drive("Trapezium", high=100, rise=0.005, hold=0.01, fall=0.005, repeat=0.02),
}


@pytest.mark.parametrize("one", TONES.values(), ids=TONES)
def test_tones_against_the_transform(one):
    """Exact: every frequency of the drive lies on a line of the transform over 8 ms, up to 512 kHz."""
    count = 8192
    time = np.arange(count) * 8e-3 / count
    lines = np.fft.rfft(one.voltage(time)) / count
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


@pytest.mark.parametrize("one", EDGES.values(), ids=EDGES)
def test_edges_against_the_transform(one):
    """A transform of straight pieces folds harmonics 2**18 apart: below 1e-9 for bends, 1e-5 at a jump."""
    count = 1 << 18
    time = (np.arange(count) + 0.5) * 0.02 / count  # breaks between samples
    lines = np.fft.rfft(one.voltage(time)) / count
    lines[1:] *= 2
    lines *= np.exp(-1j * np.pi * np.arange(len(lines)) / count)
    frequencies, amplitudes = spectrum(one, harmonics=40)
    assert frequencies == pytest.approx(50 * np.arange(41), rel=1e-12)
    assert np.max(np.abs(amplitudes - lines[:41])) < 1e-8 * 100


def test_square_wave_of_the_textbook():
    frequencies, amplitudes = spectrum(EDGES["square"], harmonics=9)
    order = np.arange(1, 10)
    expected = np.where(order % 2, -1j * 4 * 60 / (np.pi * order), 0)  # 40 V +- 60 V, sines
    assert amplitudes[0] == pytest.approx(40, rel=1e-14)
    assert np.max(np.abs(amplitudes[1:] - expected)) < 1e-13 * 100
    assert frequencies[-1] == 450


def test_harmonics_add_up_to_the_drive():
    one = EDGES["edges"]
    time = np.linspace(0, 0.04, 401)
    found = periodic(np.ones_like, one, time, static=1.0, harmonics=2000)
    # four bends of 1e5 V/s a period, 1/(n + 1)^2 at worst added up
    assert np.max(np.abs(found - one.voltage(time))) < 4 * 1e5 * 0.02 / (2 * np.pi**2) / 2000
    coarse = periodic(np.ones_like, one, time, static=1.0, harmonics=5)
    assert np.max(np.abs(coarse - one.voltage(time))) > 1


def test_response_and_static_value():
    time = np.linspace(0, 0.02, 101)
    one = TONES["offset"]
    low_pass = lambda f: 1 / (1 + 2j * np.pi * f * 1e-3)  # noqa: E731 - a formula
    found = periodic(low_pass, one, time, static=0.25)
    gain = low_pass(125.0)
    expected = 0.25 * 30 + 100 * np.abs(gain) * np.sin(2 * np.pi * 125 * time + 0.7 + np.angle(gain))
    assert np.max(np.abs(found - expected)) < 1e-12 * 100


def test_a_response_that_fails_at_zero_is_not_asked_there():
    def capacitor(frequency):
        assert np.all(frequency > 0)
        return 1 / (2j * np.pi * frequency)

    assert np.all(
        np.isfinite(periodic(capacitor, TONES["carrier at the modulation"], np.zeros(1), static=0.0))
    )


@pytest.mark.parametrize(
    ("one", "count"),
    [
        (SINE, 1),
        (TONES["offset"], 2),
        (TONES["modulated"], 3),
        (drive("Offset", level=0, drive=SINE.to_dict()), 1),
        (drive("AmplitudeModulation", amplitude=80, carrier=2000, modulation=125, depth=0), 1),
        (TONES["full root"], 2),
        (TONES["sum"], 2),
        (drive("Sum", drives=[SINE.to_dict(), {"model": "Step", "level": 5}]), 2),
        (EDGES["square"], None),
        (drive("Step", level=10), None),
        (drive("Burst", amplitude=1, frequency=10, cycles=3), None),
    ],
)
def test_number_of_harmonics(one, count):
    assert count_harmonics(one) == count


@pytest.mark.parametrize(
    "one",
    [
        drive("Burst", amplitude=1, frequency=10, cycles=3),
        drive("Trapezium", high=1, rise=1, hold=1, fall=1),
        drive("Chirp", amplitude=1, first=1, last=2, length=1),
        drive("Sampled", time_samples=[0, 1], voltage_samples=[0, 1]),
    ],
)
def test_what_does_not_repeat_is_refused(one):
    with pytest.raises(InputError, match="no period"):
        periodic(np.ones_like, one, np.zeros(1), static=1.0)


def test_a_part_that_does_not_repeat_is_refused():
    with pytest.raises(InputError, match="does not repeat"):
        spectrum(drive("Chirp", amplitude=1, first=1, last=2, length=1), harmonics=3)
