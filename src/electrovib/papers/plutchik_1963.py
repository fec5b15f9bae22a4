"""Skin impedance and phase angle over frequency and current, Science 141, 927 (1963).

R. Plutchik, H. R. Hirsch, doi:10.1126/science.141.3584.927 (abstract; the authors as Tregear, Nature 205, 600 cites them).

Claims: |Z| from 130 kohm at 1 Hz to 30 kohm at 1 kHz, phase from -2 to -58 degrees, the phase the same from 14 to 62 uA.
Does not claim: site, electrode area, thickness. Here three of its numbers are solved for a Cole admittance
G0 (1 + (j w tc)^alpha), with 1 cm2 and 200 um assumed; its phase at 1 Hz then comes out as -0.94 degrees, not -2.
"""

from __future__ import annotations

import numpy as np

from electrovib.core.citation import Check
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import cited_as
from electrovib.physics.material import ConstantPhase
from electrovib.physics.skin import Skin
from electrovib.physics.stack import Layer

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"

RESISTANCE, RELAXATION, EXPONENT = 130.8e3, 0.911e-3, 0.783
"""Solved from |Z| at 1 Hz and 1 kHz and the phase at 1 kHz [ohm, s, 1]."""
AREA, THICKNESS = 1e-4, 200e-6
"""Assumed area and thickness [m2, m]."""


def material() -> ConstantPhase:
    """Return the Cole admittance as a material."""
    anchor = 100.0
    angle = (EXPONENT - 1) * np.pi / 2
    magnitude = (2 * np.pi * anchor * RELAXATION) ** EXPONENT / RESISTANCE  # |Y - G0|
    capacitance = magnitude * np.cos(angle) / (2 * np.pi * anchor)
    return ConstantPhase(
        permittivity=capacitance * THICKNESS / (VACUUM_PERMITTIVITY * AREA),
        reference_frequency=anchor,
        exponent=EXPONENT,
        conductivity=THICKNESS / (AREA * RESISTANCE),
    )


def layer() -> Layer:
    """Return the stratum corneum of the assumed thickness."""
    return Layer(thickness=THICKNESS, material=material())


def impedance(frequency: float) -> complex:
    """Return the impedance of 1 cm2 [ohm] at a frequency [Hz]."""
    permittivity = material().complex_permittivity(frequency)
    return complex(THICKNESS / (2j * np.pi * frequency * VACUUM_PERMITTIVITY * permittivity * AREA))


def skins() -> dict[str, Skin]:
    """Return the one set of skin values."""
    note = "solved from three numbers of the abstract; 1 cm2 and 200 um assumed; site not known"
    return {
        "skin": Skin(name="1963 impedance", material=material(), status="derived", source=CITATION, note=note)
    }


CHECKS = (
    Check(
        "|Z| at 1 Hz",
        expect=130e3,
        rtol=1e-2,
        source="abstract, two digits",
        compute=lambda: abs(impedance(1.0)),
        status="abstract",
    ),
    Check(
        "|Z| at 1 kHz",
        expect=30e3,
        rtol=2e-2,
        source="abstract, one digit",
        compute=lambda: abs(impedance(1e3)),
        status="abstract",
    ),
    Check(
        "phase at 1 kHz",
        expect=-58.0,
        rtol=1e-2,
        source="abstract, two digits",
        compute=lambda: float(np.degrees(np.angle(impedance(1e3)))),
        status="abstract",
    ),
)
