"""N. K. Veijgen, M. A. Masen, E. van der Heide: friction of skin at four body sites, Tribology Letters 49, 251, 2013.

doi:10.1007/s11249-012-0062-1. Coefficients that other laboratories measured on skin without electrovibration are declared here
too, each with its own group.

Claims: median coefficients of 0.52 at rest and 0.36 in motion over 450 tests on steel, aluminium, polyethylene and PTFE;
hydration explains most of the spread. Does not claim: one coefficient for a material, or for a fingertip: fingertips are at 0.43
on polyamide and at 2.79 on rosin-coated glass (Smith and Scott), above what the tables of body sites give.
"""

from __future__ import annotations

from electrovib.papers import published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared


def motion_over_rest() -> float:
    """Return the median coefficient in motion over that at rest."""
    from electrovib.studies.evidence.files import of_publication

    found = of_publication("veijgen_2013")
    return found["in_motion"].values[0] / found["at_rest"].values[0]


CHECKS = PAPER.checks(motion_over_rest)
