"""Conversion of added friction into the attraction that causes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.texture.base import RenderingPlate

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

_POINTS: Final = 16_385
"""Points of the table by which a law of friction that is not linear is inverted."""


class AttractionOfFriction:
    """Attraction that adds a given friction force to the plate's own.

    A law that is linear in the attraction is inverted exactly; any other by a table of 16 385 values, linear
    between them. A friction that does not increase with the attraction, or depends on the real contact area,
    is refused.
    """

    def __init__(self, scenario: Scenario, largest_force: float) -> None:
        law, load = scenario.friction.without_memory(), scenario.load.normal_force
        if law.needs_real_area:
            raise InputError(
                f"{type(law).__name__} depends on the real contact area under the attraction, and a texture needs friction as a"
                " function of the force; use friction.model = 'Coulomb' or 'PowerLaw'",
                path="friction",
            )
        self._slope: float | None = None
        nothing = np.full(_POINTS, np.nan)
        forces = np.linspace(0.0, largest_force, _POINTS)
        added = law.lateral_force(np.full(_POINTS, load), forces, nothing)
        added = added - added[0]
        if not np.all(np.diff(added) > 0):
            raise InputError(
                "does not increase with the attraction, so that no texture can be rendered", path="friction"
            )
        self._forces, self._added = forces, added
        if law.is_linear:
            self._slope = float(added[-1]) / largest_force
        self.plate = RenderingPlate(normal_force=load, largest_added_friction=float(added[-1]))

    def force(self, added: Real) -> Real:
        """Return the attraction of an added friction, out of range where no attraction of the hardware causes it."""
        if self._slope is not None:
            return np.asarray(added / self._slope)
        share = added / self._added[-1]
        inside = np.interp(added, self._added, self._forces)
        return np.where((share < 0) | (share > 1), share * self._forces[-1], inside)
