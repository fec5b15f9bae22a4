"""The force is a square: harmonics of v^2 and of the force as the algebra of each drive says."""

from __future__ import annotations

import numpy as np
import pytest
from scenario_parts import debye, layer, model, sine, step, trapezium

from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.solve.simulate import simulate

PRECISION = 1e-12  # of the mean; FFT of 4096 samples of products of sines

MODULATED = {"amplitude": 1, "carrier": 3000, "modulation": 100, "depth": 0.8}
# drive, and amplitude of v^2 at multiples of its slowest frequency; of a modulation (1 + m cos)^2/2 below the carrier's double
CASES = {
    "constant and sine": (model("Offset", level=2, drive=sine(1, 100, phase=np.pi / 2)), (4.5, 4.0, 0.5)),
    "amplitude modulation": (model("AmplitudeModulation", **MODULATED), (0.66, 0.8, 0.16)),
    "square root": (model("SquareRootModulation", **MODULATED), (0.5, 0.4, 0.0)),
    "full square root": (model("SquareRootModulation", **MODULATED | {"depth": 1}), (0.5, 0.5, 0.0)),
    "no modulation": (model("AmplitudeModulation", **MODULATED | {"depth": 0}), (0.5, 0.0, 0.0)),
}
SAMPLES = 4096  # over the period of the modulation: beyond the double of the carrier and all its sidebands


def harmonics(values):
    """Amplitudes of cosines and sines at multiples of the slowest frequency, the mean first."""
    spectrum = np.fft.rfft(values) / len(values)
    amplitudes = 2 * np.abs(spectrum)
    amplitudes[0] = spectrum[0].real
    return amplitudes


def times():
    return np.arange(SAMPLES) / SAMPLES / 100


@pytest.mark.parametrize("law", ["MaxwellStressInGap", "EffectiveMedium", "MaxwellStressInInsulator"])
@pytest.mark.parametrize(("drive", "expected"), CASES.values(), ids=CASES)
def test_force_of_a_stack_that_does_not_conduct(finger, drive, expected, law):
    layers = {"insulator": finger.film(), "stratum_corneum": finger.skin()}
    one = simulate(finger.build(drive=step(1), stack=layers, force=law))
    per_square = one["electrostatic_force"].values[-1]
    trace = simulate(finger.build(drive=drive, stack=layers, force=law, settled=True), time=times())
    found = harmonics(trace["electrostatic_force"].values / per_square)
    assert np.max(np.abs(found[:3] - expected)) < PRECISION
    # below the double of the carrier less its sidebands there is nothing else, to the cut series of the root
    assert np.max(found[3:20]) < PRECISION


LAWS = ["MaxwellStressInGap", "EffectiveMedium", "MaxwellStressInStratumCorneum", "Vezzoli2014Causal"]


@pytest.mark.parametrize("law", LAWS)
def test_twice_the_voltage_four_times_the_force(finger, law, conducting_paper_skin):
    layers = {"insulator": finger.film(), "stratum_corneum": layer(200e-6, conducting_paper_skin)}
    force, twice, turned = (
        simulate(
            finger.build(drive=trapezium(high, 1e-3, 5e-3, 1e-3), stack=layers, force=law, resistance=1e3)
        )
        for high in (100, 200, -100)
    )
    force = force["electrostatic_force"].values
    assert np.max(np.abs(twice["electrostatic_force"].values - 4 * force)) < PRECISION * np.max(force)
    assert np.array_equal(turned["electrostatic_force"].values, force)  # blind to polarity


def test_root_stays_a_pure_tone_only_without_a_skin_that_filters(finger):
    """After a conducting, dispersive skin the tone of the root has harmonics: up to 3 % at 1 kHz on 3 kHz."""
    skin = layer(200e-6, debye(60, 4e3, 2e-4, 1e-5))
    layers = {"insulator": finger.film(1e-6, 3.9), "stratum_corneum": skin}
    drive = model("SquareRootModulation", **MODULATED | {"modulation": 1000})
    trace = simulate(finger.build(drive=drive, stack=layers, settled=True), time=times() / 10)
    found = harmonics(trace["electrostatic_force"].values)
    assert 1e-6 < np.max(found[2:4]) / found[1] < 0.1


def test_carrier_whose_sideband_turns_the_voltage_doubles_the_frequency(finger):
    """cos(pi f t) times a carrier: its square varies with f, twice the frequency of the envelope."""
    sidebands = [sine(0.5, frequency, phase=np.pi / 2) for frequency in (2950, 3050)]
    time = np.arange(SAMPLES) / SAMPLES / 50  # the envelope has 50 Hz
    found = harmonics(read_model(Drive, model("Sum", drives=sidebands)).voltage(time) ** 2)
    assert np.max(np.abs(found[:3] - [0.25, 0.0, 0.25])) < PRECISION
