"""Y. Vardar, B. Guclu, C. Basdogan, "Effect of waveform on tactile perception by electrovibration", 2016 and 2017.

EuroHaptics 2016, doi:10.1007/978-3-319-42321-0_18, and IEEE Transactions on Haptics 10(4), 2017.

Claims: detection thresholds are lower for square than for sine voltages below 60 Hz and similar above, because
the skin turns a slow square into short bursts of force, which the Pacinian channel detects. Does not claim:
the curves of the skin, thresholds in volts (neither was read). The circuit, a coating in series with a leaky stratum
corneum whose own voltage pulls, is recalled. Here: that circuit, a square law, and a weight of +-12 dB/octave
about 250 Hz on the harmonics of the force, added as powers. It gives the direction for every skin that conducts;
the frequency of equal thresholds follows the skin's time constant (60 Hz is not forced), and above it the model
overshoots, because an ideal square voltage has a constant square. The size belongs to the plane: cut in a gap that
does not leak, the ready-made screen gives 8 dB instead of 29 at 15 Hz. A detection threshold is one of displacement,
so the weight should act after the mechanics of the finger, which are not in it.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from electrovib.core.checks import Check
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import plutchik_1963
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Constant, Material
from electrovib.solve.scenario import Scenario
from electrovib.solve.simulate import simulate

CITATION = (
    "Y. Vardar, B. Guclu, C. Basdogan, Effect of waveform on tactile perception by electrovibration displayed on"
    " touch screens, IEEE Trans. Haptics 10(4), 488 (2017), doi:10.1109/TOH.2017.2704603 (abstract); the same,"
    " EuroHaptics 2016, doi:10.1007/978-3-319-42321-0_18 (abstract)"
)
STATUS = "abstract"
NOT_READ = (
    "The circuit and the law of the force are recalled; the polynomials of the skin's permittivity and resistivity"
    " and the thresholds in volts were not read."
)

FREQUENCIES = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0, 1920.0)
"""Fundamental frequencies of the 2016 experiment, abstract [Hz]."""
BEST = 250.0
"""Where the Pacinian channel is most sensitive, an assumption of this comparison [Hz]."""
VOLTAGE = 100.0
"""Peak of the ready-made drives, a choice [V]."""

CHOICE = "not printed in the abstract; a choice"
COAT = "not printed in the abstract; recalled of 3M-type screens, and the coat of vezzoli_2014"
SKIN = "plutchik_1963: solved from its abstract with 1 cm2 and 200 um assumed; the paper's own curves were not read"

_SAMPLES = 1 << 13
"""Over one period: 250 Hz is harmonic 17 of 15 Hz, so what folds back is 1e-3 of it or less."""


def _screen(title: str, drive: dict[str, Any], sources: dict[str, str]) -> Scenario:
    coat = {"model": "Constant", "permittivity": values.COAT_PERMITTIVITY}
    skin = "stack.stratum_corneum.material"
    return Scenario.model_validate(
        {
            "title": title,
            "drive": drive,
            "force": {"model": "StratumCorneumPlane"},
            "friction": {"model": "Coulomb", "coefficient": 0.5},
            "contact": {"model": "FixedArea", "area": 1e-4},
            "load": {"normal_force": 0.5},
            "circuit": {"return_path": {"model": "Grounded", "resistance": 1000.0}},
            "time": {"initial_state": {"model": "PeriodicState"}},
            "stack": {
                "insulator": {"thickness": values.COAT_THICKNESS, "material": coat},
                "stratum_corneum": {
                    "thickness": plutchik_1963.THICKNESS,
                    "material": plutchik_1963.material(),
                },
            },
            "sources": {
                "drive.frequency": "abstract: one of seven",
                "friction.coefficient": CHOICE,
                "contact.area": CHOICE,
                "load.normal_force": CHOICE,
                "circuit.return_path.resistance": CHOICE,
                "stack.insulator.thickness": COAT,
                "stack.insulator.material.permittivity": COAT,
                "stack.stratum_corneum.thickness": "recalled of this line of papers, printed in vezzoli_2014",
                f"{skin}.permittivity": SKIN,
                f"{skin}.reference_frequency": SKIN,
                f"{skin}.exponent": SKIN,
                f"{skin}.conductivity": SKIN,
            }
            | sources,
        }
    )


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Give a sine and a square voltage of one peak and one frequency on one screen."""
    sine = {"model": "Sine", "amplitude": VOLTAGE, "frequency": 30.0}
    square = {"model": "Square", "high": VOLTAGE, "low": -VOLTAGE, "frequency": 30.0}
    return {
        "sine": _screen("Vardar 2017: sine, 30 Hz", sine, {"drive.amplitude": CHOICE}),
        "square": _screen("Vardar 2017: square, 30 Hz", square, {"drive.high": CHOICE, "drive.low": CHOICE}),
    }


