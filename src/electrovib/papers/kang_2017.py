"""J. Kang, H. Kim, S. Choi, K.-D. Kim, J. Ryu, "Investigation on low voltage operation of electrovibration display".

IEEE Transactions on Haptics 10(3), 371-381, 2017.

Claims: a modulated carrier, a DC offset, and both together each give an equally strong sensation with less
peak-to-peak voltage; only the offset raises the mean friction, in step with the rms voltage; all three raise the
vibrating part, which the perceived intensity follows. Does not claim: voltages, a carrier frequency, a
circuit (none was read). What follows from squaring is computed here, on a stack that does not conduct. The part at
the drive's own frequency, twice offset times amplitude, lasts only as long as the offset reaches the gap: it is
gone where the skin's plane is taken as the force, or where the gap leaks.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from electrovib.core.checks import Check
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import Scenario
from electrovib.solve.simulate import simulate

CITATION = (
    "J. Kang, H. Kim, S. Choi, K.-D. Kim, J. Ryu, Investigation on low voltage operation of electrovibration display,"
    " IEEE Trans. Haptics 10(3), 371 (2017), doi:10.1109/TOH.2016.2635145 (abstract)"
)
STATUS = "abstract"
NOT_READ = "The voltages, the carrier frequency, the measured friction and any equation were not read."

MODULATION, CARRIER = 100.0, 3000.0
"""Frequencies of the ready-made drives, a choice [Hz]."""
CHOICE = "not printed in the abstract; a choice"
FREQUENCY = "not printed in the abstract; a choice, tens of modulations to a carrier"
FILM = "not printed in the abstract; the film of vezzoli_2014, on which no skin filters"
SKIN = "not printed in the abstract; the skin of vezzoli_2014, section 3.1, without conduction"

_SAMPLES = 4096
"""Over one period of the modulation: beyond twice the carrier and its sidebands."""


def sine(*, amplitude: float) -> dict[str, Any]:
    """Plain drive of the conventional method: a cosine of this peak [V]."""
    return {"model": "Sine", "amplitude": amplitude, "frequency": MODULATION, "phase": math.pi / 2}


def modulated(*, amplitude: float, depth: float) -> dict[str, Any]:
    """First method: a carrier under 1 + m cos.

    Parameters
    ----------
    amplitude, depth : float
        Carrier's peak without modulation [V], m.

    Returns
    -------
    dict
        Table of a drive.
    """
    return {
        "model": "AmplitudeModulation",
        "amplitude": amplitude,
        "carrier": CARRIER,
        "modulation": MODULATION,
        "depth": depth,
    }


def offset(drive: dict[str, Any], *, level: float) -> dict[str, Any]:
    """Put a drive on a DC offset: the second method of a sine, the third of a modulated carrier.

    Parameters
    ----------
    drive : dict
        Table of a drive.
    level : float
        V.

    Returns
    -------
    dict
        Table of a drive.
    """
    return {"model": "Offset", "drive": drive, "level": level}


def _film(title: str, drive: dict[str, Any], sources: dict[str, str]) -> Scenario:
    film = {"model": "Constant", "permittivity": values.FILM_PERMITTIVITY}
    skin = {"model": "Constant", "permittivity": values.SKIN_PERMITTIVITY}
    return Scenario.model_validate(
        {
            "title": f"Kang 2017: {title}",
            "drive": drive,
            "force": {"model": "GapPlane"},
            "friction": {"model": "Coulomb", "coefficient": 0.5},
            "contact": {"model": "FixedArea", "area": 1e-4},
            "load": {"normal_force": 0.5},
            "circuit": {"return_path": {"model": "Grounded", "resistance": 1000.0}},
            "time": {"initial_state": {"model": "PeriodicState"}},
            "stack": {
                "insulator": {"thickness": values.FILM_THICKNESS, "material": film},
                "gap": {"thickness": 3e-6},
                "stratum_corneum": {"thickness": values.SKIN_THICKNESS, "material": skin},
            },
            "sources": {
                "friction.coefficient": CHOICE,
                "contact.area": CHOICE,
                "load.normal_force": CHOICE,
                "circuit.return_path.resistance": CHOICE,
                "stack.insulator.thickness": FILM,
                "stack.insulator.material.permittivity": FILM,
                "stack.gap.thickness": "not printed in the abstract; of the order of skin roughness",
                "stack.gap.material.permittivity": "air",
                "stack.stratum_corneum.thickness": SKIN,
                "stack.stratum_corneum.material.permittivity": SKIN,
            }
            | sources,
        }
    )


def _carrier_sources(prefix: str) -> dict[str, str]:
    return {
        f"{prefix}.amplitude": CHOICE,
        f"{prefix}.carrier": FREQUENCY,
        f"{prefix}.modulation": FREQUENCY,
        f"{prefix}.depth": CHOICE,
    }


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Give the conventional sine and the three methods, on one film."""
    plain = {"amplitude": CHOICE, "frequency": FREQUENCY, "phase": "a cosine, for the algebra of squares"}
    level = {"drive.level": CHOICE}
    on_sine = level | {f"drive.drive.{name}": text for name, text in plain.items()}
    carrier = modulated(amplitude=100.0, depth=0.8)
    return {
        "sine": _film("sine", sine(amplitude=100.0), {f"drive.{name}": text for name, text in plain.items()}),
        "modulated": _film("modulated carrier", carrier, _carrier_sources("drive")),
        "offset": _film("sine on a DC offset", offset(sine(amplitude=100.0), level=200.0), on_sine),
        "both": _film(
            "modulated carrier on a DC offset",
            offset(carrier, level=200.0),
            level | _carrier_sources("drive.drive"),
        ),
    }


