"""R. V. Grigorii, J. E. Colgate: friction per current of electroadhesion, and a bare finger, 2020 and 2021.

IEEE Transactions on Haptics, doi:10.1109/TOH.2020.2972350 and doi:10.1109/TOH.2021.3130091. The lateral forces of two
vibrating displays of the same laboratory (Mullenbach 2016, Xu 2019) are declared here too.

Claims: friction per drive current is 0.041 W^-0.63 N/mA with the load W from 0.15 to 1.25 N, R2 0.62; a bare finger without
a drive has a coefficient of 0.34 to 0.45 at 0.53 N. Does not claim: coating, area, carrier frequency, current and the number of
people (the articles were not read, only the authors' public code and one file of data).
"""

from __future__ import annotations

import math

import numpy as np

from electrovib.papers import mean_attraction, published
from electrovib.scenario import Scenario
from electrovib.studies.evidence.quantities import steady

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared

LAW, EXPONENT = 41.0, -0.63
"""Friction per current at 1 N [N/A], and its power of the load [1]."""


def per_current(load: float) -> float:
    """Return the friction per current [N/A] at a load [N], the authors' fit."""
    return LAW * math.pow(load, EXPONENT)


def friction_per_current(scenario: Scenario) -> float:
    """Compute the friction that the attraction adds over the amplitude of a sine of current [N/A].

    The area is that under the load; at a given current a larger area lowers the attraction, which then adds little to it.
    """
    area = scenario.contact.gross_area(scenario.load.normal_force)
    held = scenario.replace({"contact": {"model": "FixedArea", "area": area}})
    current: float = scenario.drive.amplitude  # type: ignore[attr-defined]
    frequency: float = scenario.drive.frequency  # type: ignore[attr-defined]
    pull = mean_attraction(held, frequency, amplitude=current)[0]
    load, real = np.asarray(scenario.load.normal_force), np.asarray(0.0)
    law = steady(scenario)
    added = law.lateral_force(load, pull, real) - law.lateral_force(load, np.asarray(0.0), real)
    return float(added) / current


quantities = PAPER.quantities(friction_per_current)
CHECKS = PAPER.checks(per_current)
