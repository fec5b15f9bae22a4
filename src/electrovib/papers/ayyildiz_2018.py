"""M. Ayyildiz et al., "Contact mechanics between the human finger and a touchscreen under electroadhesion", 2018.

M. Ayyildiz, M. Scaraggi, O. Sirin, C. Basdogan, B. N. J. Persson, PNAS 115, 12668.

Claims: a mean-field theory of multiscale contact, validated against full-scale numerical contact mechanics and
against friction measured on fingers, in which electroadhesion raises the real contact area at the microscopic
level and with it friction; attraction and real contact depend strongly on the roughness of the skin and on the
coating, and an effectively thinner coating has a large effect.
Does not claim: a table of forces (none was read). Only the abstract and the statement of significance were read.
"""

from __future__ import annotations

import numpy as np

from electrovib.papers import published
from electrovib.physics.roughness import GaussianGaps, PullingSpots, contact_fraction, mean_pull

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared

ROUGHNESSES = (1e-6, 5e-6, 22e-6)
"""Root-mean-square gaps over which trends are evaluated [m]."""


def _pull(rms: float, in_rms: float, *, coating: float, voltage: float = 100.0) -> float:
    """Return the averaged pull [Pa] on a coating of this electrical thickness [m]."""
    gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
    return float(mean_pull(voltage, electrical_thickness=coating, gaps=gaps, spots=PullingSpots()).total)


def thinner_coatings_pull_more() -> float:
    """Return the share of rough contacts in which halving the coating raises the averaged pull."""
    cases = [
        (rms, mean, coating) for rms in ROUGHNESSES for mean in (1, 2, 3) for coating in (1e-7, 3e-7, 1e-6)
    ]
    more = [
        _pull(rms, mean, coating=coating / 2) > _pull(rms, mean, coating=coating)
        for rms, mean, coating in cases
    ]
    return float(np.mean(more))


def real_contact_grows() -> float:
    """Return the share of rough contacts in which every increase of the voltage raises the real contact area."""
    grows = []
    for rms in ROUGHNESSES:
        pulls = [_pull(rms, 2, coating=3e-7, voltage=voltage) for voltage in (0.0, 50.0, 100.0, 150.0, 200.0)]
        areas = contact_fraction(1e3 + np.array(pulls), modulus=1e7, slope=1.0)
        grows.append(np.all(np.diff(areas) > 0))
    return float(np.mean(grows))


CHECKS = PAPER.checks(thinner_coatings_pull_more, real_contact_grows)
