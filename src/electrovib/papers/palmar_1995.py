"""Palmar skin admittance of 48 healthy persons, Med. Biol. Eng. Comput. 1995, doi:10.1007/bf02510531.

PMID 7666695 (authors not read), with Qiao, Morkrid, Vollestad 1994, doi:10.1007/BF02518913.

Claims: below 354 Hz the admittance of palmar skin is G0 + Q (j w)^alpha, alpha 0.8025 in women and 0.7545 in
men; sweating raises G0 and hardly changes alpha. Does not claim: a thickness, a permittivity, anything above
1 kHz. Here Q is set so that the capacitance at 100 Hz is the 6.9 nF per cm2 of Vezzoli et al. 2014, and G0 is a
skin conductance level of 2 to 20 uS, assumed for 1 cm2.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import published
from electrovib.physics.skin import time_constant

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
skins = PAPER.skins


def admittance_exponent(scenario: Scenario) -> float:
    """Compute alpha of the admittance G0 + Q (j w)^alpha of the skin, from how its permittivity falls with frequency."""
    frequency, step = scenario.drive.frequency, 1.05  # type: ignore[attr-defined]
    material = scenario.stack.layers["stratum_corneum"].material
    ends = [float(material.complex_permittivity(each).real) for each in (frequency / step, frequency * step)]
    return 1 + math.log(ends[1] / ends[0]) / (2 * math.log(step))


quantities = PAPER.quantities(admittance_exponent)


def capacitance() -> float:
    """Return the capacitance of the skin of men at 100 Hz [F], for 1 cm2 and the assumed thickness of 200 um."""
    return (
        VACUUM_PERMITTIVITY
        * float(skins()["dry_men"].material.complex_permittivity(100.0).real)
        * 1e-4
        / 200e-6
    )


def tau(*, skin: str, frequency: float) -> float:
    """Return the time constant of a skin [s] at a frequency [Hz]."""
    return float(time_constant(skins()[skin].material, frequency))


CHECKS = PAPER.checks(capacitance, tau)
