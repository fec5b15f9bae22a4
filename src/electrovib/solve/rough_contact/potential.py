"""Attraction as a local potential of the gap."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.physics.roughness import local_pull


class Local(NamedTuple):
    """Energy per area [J/m2], its derivative over the gap, which is the attraction [Pa], and the derivative of that [Pa/m]."""

    energy: Real
    stress: Real
    slope: Real


Attraction = Callable[[Real], Local]
"""Of a gap [m], 0 or more."""


@dataclass(frozen=True, kw_only=True)
class MaxwellStress:
    """Plates in series at each place: layers with a sum of T/eps [m] above 0, a gap, and a voltage [V] held across both.

    Valid where the gap varies over lengths that are long compared with gap and layers.
    """

    voltage: float
    electrical_thickness: float

    def __post_init__(self) -> None:
        """Refuse what makes the attraction infinite."""
        if not 0 < self.electrical_thickness < np.inf:
            raise InputError(
                f"electrical_thickness = {self.electrical_thickness}: the sum of thickness over permittivity of the layers is"
                " finite and above 0, for instance 1e-6 m"
            )
        if not np.isfinite(self.voltage):
            raise InputError(f"voltage = {self.voltage}: a voltage is finite, for instance 100 V")

    def __call__(self, gap: Real) -> Local:
        """Return the energy -eps0 V^2/2/(g + h0), voltage held, and its derivatives."""
        reach = gap + self.electrical_thickness
        stress = local_pull(self.voltage, electrical_thickness=self.electrical_thickness, gap=gap)
        return Local(-stress * reach, stress, -2 * stress / reach)
