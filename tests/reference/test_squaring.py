"""The force is a square: harmonics of v^2 and of the force as the algebra of each drive says."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve.simulate import simulate

PRECISION = 1e-12  # of the mean; FFT of 4096 samples of products of sines

# drive, its slowest frequency, and amplitude of v^2 at multiples of it
OFFSET = {
    "model": "Offset",
    "level": 2,
    "drive": {"model": "Sine", "amplitude": 1, "frequency": 100, "phase": np.pi / 2},
}
MODULATED = {"amplitude": 1, "carrier": 3000, "modulation": 100, "depth": 0.8}
CASES = {
    "constant and sine": (OFFSET, {0: 4.5, 1: 4.0, 2: 0.5}),
    # below the carrier's double: (1 + m cos)^2/2
    "amplitude modulation": ({"model": "AmplitudeModulation"} | MODULATED, {0: 0.66, 1: 0.8, 2: 0.16}),
    "square root": ({"model": "SquareRootModulation"} | MODULATED, {0: 0.5, 1: 0.4, 2: 0.0}),
    "full square root": ({"model": "SquareRootModulation"} | MODULATED | {"depth": 1}, {0: 0.5, 1: 0.5, 2: 0.0}),
    "no modulation": ({"model": "AmplitudeModulation"} | MODULATED | {"depth": 0}, {0: 0.5, 1: 0.0, 2: 0.0}),
}  # fmt: skip
SAMPLES = 4096  # over the period of the modulation: beyond the double of the carrier and all its sidebands


def harmonics(values):
    """Amplitudes of cosines and sines at multiples of the slowest frequency, the mean first."""
    spectrum = np.fft.rfft(values) / len(values)
    amplitudes = 2 * np.abs(spectrum)
    amplitudes[0] = spectrum[0].real
    return amplitudes


def times():
    return np.arange(SAMPLES) / SAMPLES / 100


@pytest.mark.parametrize(("drive", "expected"), CASES.values(), ids=CASES)
def test_square_of_the_voltage(drive, expected):
    voltage = read_model(Drive, drive).voltage(times())
    found = harmonics(voltage**2)
    for order, amplitude in expected.items():
        assert abs(found[order] - amplitude) < PRECISION
    # below the double of the carrier less its sidebands there is nothing else, to the cut series of the root
    assert np.max(found[3:20]) < PRECISION


@pytest.mark.parametrize("law", ["MaxwellStressInGap", "EffectiveMedium", "MaxwellStressInInsulator"])
@pytest.mark.parametrize(("drive", "expected"), CASES.values(), ids=CASES)
def test_force_of_a_stack_that_does_not_conduct(finger, drive, expected, law):
    layers = {"insulator": finger.film(), "stratum_corneum": finger.skin()}
    one = simulate(finger.build(drive={"model": "Step", "level": 1}, stack=layers, force=law))
    per_square = one["electrostatic_force"].values[-1]
    trace = simulate(finger.build(drive=drive, stack=layers, force=law, settled=True), time=times())
    found = harmonics(trace["electrostatic_force"].values / per_square)
    for order, amplitude in expected.items():
        assert abs(found[order] - amplitude) < PRECISION
    assert np.max(found[3:20]) < PRECISION


@pytest.mark.parametrize(
    "law", ["MaxwellStressInGap", "EffectiveMedium", "MaxwellStressInStratumCorneum", "Vezzoli2014Causal"]
)
def test_twice_the_voltage_four_times_the_force(finger, law, conducting_paper_skin):
    layers = {
        "insulator": finger.film(),
        "stratum_corneum": {"thickness": 200e-6, "material": conducting_paper_skin},
    }
    drive = {"model": "Trapezium", "high": 100, "rise": 1e-3, "hold": 5e-3, "fall": 1e-3}
    once, twice, turned = (
        simulate(finger.build(drive=drive | {"high": high}, stack=layers, force=law, resistance=1000))
        for high in (100, 200, -100)
    )
    force = once["electrostatic_force"].values
    assert np.max(np.abs(twice["electrostatic_force"].values - 4 * force)) < PRECISION * np.max(force)
    assert np.array_equal(turned["electrostatic_force"].values, force)  # blind to polarity


def test_root_stays_a_pure_tone_only_without_a_skin_that_filters(finger):
    """After a conducting, dispersive skin the tone of the root has harmonics: up to 3 % at 1 kHz on 3 kHz."""
    material = {
        "model": "Debye",
        "permittivity_high": 60,
        "strength": 4e3,
        "relaxation_time": 2e-4,
        "conductivity": 1e-5,
    }
    layers = {
        "insulator": finger.film(1e-6, 3.9),
        "stratum_corneum": {"thickness": 200e-6, "material": material},
    }
    drive = {"model": "SquareRootModulation"} | MODULATED | {"modulation": 1000}
    trace = simulate(finger.build(drive=drive, stack=layers, settled=True), time=times() / 10)
    found = harmonics(trace["electrostatic_force"].values)
    assert 1e-6 < np.max(found[2:4]) / found[1] < 0.1


def test_carrier_whose_sideband_turns_the_voltage_doubles_the_frequency(finger):
    """cos(pi f t) times a carrier: its square varies with f, twice the frequency of the envelope."""
    drive = {
        "model": "Sum",
        "drives": [
            {"model": "Sine", "amplitude": 0.5, "frequency": 2950, "phase": np.pi / 2},
            {"model": "Sine", "amplitude": 0.5, "frequency": 3050, "phase": np.pi / 2},
        ],
    }
    time = np.arange(SAMPLES) / SAMPLES / 50  # the envelope has 50 Hz
    found = harmonics(read_model(Drive, drive).voltage(time) ** 2)
    assert found[0] == pytest.approx(0.25, abs=PRECISION)
    assert found[1] == pytest.approx(0, abs=PRECISION)
    assert found[2] == pytest.approx(0.25, abs=PRECISION)
