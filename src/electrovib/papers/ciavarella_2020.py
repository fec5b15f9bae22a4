"""M. Ciavarella, A. Papangelo, "A simplified theory of electroadhesion for rough interfaces", 2020.

Frontiers in Mechanical Engineering 6, 27.

Claims: rough conductors and insulators under a voltage by a bearing-area model; pull-off depends mostly on
voltage, rms height and the longest wavelength of the roughness, real contact and friction also on the rms
slope, hence on where the spectrum is truncated; two criteria of stickiness; the coefficient of friction decays with
the normal pressure and tends to a plateau.
Does not claim: numbers of a finger (none was read). Only the abstract was read: the form of the surface is cited
from memory, unverified, without its numerical factor.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from electrovib.core.constants import eps0
from electrovib.core.quantity import Number, Quantity
from electrovib.papers import published
from electrovib.physics.contact.surface import (
    HEIGHT,
    MODULUS,
    SLOPE,
    RoughSurface,
    exponential_gap,
    exponential_pressure,
)
from electrovib.physics.roughness import contact_fraction, local_pull

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared


class BearingArea(RoughSurface):
    """A rough elastic skin by its bearing area: repulsion decreases e^2-fold over an rms height.

    Notes
    -----
    p = c q0 h_rms E* exp(-2 gap/h_rms), q0 = 2 pi over the longest wavelength of the roughness. The form is
    cited from memory, unverified, so the factor c has to be given. A_real/A0 = erf(sqrt(2) p/(E* h')) is that of
    Persson's theory, also cited from memory, unverified.
    """

    reference: ClassVar[str] = "doi:10.3389/fmech.2020.00027"
    status: ClassVar[str] = "unverified"
    equation: ClassVar[Mapping[str, str]] = {
        "pressure": "2*pi*prefactor/longest_wavelength*rms_height*modulus*exp(-2*gap/rms_height)",
        "slope": "-4*pi*prefactor*modulus/longest_wavelength*exp(-2*gap/rms_height)",
        "real_share": "erf(sqrt(2)*pressure/(modulus*rms_slope))",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "prefactor": 1.0,
        "modulus": 2e7,
        "rms_height": 2e-5,
        "rms_slope": 1.0,
        "longest_wavelength": 4e-4,
    }

    prefactor: Annotated[Number, Quantity("1", 1e-3, 1e3, "factor c of the repulsion")]
    modulus: Annotated[Number, MODULUS]
    rms_height: Annotated[Number, HEIGHT]
    rms_slope: Annotated[Number, SLOPE]
    longest_wavelength: Annotated[Number, Quantity("m", 1e-8, 1, "longest wavelength of the roughness")]

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the repulsion per area [Pa]."""
        return exponential_pressure(gap, flat=self._flat, decay=self.rms_height / 2)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative of the repulsion by the gap [Pa/m]."""
        return -self.pressure(gap) / (self.rms_height / 2)

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean gap under a pressure [m]."""
        return exponential_gap(pressure, flat=self._flat, decay=self.rms_height / 2)

    @property
    def _flat(self) -> float:
        return self.prefactor * 2 * math.pi / self.longest_wavelength * self.rms_height * self.modulus


def friction_coefficient(
    pressure: NDArray[np.float64], *, pull: float, modulus: float, slope: float
) -> NDArray[np.float64]:
    """Compute the coefficient of friction relative to that without voltage under a small load.

    It is the real contact under load and attraction over that of the load alone, extrapolated linearly from
    small loads. `pressure` of the load and `pull` [Pa], effective `modulus` [Pa], root-mean-square `slope`
    [1].
    """
    small = 1e-9 * modulus * slope
    alone = contact_fraction(small, modulus=modulus, slope=slope) / small
    area = contact_fraction(pressure + pull, modulus=modulus, slope=slope)
    relative: NDArray[np.float64] = area / (pressure * alone)
    return relative


def decays_to_a_plateau() -> float:
    """Return 1 if friction over load decreases ever more slowly for loads of 0.1 to 100 times the pull, otherwise 0."""
    pull, modulus, slope = 1e3, 1e7, 1.0
    load = pull * np.geomspace(0.1, 100.0, 13)
    steps = -np.diff(friction_coefficient(load, pull=pull, modulus=modulus, slope=slope))
    falls = bool(np.all(steps > 0)) and all(later < earlier for earlier, later in pairwise(steps))
    return float(falls and steps[-1] < 1e-2 * steps[0])


def conductors_over_plates() -> float:
    """Return the pull without any layer over that of two plates in air."""
    gap, voltage = 2e-6, 50.0
    return float(local_pull(voltage, electrical_thickness=0.0, gap=gap) / (eps0 * voltage**2 / (2 * gap**2)))


CHECKS = PAPER.checks(decays_to_a_plateau, conductors_over_plates)
