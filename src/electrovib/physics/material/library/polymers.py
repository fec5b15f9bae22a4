"""Polymers of the library."""

from __future__ import annotations

import math
from typing import Final

from electrovib.core.units import format_quantity
from electrovib.physics.material.library.record import BreakdownStrength, Dispersion, SourcedValue, Substance

MICROMETRE: Final = 1e-6
MEGAVOLT_PER_METRE: Final = 1e6
VOLT_PER_MIL: Final = 1 / 25.4e-6
"""V/m."""
OHM_CENTIMETRE: Final = 1e-2
"""Ohm m."""


def permittivity(value: float, conditions: str, source: str, status: str) -> SourcedValue:
    """Declare a relative permittivity."""
    return SourcedValue(value=value, unit="1", conditions=conditions, source=source, status=status)


def from_resistivity(resistivity: float, conditions: str, source: str, status: str) -> SourcedValue:
    """Declare a conductivity [S/m] by the resistivity [ohm m] that a source prints."""
    return SourcedValue(
        value=1 / resistivity, unit="S/m", conditions=conditions, source=source, status=status
    )


def strength(
    value: float, thickness: float | tuple[float, float] | None, conditions: str, source: str, status: str
) -> BreakdownStrength:
    """Declare a breakdown strength [V/m] with the thickness at which it was measured [m].

    `thickness` is one, or the thinnest and the thickest; None if the source does not state it.
    """
    edges = (thickness, thickness) if isinstance(thickness, float) else thickness
    return BreakdownStrength(
        value=value, unit="V/m", thickness=edges, conditions=conditions, source=source, status=status
    )


_BOPET = "data sheet of 6020 universal PET film, bopet-film-china.com"
_KMAC = "data sheet of Kapton HN, k-mac-plastics.net/data/technical/kapton-hn.htm"
_KAPTON = "DuPont data sheet of Kapton HN, from memory; the specification that was read allows at most 3.9"
_KAPTON_RESISTIVITY = "DuPont data sheet of Kapton HN, from memory: 1.5e17 ohm cm"
_DIAMOND = (
    "Diamond MT, comparison of parylene C, N and F, blog.paryleneconformalcoating.com (its data from MatWeb)"
)
_SCS = "data sheets of parylene C, from memory: 5600 V/mil"
_HINDUSTAN = "Hindustan Nylons, Electrical Properties of Unfilled PTFE, hindustan-nylons.com"
_ASTM = "ASTM D3369-96, table 1, PTFE cast film, standards.iteh.ai"
_CHEMOURS = "Chemours, Teflon FEP film, properties bulletin K-26941"
_ORING = "comparison table of fluoropolymers, o-ring.tw/en/product_02_6_13"
_SERTEL = "N. Ghalichechian, K. Sertel, Permittivity and loss characterization of SU-8 films (2014)"
_MELAI = "J. Melai et al., J. Micromech. Microeng. 19, 065012 (2009)"
_PIEZO = "user manual of the SparkFun piezo vibration sensor, table 1, piezo film"
_RAUF = "A. M. Rauf, S. Follmer, Extreme Mech. Lett. 79, 102382 (2025), the authors' public code"
_SPRINGER = "Mater. Res. Soc. Symp. Proc. 889, W07-02, doi:10.1557/PROC-0889-W07-02"
_TSDC = "dielectric relaxation and thermally stimulated currents of P(VDF-TrFE-CFE), globalauthorid.com"

_PET_MINIMA = {75: 115, 100: 100, 125: 90, 150: 85, 175: 80, 188: 76, 200: 70, 250: 65, 300: 60, 350: 55}
"""Thickness [um] to the lowest strength that the data sheet guarantees [MV/m]."""
_KAPTON_MINIMA = {7.6: 118, 12.7: 118, 25.4: 236, 50.8: 197, 76.2: 177, 127: 118}
"""Thickness [um] to the lowest strength that the data sheet guarantees [MV/m]."""
_PTFE_MINIMA = {25: 4200, 51: 4000, 76: 3400, 102: 3000}
"""Thickness [um] to the lowest strength that the standard requires [V/mil]."""
_PARYLENE_POINTS = {1e3: 3.10, 60.0: 3.15, 1e6: 2.95}
"""Frequency [Hz] to relative permittivity."""
_PARYLENE_EXPONENT: Final = 1 + math.log(_PARYLENE_POINTS[1e6] / _PARYLENE_POINTS[60.0]) / math.log(1e6 / 60)
"""Of the power law from 60 Hz to 1 MHz; its loss tangent of 0.011 is below the 0.013 to 0.020 of the table."""
_PVDF_LOSS: Final = 0.02
"""Loss tangent at 1 kHz."""

