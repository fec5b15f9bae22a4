"""Palmar skin admittance of 48 healthy persons, Med. Biol. Eng. Comput. 1995, doi:10.1007/bf02510531.

PMID 7666695 (authors not read), with Qiao, Morkrid, Vollestad 1994, doi:10.1007/BF02518913.

Claims: below 354 Hz the admittance of palmar skin is G0 + Q (j w)^alpha, alpha 0.8025 in women and 0.7545 in
men; sweating raises G0 and hardly changes alpha. Does not claim: a thickness, a permittivity, anything above
1 kHz. Here Q is set so that the capacitance at 100 Hz is the 6.9 nF per cm2 of Vezzoli et al. 2014, and G0 is a
skin conductance level of 2 to 20 uS, assumed for 1 cm2.
"""

from __future__ import annotations

import math

from electrovib.core.citation import derived
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import cited_as
from electrovib.physics.material import ConstantPhase
from electrovib.physics.skin import Skin, time_constant
from electrovib.scenario import Scenario
from electrovib.studies.evidence.quantities import ComputedQuantity

CITATIONS, CITATION = cited_as(__name__)
STATUS = "abstract"

WOMEN, MEN = 0.8025, 0.7545
"""Exponent alpha of the admittance."""
THICKNESS = 200e-6
"""Assumed thickness, to convert an admittance per area into a permittivity [m]."""
AREA = 1e-4
"""Assumed electrode area of the conductance levels [m2]."""
ANCHOR = 6.9e-9
"""Capacitance at 100 Hz, from Vezzoli et al. 2014 [F]."""


def palmar(*, exponent: float, conductance: float) -> ConstantPhase:
    """Return the material of palmar skin with an exponent of the admittance and a sweat conductance of 1 cm2 [S]."""
    return ConstantPhase(
        permittivity=ANCHOR * THICKNESS / (VACUUM_PERMITTIVITY * AREA),
        reference_frequency=100.0,
        exponent=exponent,
        conductivity=conductance * THICKNESS / AREA,
    )


def skins() -> dict[str, Skin]:
    """Return palmar skin from dry (2 uS) to moist (20 uS)."""
    found = {}
    for who, exponent in (("men", MEN), ("women", WOMEN)):
        for word, conductance in (("dry", 2e-6), ("medium", 10e-6), ("moist", 20e-6)):
            name = f"palmar {who} {conductance * 1e6:.0f} uS"
            note = "alpha from the abstract; 6.9 nF at 100 Hz, 1 cm2 and 200 um assumed; G0 from skin conductance levels"
            material = palmar(exponent=exponent, conductance=conductance)
            found[f"{word}_{who}"] = Skin(
                name=name, material=material, status="derived", source=CITATION, note=note
            )
    return found


def admittance_exponent(scenario: Scenario) -> float:
    """Compute alpha of the admittance G0 + Q (j w)^alpha of the skin, from how its permittivity falls with frequency."""
    frequency, step = scenario.drive.frequency, 1.05  # type: ignore[attr-defined]
    material = scenario.stack.layers["stratum_corneum"].material
    ends = [float(material.complex_permittivity(each).real) for each in (frequency / step, frequency * step)]
    return 1 + math.log(ends[1] / ends[0]) / (2 * math.log(step))


def quantities() -> dict[str, ComputedQuantity]:
    """Return the exponent of the admittance, which tells skins with dispersion from those without."""
    return {
        "admittance_exponent": ComputedQuantity(
            title="exponent of the admittance of skin", unit="1", compute=admittance_exponent
        )
    }


CHECKS = (
    derived(
        "tau of palmar skin, alpha 0.7545, 2 uS, at 100 Hz",
        expect=1.84e-3,
        rtol=3e-3,
        source="evaluated independently of this code, table of skin values",
        compute=lambda: float(time_constant(palmar(exponent=MEN, conductance=2e-6), 100.0)),
    ),
    derived(
        "tau of palmar skin, alpha 0.8025, 20 uS, at 10 kHz",
        expect=0.0366e-3,
        rtol=5e-3,
        source="evaluated independently of this code, table of skin values",
        compute=lambda: float(time_constant(palmar(exponent=WOMEN, conductance=20e-6), 1e4)),
    ),
)
