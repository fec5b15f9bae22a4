"""S. Gabriel, R. W. Lau, C. Gabriel, "The dielectric properties of biological tissues: III", 1996.

Physics in Medicine and Biology 41, 2271, doi:10.1088/0031-9155/41/11/003.

Claims: whole skin, dry and wet, as four Cole-Cole terms from 10 Hz to 100 GHz. Does not claim: stratum corneum
alone; agreement with its own measurements to better than 12 % below 1 kHz, and to better than 40 % in conductivity
between 10 and 100 kHz. Its resistivity is about 110 times below that which the 7.7 ms of Vezzoli et al. 2014 require as
the time constant of the voltage, and twice as far below if they are the decay of the force.
"""

from __future__ import annotations

from electrovib.core.citation import Citation, cited, derived
from electrovib.physics.material import ColeCole
from electrovib.physics.skin import Skin, time_constant

CITATIONS = (
    Citation(
        kind="article",
        authors=("S. Gabriel", "R. W. Lau", "C. Gabriel"),
        title="The dielectric properties of biological tissues: III. Parametric models",
        journal="Phys. Med. Biol.",
        year=1996,
        volume="41",
        pages="2271",
        doi="10.1088/0031-9155/41/11/003",
    ),
)
CITATION = cited(CITATIONS)
STATUS = "abstract"


def _terms(*rows: tuple[float, float, float]) -> list[dict[str, float]]:
    return [{"strength": s, "relaxation_time": t, "broadening": b} for s, t, b in rows]


DRY = ColeCole.model_validate(
    {
        "permittivity_high": 4.0,
        "terms": _terms((32, 7.234e-12, 0.0), (1100, 32.481e-9, 0.2)),
        "conductivity": 2.0e-4,
    }
)
WET = ColeCole.model_validate(
    {
        "permittivity_high": 4.0,
        "terms": _terms(
            (39, 7.958e-12, 0.1), (280, 79.577e-9, 0.0), (3.0e4, 1.592e-6, 0.16), (3.0e4, 1.592e-3, 0.2)
        ),
        "conductivity": 4.0e-4,
    }
)


def skins() -> dict[str, Skin]:
    """Return dry and wet whole skin."""
    note = "whole skin, not stratum corneum; values read in public code that quotes the paper's table"
    return {
        "dry": Skin(
            name="Gabriel dry",
            material=DRY,
            status="derived",
            source=CITATION,
            note=f"{note}: four files agree",
        ),
        "wet": Skin(
            name="Gabriel wet", material=WET, status="derived", source=CITATION, note=f"{note}: one file only"
        ),
    }


CHECKS = (
    derived(
        "tau of dry skin at 100 Hz",
        expect=50.3e-6,
        rtol=2e-3,
        source="evaluated independently of this code, table of skin values",
        compute=lambda: float(time_constant(DRY, 100.0)),
    ),
    derived(
        "tau of wet skin at 1 kHz",
        expect=0.433e-3,
        rtol=2e-3,
        source="evaluated independently of this code, table of skin values",
        compute=lambda: float(time_constant(WET, 1e3)),
    ),
)