def first_order_skin(time_constant: float) -> Constant:
    """Skin without dispersion whose circuit with the coat has this time constant (C_i + C_s) R_s [s]."""
    coat = values.COAT_PERMITTIVITY / values.COAT_THICKNESS
    skin = values.SKIN_PERMITTIVITY / values.SKIN_THICKNESS
    conductivity = eps0 * (coat + skin) * values.SKIN_THICKNESS / time_constant
    return Constant(permittivity=values.SKIN_PERMITTIVITY, conductivity=conductivity)


def weight(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sensitivity to a force.

    Parameters
    ----------
    frequency : ndarray
        Hz, >= 0.

    Returns
    -------
    ndarray
        2 x^2/(1 + x^4), x = f/250 Hz: 1 at 250 Hz, +-12 dB/octave far from it.
    """
    ratio = frequency / BEST
    result: NDArray[np.float64] = 2 * ratio**2 / (1 + ratio**4)
    return result


def felt_level(scenario: Scenario) -> float:
    """Root of the sum of the squares of the weighted harmonics of the attraction, in the periodic state [N]."""
    period = scenario.drive.period
    assert period is not None
    force = simulate(scenario, time=np.arange(_SAMPLES) * period / _SAMPLES).electrostatic_force.values
    amplitudes = 2 * np.abs(np.fft.rfft(force))[1:] / _SAMPLES
    orders = np.arange(1, len(amplitudes) + 1)
    return float(np.sqrt(np.sum((amplitudes * weight(orders / period)) ** 2)))


def sine_over_square(
    skin: Material, frequency: float, *, edge: float = 0.0, resistance: float = 0.0
) -> float:
    """Threshold voltage of a sine over that of a square, both given as peaks.

    Parameters
    ----------
    skin : Material
        Stratum corneum.
    frequency : float
        Fundamental [Hz].
    edge : float
        Time an edge of the square takes [s].
    resistance : float
        Body [ohm].

    Returns
    -------
    float
        dB; above 0 the square is felt at a lower voltage. The level grows as the square of the voltage.
    """
    common = {
        "drive.frequency": frequency,
        "stack.stratum_corneum.material": skin,
        "circuit.return_path.resistance": resistance,
    }
    sine = scenarios()["sine"].replace(common)
    square = scenarios()["square"].replace({**common, "drive.edge": edge})
    return float(10 * np.log10(felt_level(square) / felt_level(sine)))


def crossover(skin: Material) -> float:
    """Frequency of equal thresholds.

    Parameters
    ----------
    skin : Material
        Stratum corneum.

    Returns
    -------
    float
        Hz; infinite if the square is felt at a lower voltage up to 1920 Hz, 0 if nowhere above 15 Hz.
    """
    from scipy.optimize import brentq

    low, high = FREQUENCIES[0], FREQUENCIES[-1]
    if sine_over_square(skin, low) <= 0:
        return 0.0
    if sine_over_square(skin, high) > 0:
        return float("inf")
    return float(
        np.exp(
            brentq(lambda x: sine_over_square(skin, float(np.exp(x))), np.log(low), np.log(high), xtol=1e-3)
        )
    )


def _ratio(name: str, time_constant: float, frequency: float, expect: float, rtol: float) -> Check:
    return Check(
        f"sine over square threshold, {name}, {frequency:g} Hz, in dB",
        expect=expect,
        rtol=rtol,
        source="first-order high-pass, square law, weight about 250 Hz, computed apart from this code; one decimal",
        compute=lambda: sine_over_square(first_order_skin(time_constant), frequency),
        status="derived",
    )


CHECKS = (
    _ratio("7.7 ms", 7.7e-3, 15.0, 19.5, 5e-3),
    _ratio("7.7 ms", 7.7e-3, 60.0, 3.6, 2e-2),
    _ratio("7.7 ms", 7.7e-3, 240.0, -4.6, 2e-2),
    _ratio("3 ms", 3e-3, 30.0, 16.1, 5e-3),
    _ratio("1 ms", 1e-3, 15.0, 33.1, 5e-3),
    _ratio("1 ms", 1e-3, 120.0, 6.4, 1e-2),
)
