"""S. Gabriel, R. W. Lau, C. Gabriel, "The dielectric properties of biological tissues: III", 1996.

Physics in Medicine and Biology 41, 2271, doi:10.1088/0031-9155/41/11/003.

Claims: whole skin, dry and wet, as four Cole-Cole terms from 10 Hz to 100 GHz. Does not claim: stratum corneum
alone; agreement with its own measurements to better than 12 % below 1 kHz, and to better than 40 % in conductivity
between 10 and 100 kHz. Here its parameters are those that public code quotes, and `PRINTED` is what another publication
tables for dry and wet skin. Its resistivity is about 110 times below that which the 7.7 ms of Vezzoli et al. 2014 require as
the time constant of the voltage, and twice as far below if they are the decay of the force.
"""

from __future__ import annotations

import functools
import math
from decimal import Decimal
from typing import Final

from electrovib.core.citation import SECOND_HAND, Check, derived
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.papers import published
from electrovib.physics.skin import time_constant

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
skins = PAPER.skins


TABLED: Final = (10e3, 100e3, 200e3, 400e3, 1e6)
"""Frequencies of the table that is compared [Hz]."""
PRINTED: Final = {
    ("dry", "permittivity"): ("1133.6", "1119.2", "1104.8", "1076.3", "990.76"),
    ("dry", "conductivity"): ("0.00020", "0.00045", "0.00105", "0.00305", "0.0132"),
    ("wet", "permittivity"): ("29010", "15357", "8849.2", "4514.6", "1832.8"),
    ("wet", "conductivity"): ("0.0029", "0.0658", "0.1135", "0.1635", "0.2214"),
}
"""Relative permittivity and conductivity [S/m] at these frequencies, with the digits of table 3."""
SLIPPED: Final = "0.1135"
"""The one number of the table which the parameters do not give."""


def computed(frequency: float, skin: str, quantity: str) -> float:
    """Compute the relative permittivity, or the conductivity [S/m], of dry or wet skin."""
    value = skins()[skin].material.complex_permittivity(frequency)
    if quantity == "permittivity":
        return float(value.real)
    return float(-value.imag * 2 * math.pi * frequency * VACUUM_PERMITTIVITY)


def _printed(frequency: float, skin: str, quantity: str, text: str) -> Check:
    number = Decimal(text)
    half = Decimal(5).scaleb(int(number.as_tuple().exponent) - 1)
    return Check(
        f"{quantity} of {skin} skin at {frequency / 1e3:g} kHz",
        expect=float(number),
        rtol=float(half / number),
        source="table 3 of doi:10.1186/s12938-018-0473-9, half a unit of its last digit",
        compute=functools.partial(computed, frequency, skin, quantity),
        status=SECOND_HAND,
    )


CHECKS = (
    derived(
        "tau of dry skin at 100 Hz",
        expect=50.3e-6,
        rtol=2e-3,
        source="evaluated independently of this code, table of skin values",
        compute=lambda: float(time_constant(skins()["dry"].material, 100.0)),
    ),
    derived(
        "tau of wet skin at 1 kHz",
        expect=0.433e-3,
        rtol=2e-3,
        source="evaluated independently of this code, table of skin values",
        compute=lambda: float(time_constant(skins()["wet"].material, 1e3)),
    ),
    *(
        _printed(frequency, *about, text)
        for about, texts in PRINTED.items()
        for frequency, text in zip(TABLED, texts, strict=True)
        if text != SLIPPED
    ),
)