SUBSTANCES: Final = (
    Substance(
        name="pet",
        aliases=("polyethylene terephthalate", "polyester", "Mylar", "Hostaphan", "Melinex"),
        meaning="biaxially oriented polyethylene terephthalate film",
        kind="polymer film",
        permittivity=(permittivity(3.15, "50 Hz; middle of 2.9 to 3.4", _BOPET, "derived"),),
        conductivity_bound=from_resistivity(1e14, "", _BOPET, "full text"),
        strengths=tuple(
            strength(
                value * MEGAVOLT_PER_METRE,
                um * MICROMETRE,
                "minimum of the data sheet, GB/T 1408.1",
                _BOPET,
                "full text",
            )
            for um, value in _PET_MINIMA.items()
        ),
    ),
    Substance(
        name="polyimide",
        aliases=("Kapton", "Kapton HN", "PI"),
        meaning="polyimide film of the type Kapton HN",
        kind="polymer film",
        permittivity=(permittivity(3.4, "1 kHz, 25 um, 23 C", _KAPTON, "unverified"),),
        conductivity=from_resistivity(
            1.5e17 * OHM_CENTIMETRE, "23 C, 25 um", _KAPTON_RESISTIVITY, "unverified"
        ),
        strengths=tuple(
            strength(
                value * MEGAVOLT_PER_METRE,
                um * MICROMETRE,
                "minimum of the data sheet, 60 Hz",
                _KMAC,
                "full text",
            )
            for um, value in _KAPTON_MINIMA.items()
        ),
    ),
    Substance(
        name="parylene_c",
        aliases=("parylene", "parylene C", "PPX-C", "poly(chloro-p-xylylene)"),
        meaning="poly(chloro-p-xylylene) deposited from the vapour",
        kind="coating",
        permittivity=tuple(
            permittivity(value, format_quantity(frequency, "Hz"), _DIAMOND, "full text")
            for frequency, value in _PARYLENE_POINTS.items()
        ),
        dispersion=Dispersion(
            model="ConstantPhase",
            parameters={
                "permittivity": _PARYLENE_POINTS[1e3],
                "reference_frequency": 1e3,
                "exponent": _PARYLENE_EXPONENT,
            },
            source=f"power law through the permittivities at 60 Hz, 1 kHz and 1 MHz of {_DIAMOND}",
            status="derived",
        ),
        conductivity=from_resistivity(8.8e16 * OHM_CENTIMETRE, "", _DIAMOND, "full text"),
        strengths=(strength(5600 * VOLT_PER_MIL, 25.4e-6, "", _SCS, "unverified"),),
    ),
    Substance(
        name="ptfe",
        aliases=("polytetrafluoroethylene", "Teflon", "Teflon PTFE"),
        meaning="polytetrafluoroethylene, cast film",
        kind="polymer film",
        permittivity=(
            permittivity(2.05, "relative density 2.174, no dispersion found", _HINDUSTAN, "full text"),
        ),
        conductivity_bound=from_resistivity(1e18 * OHM_CENTIMETRE, "", _ORING, "full text"),
        strengths=tuple(
            strength(value * VOLT_PER_MIL, um * MICROMETRE, "minimum of the standard", _ASTM, "full text")
            for um, value in _PTFE_MINIMA.items()
        ),
    ),
    Substance(
        name="fep",
        aliases=("fluorinated ethylene propylene", "Teflon FEP"),
        meaning="fluorinated ethylene propylene film",
        kind="polymer film",
        permittivity=(permittivity(2.1, "1 kHz", _ORING, "full text"),),
        conductivity_bound=from_resistivity(1e18 * OHM_CENTIMETRE, "", _ORING, "full text"),
        strengths=(
            strength(260 * MEGAVOLT_PER_METRE, 25e-6, "lower bound of the bulletin", _CHEMOURS, "full text"),
        ),
    ),
    Substance(
        name="su8",
        aliases=("SU-8", "SU-8 photoresist", "epoxy photoresist"),
        meaning="cross-linked SU-8 epoxy photoresist",
        kind="coating",
        permittivity=(
            permittivity(3.24, "1 GHz, 430 um; a value at low frequency was not read", _SERTEL, "abstract"),
        ),
        strengths=(
            strength(440 * MEGAVOLT_PER_METRE, None, "layers of several thicknesses", _MELAI, "abstract"),
        ),
    ),
    Substance(
        name="pvdf",
        aliases=("polyvinylidene fluoride", "piezo film", "Kynar"),
        meaning="polyvinylidene fluoride, stretched and poled film",
        kind="ferroelectric polymer",
        permittivity=(permittivity(12.5, "1 kHz; middle of 12 to 13", _PIEZO, "derived"),),
        conductivity_bound=from_resistivity(1e13, "", _PIEZO, "full text"),
        dispersion=Dispersion(
            model="ConstantPhase",
            parameters={
                "permittivity": 12.5,
                "reference_frequency": 1e3,
                "exponent": 1 - 2 / math.pi * math.atan(_PVDF_LOSS),
            },
            source=f"loss tangent of {_PVDF_LOSS:g} at 1 kHz, {_PIEZO}; away from 1 kHz an extrapolation",
            status="derived",
        ),
        strengths=(strength(80 * MEGAVOLT_PER_METRE, (9e-6, 110e-6), "DC, 25 C", _PIEZO, "full text"),),
    ),
    Substance(
        name="p_vdf_trfe_cfe",
        aliases=("P(VDF-TrFE-CFE)", "PVDF-TrFE-CFE", "terpolymer", "relaxor terpolymer"),
        meaning="relaxor terpolymer of vinylidene fluoride, trifluoroethylene and chlorofluoroethylene",
        kind="ferroelectric polymer",
        permittivity=(permittivity(55.0, "low field, 25 C; middle of 50 to 60", _SPRINGER, "derived"),),
        dispersion=Dispersion(
            model="ColeCole",
            parameters={
                "permittivity_high": 4.0,
                "terms": [{"strength": 54.2 - 4.0, "relaxation_time": 2.82e-6, "broadening": 1 - 0.562}],
            },
            source=f"fit of {_RAUF}, in which the film conducts nothing",
            status="abstract",
        ),
        strengths=(
            strength(
                190 * MEGAVOLT_PER_METRE,
                None,
                "a field at which its polarisation was measured",
                _TSDC,
                "abstract",
            ),
        ),
    ),
)
