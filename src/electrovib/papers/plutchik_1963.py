"""Skin impedance and phase angle over frequency and current, Science 141, 927 (1963).

R. Plutchik, H. R. Hirsch, doi:10.1126/science.141.3584.927 (abstract; the authors as Tregear, Nature 205, 600 cites them).

Claims: |Z| from 130 kohm at 1 Hz to 30 kohm at 1 kHz, phase from -2 to -58 degrees, the phase the same from 14 to 62 uA.
Does not claim: site, electrode area, thickness. Here three of its numbers are solved for a Cole admittance
G0 (1 + (j w tc)^alpha), with 1 cm2 and 200 um assumed; its phase at 1 Hz then comes out as -0.94 degrees, not -2.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from electrovib.core.citation import Check
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import cited_as
from electrovib.papers.rosell_1988 import BODY
from electrovib.physics.material import ConstantPhase
from electrovib.physics.skin import Skin
from electrovib.physics.stack import Layer
from electrovib.studies.evidence import Measurement, between
from electrovib.studies.evidence.quantities import lag, of_skin

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"

RESISTANCE, RELAXATION, EXPONENT = 130.8e3, 0.911e-3, 0.783
"""Solved from |Z| at 1 Hz and 1 kHz and the phase at 1 kHz [ohm, s, 1]."""
PHASE = {1.0: math.radians(2), 1e3: math.radians(58)}
"""Angle by which the voltage lags behind the current [rad], over frequency [Hz]."""
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


def measurements() -> dict[str, Measurement]:
    """Return magnitude and phase at 1 Hz and 1 kHz."""
    read: dict[str, Any] = {
        "source": "Science 141, 927 (1963), abstract", "group": "Plutchik and Hirsch", "spread_of": "digits",
        "unknown": BODY | {
            "contact.area": between(1e-5, 1e-3, "not printed"),
            "stack.stratum_corneum.thickness": between(1e-5, 4e-4, "the site is not printed; from trunk to finger"),
        },
        "made": ("plutchik_1963/skin",),
        "note": "Site and area are not printed. The skin of this paper was solved from three of these four numbers.",
    }  # fmt: skip
    return {
        "magnitude": of_skin(
            "magnitude of the impedance of skin", {1.0: 130e3, 1e3: 30e3}, spread=(0.04, 0.17), **read
        ),
        "phase": of_skin(
            "phase angle of the impedance of skin", PHASE, spread=(0.25, 0.01), unit="rad",
            quantity=lag, **read,
        ),
    }  # fmt: skip


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