def harmonics(signal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Peak amplitudes at multiples of the modulation, the mean first.

    Parameters
    ----------
    signal : ndarray
        One period of the modulation, evenly sampled.

    Returns
    -------
    ndarray
        In the unit of the signal.
    """
    spectrum = np.abs(np.fft.rfft(signal)) / len(signal)
    spectrum[1:] *= 2
    return np.asarray(spectrum)


def force_harmonics(scenario: Scenario) -> NDArray[np.float64]:
    """Mean and harmonics of the attraction in the periodic state, per pull of one held volt [V2]."""
    time = np.arange(_SAMPLES) / _SAMPLES / MODULATION
    force = simulate(scenario, time=time).electrostatic_force.values
    held = scenario.replace(
        {"drive": {"model": "Constant", "level": 1.0}, "time.initial_state.model": "AtRest"}
    )
    return harmonics(force / float(simulate(held, time=np.array([0.0, 1e-3])).electrostatic_force[-1]))


def square_harmonics(drive: dict[str, Any]) -> NDArray[np.float64]:
    """Mean and harmonics of the square of a drive, given as a table [V2]."""
    time = np.arange(_SAMPLES) / _SAMPLES / MODULATION
    return harmonics(scenarios()["sine"].replace({"drive": drive}).drive.voltage(time) ** 2)


def _algebra(name: str, drive: dict[str, Any], order: int, expect: float) -> Check:
    return Check(
        name,
        expect=expect,
        rtol=1e-9,
        source="algebra of the square, exact; rounding of a discrete Fourier transform",
        compute=lambda: float(square_harmonics(drive)[order]),
        status="derived",
    )


_OFFSET, _MODULATED = offset(sine(amplitude=1.0), level=2.0), modulated(amplitude=1.0, depth=0.8)

CHECKS = (
    _algebra("mean of (2 + cos)^2", _OFFSET, 0, 4.5),
    _algebra("(2 + cos)^2 at the frequency of the drive", _OFFSET, 1, 4.0),
    _algebra("(2 + cos)^2 at twice the frequency", _OFFSET, 2, 0.5),
    _algebra("mean of a carrier under 1 + 0.8 cos", _MODULATED, 0, 0.66),
    _algebra("carrier under 1 + 0.8 cos, at the modulation", _MODULATED, 1, 0.8),
    _algebra("carrier under 1 + 0.8 cos, at twice the modulation", _MODULATED, 2, 0.16),
    Check(
        "vibrating force with an offset of twice the amplitude over that without, one peak-to-peak voltage",
        expect=8.0,
        rtol=1e-9,
        source="abstract: less peak-to-peak voltage for an equal percept; 2 V0 V1 against V1^2/2",
        compute=lambda: float(square_harmonics(_OFFSET)[1] / square_harmonics(sine(amplitude=1.0))[2]),
        status="derived",
    ),
)
