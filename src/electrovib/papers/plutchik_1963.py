"""Skin impedance and phase angle over frequency and current, Science 141, 927 (1963).

R. Plutchik, H. R. Hirsch, doi:10.1126/science.141.3584.927 (abstract; the authors as Tregear, Nature 205, 600 cites them).

Claims: |Z| from 130 kohm at 1 Hz to 30 kohm at 1 kHz, phase from -2 to -58 degrees, the phase the same from 14 to 62 uA.
Does not claim: site, electrode area, thickness. Here three of its numbers are solved for a Cole admittance
G0 (1 + (j w tc)^alpha), with 1 cm2 and 200 um assumed; its phase at 1 Hz then comes out as -0.94 degrees, not -2.
"""

from __future__ import annotations

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
skins = PAPER.skins

AREA, THICKNESS = 1e-4, 200e-6
"""Assumed area and thickness [m2, m]."""


def impedance(frequency: float) -> complex:
    """Return the impedance of 1 cm2 [ohm] at a frequency [Hz]."""
    permittivity = skins()["skin"].material.complex_permittivity(frequency)
    return complex(THICKNESS / (2j * np.pi * frequency * VACUUM_PERMITTIVITY * permittivity * AREA))


def magnitude(frequency: float) -> float:
    """Return its magnitude [ohm]."""
    return abs(impedance(frequency))


def phase(frequency: float) -> float:
    """Return its phase angle in degrees."""
    return float(np.degrees(np.angle(impedance(frequency))))


CHECKS = PAPER.checks(magnitude, phase)
