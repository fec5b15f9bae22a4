"""Friction without memory: of load and attraction, or of the area that touches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.friction.base import SteadyFriction

if TYPE_CHECKING:
    from collections.abc import Mapping


class Coulomb(SteadyFriction):
    """Friction in proportion to the whole normal force."""

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*(normal_force + electrostatic_force)"
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.5}

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction of the sliding finger")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Friction force [N]."""
        del real_contact_area
        return self.coefficient * (normal_force + electrostatic_force)


class PowerLaw(SteadyFriction):
    """A coefficient of friction that changes with the whole normal force by a power law.

    Notes
    -----
    mu = coefficient (W/at_force)^exponent, W load plus attraction. Skin has a negative exponent: friction of
    acrylic and glass falls with load (Warman and Ennos 2009), on aluminium by 46 % from 1 to 20 N (Seo 2009),
    which an exponent of -0.206 gives. Attraction then adds less friction than a coefficient at rest suggests.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*at_force*(Abs(normal_force + electrostatic_force)/at_force)**(1 + exponent)"
        ""
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.6, "at_force": 1.0, "exponent": -0.206}

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction at the force below")]
    at_force: Annotated[
        Number, Quantity("N", 1e-4, 1e3, "whole normal force at which the coefficient is meant")
    ]
    exponent: Annotated[Number, Quantity("1", -0.99, 2, "power of the coefficient; negative for skin")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Friction force [N]."""
        del real_contact_area
        share = np.abs(normal_force + electrostatic_force) / self.at_force
        return np.asarray(self.coefficient * self.at_force * share ** (1 + self.exponent))[()]


class AdhesiveShear(SteadyFriction):
    """Friction as the shear strength of the area that touches.

    Notes
    -----
    F = strength A_real: attraction counts by the contact area it makes. The contact has to tell that area.
    """

    equation: ClassVar[Mapping[str, str]] = {"lateral_force": "shear_strength*real_contact_area"}
    example: ClassVar[Mapping[str, Any]] = {"shear_strength": 1e6}

    shear_strength: Annotated[Number, Quantity("Pa", 1, 1e10, "friction over the area that touches")]

    @property
    def needs_real_area(self) -> bool:
        """Give True."""
        return True

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Friction force [N]."""
        del normal_force, electrostatic_force
        return self.shear_strength * real_contact_area
