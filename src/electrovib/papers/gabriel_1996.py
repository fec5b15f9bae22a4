"""S. Gabriel, R. W. Lau, C. Gabriel, "The dielectric properties of biological tissues: III", 1996.

Physics in Medicine and Biology 41, 2271, doi:10.1088/0031-9155/41/11/003.

Claims: whole skin, dry and wet, as four Cole-Cole terms from 10 Hz to 100 GHz. Does not claim: stratum corneum
alone; agreement with its own measurements to better than 12 % below 1 kHz, and to better than 40 % in conductivity
between 10 and 100 kHz. Here its parameters are those that public code quotes, and its checks what another publication
tables for dry and wet skin. Its resistivity is about 110 times below that which the 7.7 ms of Vezzoli et al. 2014 require as
the time constant of the voltage, and twice as far below if they are the decay of the force.
"""

from __future__ import annotations

import math

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import published
from electrovib.physics.skin import time_constant

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
skins = PAPER.skins


def tau(*, skin: str, frequency: float) -> float:
    """Return the time constant of dry or wet skin [s] at a frequency [Hz]."""
    return float(time_constant(skins()[skin].material, frequency))


def computed(frequency: float, skin: str, quantity: str) -> float:
    """Compute the relative permittivity, or the conductivity [S/m], of dry or wet skin."""
    value = skins()[skin].material.complex_permittivity(frequency)
    if quantity == "permittivity":
        return float(value.real)
    return float(-value.imag * 2 * math.pi * frequency * VACUUM_PERMITTIVITY)


CHECKS = PAPER.checks(tau, computed)
