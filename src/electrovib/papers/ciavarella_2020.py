"""M. Ciavarella, A. Papangelo, "A simplified theory of electroadhesion for rough interfaces", 2020.

Frontiers in Mechanical Engineering 6, 27.

Claims: rough conductors and insulators under a voltage by a bearing-area model; pull-off depends mostly on
voltage, rms height and the longest wavelength of the roughness, real contact and friction also on the rms
slope, hence on where the spectrum is cut; two criteria of stickiness; the coefficient of friction decays with
the normal pressure and tends to a plateau.
Does not claim: numbers of a finger; values that could be read here. Only the abstract was read.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from electrovib.core.checks import Check
from electrovib.core.constants import eps0
from electrovib.physics.roughness import contact_fraction, local_pull

CITATION = (
    "M. Ciavarella, A. Papangelo, A simplified theory of electroadhesion for rough interfaces, Front. Mech. Eng. 6, 27"
    " (2020), doi:10.3389/fmech.2020.00027 (abstract), arXiv:1910.06756"
)
STATUS = "abstract"
NOT_READ = (
    "equation not read: repulsion against mean gap is recalled as c q0 h_rms E* exp(-2 u/h_rms) beside the averaged"
    " attraction, with a factor c near 1 that nobody here has seen; so there is no law of it to run"
)


def friction_coefficient(
    pressure: NDArray[np.float64], *, pull: float, modulus: float, slope: float
) -> NDArray[np.float64]:
    """Friction over load, over its value without voltage under a small load.

    Parameters
    ----------
    pressure : ndarray
        Nominal pressure of the load [Pa], above 0.
    pull : float
        Attraction per area [Pa].
    modulus : float
        Effective modulus [Pa].
    slope : float
        Root mean square slope.

    Returns
    -------
    ndarray
        1, same shape: real contact under load and attraction, over the load's own in proportion.
    """
    small = 1e-9 * modulus * slope
    alone = contact_fraction(small, modulus=modulus, slope=slope) / small
    area = contact_fraction(pressure + pull, modulus=modulus, slope=slope)
    relative: NDArray[np.float64] = area / (pressure * alone)
    return relative


def decays_to_a_plateau() -> float:
    """Tell for loads of 0.1 to 100 times the pull whether friction over load always falls, ever less: 1 if so."""
    pull, modulus, slope = 1e3, 1e7, 1.0
    load = pull * np.geomspace(0.1, 100.0, 13)
    steps = -np.diff(friction_coefficient(load, pull=pull, modulus=modulus, slope=slope))
    falls = bool(np.all(steps > 0)) and all(later < earlier for earlier, later in pairwise(steps))
    return float(falls and steps[-1] < 1e-2 * steps[0])


def conductors_over_plates() -> float:
    """Give the pull without any layer over that of two plates in air."""
    gap, voltage = 2e-6, 50.0
    return float(local_pull(voltage, electrical_thickness=0.0, gap=gap) / (eps0 * voltage**2 / (2 * gap**2)))


CHECKS = (
    Check(
        "coefficient of friction decays with the normal pressure and tends to a plateau (1: yes)",
        expect=1.0,
        rtol=1e-6,
        source="abstract; computed with a real contact that is proportional to a small load plus the pull",
        compute=decays_to_a_plateau,
        status="abstract",
    ),
    Check(
        "pull of conductors over that of two plates in air",
        expect=1.0,
        rtol=1e-12,
        source="identity: the case of conductors is that of no layer",
        compute=conductors_over_plates,
        status="derived",
    ),
)
