"""Friction without memory, as a function of load and attraction or of the real contact area."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.friction.base import SteadyFriction

if TYPE_CHECKING:
    from collections.abc import Mapping


class Coulomb(SteadyFriction):
    """Friction proportional to the sum of load and attraction (Coulomb's law)."""

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*(normal_force + electrostatic_force)"
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.5}
    proportional_to: ClassVar[tuple[str, ...]] = ("coefficient",)
    is_linear: ClassVar[bool] = True

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction of the sliding finger")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force [N]."""
        del real_contact_area
        return self.coefficient * (normal_force + electrostatic_force)


class PowerLaw(SteadyFriction):
    """Friction with a coefficient that is a power of the sum of load and attraction.

    Notes
    -----
    mu = coefficient (W/at_force)^exponent with W the sum of load and attraction. Skin has a negative exponent: the
    coefficient falls with load on acrylic and glass (Warman and Ennos 2009), on aluminium by 46 % from 1 to 20 N
    (Seo 2009), which an exponent of -0.206 gives. Attraction then adds less friction than with a constant coefficient.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*at_force*(Abs(normal_force + electrostatic_force)/at_force)**(1 + exponent)"
        ""
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.6, "at_force": 1.0, "exponent": -0.206}
    proportional_to: ClassVar[tuple[str, ...]] = ("coefficient",)

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction at at_force")]
    at_force: Annotated[
        Number, Quantity("N", 1e-4, 1e3, "sum of load and attraction to which the coefficient applies")
    ]
    exponent: Annotated[Number, Quantity("1", -0.99, 2, "power of the coefficient; negative for skin")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force [N]."""
        del real_contact_area
        share = np.abs(normal_force + electrostatic_force) / self.at_force
        return np.asarray(self.coefficient * self.at_force * share ** (1 + self.exponent))[()]


class AdhesiveShear(SteadyFriction):
    """Friction as a shear strength times the real contact area.

    Notes
    -----
    F = shear_strength A_real: attraction increases friction by increasing the real contact area, which the contact has
    to define with a `surface`.
    """

    equation: ClassVar[Mapping[str, str]] = {"lateral_force": "shear_strength*real_contact_area"}
    example: ClassVar[Mapping[str, Any]] = {"shear_strength": 1e6}
    proportional_to: ClassVar[tuple[str, ...]] = ("shear_strength",)
    needs_real_area: ClassVar[bool] = True

    shear_strength: Annotated[Number, Quantity("Pa", 1, 1e10, "friction over the real contact area")]

    def lateral_force(self, normal_force: Real, electrostatic_force: Real, real_contact_area: Real) -> Real:
        """Return the friction force [N]."""
        del normal_force, electrostatic_force
        return self.shear_strength * real_contact_area
