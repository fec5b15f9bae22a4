"""J. Kang, H. Kim, S. Choi, K.-D. Kim, J. Ryu, "Investigation on low voltage operation of electrovibration display".

IEEE Transactions on Haptics 10(3), 371-381, 2017.

Claims: a modulated carrier, a DC offset, and both together each give an equally strong sensation with less
peak-to-peak voltage; only the offset raises the mean friction, in step with the rms voltage; all three raise the
vibrating part, which the perceived intensity follows. Does not claim: voltages, a carrier frequency, a
circuit (none was read). The consequences of a quadratic force law are computed here, on a stack that does not conduct.
The part at the drive's own frequency, twice offset times amplitude, persists only while the offset reaches the gap: it
vanishes where the stress is evaluated in a skin that conducts, or where the gap leaks.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from electrovib.papers import published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

MODULATION, CARRIER = 100.0, 3000.0
"""Frequencies of the drives of the presets, a choice [Hz]."""

_SAMPLES = 4096
"""Samples of one period of the modulation, enough for twice the carrier and its sidebands."""


def sine(*, amplitude: float) -> dict[str, Any]:
    """Return the drive of the conventional method: a cosine of this peak [V]."""
    return {"model": "Sine", "amplitude": amplitude, "frequency": MODULATION, "phase": math.pi / 2}


def modulated(*, amplitude: float, depth: float) -> dict[str, Any]:
    """Return the drive of the first method: a carrier of a peak [V] with the envelope 1 + m cos, depth m."""
    return {
        "model": "AmplitudeModulation",
        "amplitude": amplitude,
        "carrier": CARRIER,
        "modulation": MODULATION,
        "depth": depth,
    }


def offset(drive: dict[str, Any], *, level: float) -> dict[str, Any]:
    """Return a drive on a DC offset [V]: the second method with a sine, the third with a modulated carrier."""
    return {"model": "Offset", "drive": drive, "level": level}


def harmonics(signal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean, and the peak amplitudes of all harmonics, of one period of modulation that is evenly sampled."""
    spectrum = np.abs(np.fft.rfft(signal)) / len(signal)
    spectrum[1:] *= 2
    return np.asarray(spectrum)


def square_harmonics(drive: dict[str, Any]) -> NDArray[np.float64]:
    """Return mean and harmonics of the square of a drive, given as a table [V2]."""
    time = np.arange(_SAMPLES) / _SAMPLES / MODULATION
    return harmonics(scenarios()["sine"].replace({"drive": drive}).drive.voltage(time) ** 2)


def with_offset(*, order: int) -> float:
    """Return one harmonic of the square of a sine of 1 V on an offset of 2 V, or for 0 its mean [V2]."""
    return float(square_harmonics(offset(sine(amplitude=1.0), level=2.0))[order])


def with_carrier(*, order: int) -> float:
    """Return the same of a carrier of 1 V, modulated by 0.8 [V2]."""
    return float(square_harmonics(modulated(amplitude=1.0, depth=0.8))[order])


def gain_of_an_offset() -> float:
    """Return the vibrating part with that offset over the one without it, of one peak-to-peak voltage."""
    return with_offset(order=1) / float(square_harmonics(sine(amplitude=1.0))[2])


CHECKS = PAPER.checks(with_offset, with_carrier, gain_of_an_offset)
