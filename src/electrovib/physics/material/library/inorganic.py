"""Oxides and glasses of the library."""

from __future__ import annotations

from typing import Final

from electrovib.physics.material.library.polymers import (
    MEGAVOLT_PER_METRE,
    OHM_CENTIMETRE,
    from_resistivity,
    permittivity,
    strength,
)
from electrovib.physics.material.library.record import Substance

_DEAL = "Brigham Young University cleanroom, constants of thermal oxide after B. E. Deal, cleanroom.byu.edu/OxideTimeCalc"
_MCPHERSON = "J. W. McPherson, World J. Condens. Matter Phys. 2016, no. 2, 152"
_EMESH = "I. Emesh et al., J. Electrochem. Soc. 136, 3404 (1989)"
_HENEIN = "Henein, Topolancik and Siebein, MRS Adv. 3, no. 4 (2018), nist.gov"
_VALLEY = "Valley Design, soda-lime float glass, valleydesign.com/soda-lime-glass"
_MAKE_SODA = "makeitfrom.com, Soda-Lime (Float) Glass"
_CORNING = "Corning code 0080, from memory: log10 of the resistivity in ohm cm 12.4"
_SMITH = "N. J. Smith et al., Mater. Lett. 63, 1245 (2009)"
_MURATA = "T. Murata et al., J. Am. Ceram. Soc. 95, 1915 (2012)"
_MAKE_ALUMINA = "makeitfrom.com, 97-99% Purity Alumina (IEC 60672 Type C-795)"
_RIT = "RIT Annual Microelectronic Engineering Conference 24, paper 28, scholarworks.rit.edu/ritamec/vol24/iss1/28"
_ALD_STRENGTH = (
    "Influence of growth temperature on dielectric strength of Al2O3, Sci. Rep. 12 (2022), s41598-022-09054-7"
)
_WANG = "Y. Wang et al., Adv. Mater. Phys. Chem. 11, 7 (2021), doi:10.4236/ampc.2021.111002"

SUBSTANCES: Final = (
    Substance(
        name="silica",
        aliases=("SiO2", "silicon dioxide", "silicon oxide", "thermal oxide", "PECVD oxide"),
        meaning="silicon dioxide as a film: thermal, plasma-deposited (PECVD) or sputtered",
        kind="oxide",
        permittivity=(permittivity(3.9, "thermal oxide", _DEAL, "full text"),),
        conductivity=from_resistivity(1e16 * OHM_CENTIMETRE, "thermal oxide, 25 C", _DEAL, "full text"),
        strengths=(
            strength(2500 * MEGAVOLT_PER_METRE, 2e-9, "about", _MCPHERSON, "abstract"),
            strength(1000 * MEGAVOLT_PER_METRE, 50e-9, "about", _MCPHERSON, "abstract"),
            strength(660 * MEGAVOLT_PER_METRE, None, "at least; PECVD from TEOS", _EMESH, "abstract"),
            strength(700 * MEGAVOLT_PER_METRE, 100e-9, "at least; ion-beam sputtered", _HENEIN, "abstract"),
        ),
    ),
    Substance(
        name="soda_lime_glass",
        aliases=("soda-lime glass", "float glass", "window glass"),
        meaning="soda-lime float glass",
        kind="glass",
        permittivity=(
            permittivity(7.75, "20 C, frequency not stated", _VALLEY, "full text"),
            permittivity(7.35, "1 MHz; middle of 7.3 to 7.4", _MAKE_SODA, "derived"),
        ),
        conductivity=from_resistivity(10**12.4 * OHM_CENTIMETRE, "25 C", _CORNING, "unverified"),
        strengths=(strength(13 * MEGAVOLT_PER_METRE, None, "", _MAKE_SODA, "full text"),),
    ),
    Substance(
        name="aluminosilicate_glass",
        aliases=("aluminosilicate glass", "alkali-free glass", "cover glass", "display glass"),
        meaning="alkali-free barium boroaluminosilicate glass of displays; alkali cover glass conducts more and is not covered",
        kind="glass",
        permittivity=(permittivity(6.0, "about; frequency not stated", _SMITH, "abstract"),),
        strengths=(
            strength(1100 * MEGAVOLT_PER_METRE, 5e-6, "characteristic value", _MURATA, "abstract"),
            strength(400 * MEGAVOLT_PER_METRE, 58e-6, "characteristic value", _MURATA, "abstract"),
        ),
    ),
    Substance(
        name="alumina",
        aliases=("Al2O3 ceramic", "alumina ceramic", "aluminium oxide", "aluminum oxide"),
        meaning="sintered aluminium oxide, purity 97 to 99 %",
        kind="oxide",
        permittivity=(
            permittivity(9.0, "1 Hz", _MAKE_ALUMINA, "full text"),
            permittivity(8.8, "1 MHz", _MAKE_ALUMINA, "full text"),
        ),
        conductivity=from_resistivity(1e14, "order of magnitude", _MAKE_ALUMINA, "full text"),
        strengths=(strength(12 * MEGAVOLT_PER_METRE, None, "", _MAKE_ALUMINA, "full text"),),
    ),
    Substance(
        name="alumina_ald",
        aliases=("Al2O3", "ALD alumina", "ALD Al2O3"),
        meaning="amorphous aluminium oxide film from atomic layer deposition",
        kind="oxide",
        permittivity=(permittivity(8.36, "31.8 nm, deposited at 200 C", _RIT, "abstract"),),
        conductivity=from_resistivity(
            1e8 / 1.79e-4,
            "1.79e-8 A/cm2 at 1 MV/cm, 50 nm on ITO; such leakage is not ohmic",
            _WANG,
            "derived",
        ),
        strengths=(
            strength(830 * MEGAVOLT_PER_METRE, None, "about; grown at 150 C", _ALD_STRENGTH, "abstract"),
        ),
    ),
    Substance(
        name="hafnia",
        aliases=("HfO2", "hafnium dioxide", "hafnium oxide", "ALD hafnia"),
        meaning="hafnium dioxide film from atomic layer deposition",
        kind="oxide",
        permittivity=(permittivity(24.8, "34.7 nm, deposited at 200 C", _RIT, "abstract"),),
        strengths=(
            strength(
                500 * MEGAVOLT_PER_METRE,
                None,
                "order of magnitude",
                "strength of ALD films, from memory",
                "unverified",
            ),
        ),
    ),
)
