"""The load, and the family of frictions."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.programme import Programme, Steady

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


class Load(Model):
    """How the finger is pressed on the plate."""

    example: ClassVar[Mapping[str, Any]] = {"normal_force": 0.5}

    normal_force: Annotated[Number, Quantity("N", 0, 1e3, "full force with which the finger is pressed")]
    programme: Programme = Steady()

    def forces(self, time: ArrayLike) -> NDArray[np.float64]:
        """Force with which the finger is pressed [N] at times [s]."""
        return np.asarray(self.normal_force * self.programme.share(time))


class Friction(Model, family=True):
    """Friction of a finger on the plate."""


class SteadyFriction(Friction, family=True):
    """Friction of a finger that slides, as if it always had: no memory."""

    @abstractmethod
    def lateral_force(
        self,
        normal_force: NDArray[np.float64],
        electrostatic_force: NDArray[np.float64],
        real_contact_area: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Friction force of the sliding finger.

        Parameters
        ----------
        normal_force, electrostatic_force : float or ndarray, one shape
            Load and attraction [N]; NaN gives NaN.
        real_contact_area : float or ndarray, same shape
            Area that touches under both [m2]; NaN where the contact does not tell, which only laws that take it
            hand on.

        Returns
        -------
        float or ndarray
            N, same shape.
        """

    @property
    def needs_real_area(self) -> bool:
        """Tell whether the law is one of the area that touches."""
        return False


class FollowingFriction(Friction, family=True):
    """Friction with a memory, of what a law without one would give."""

    steady: Annotated[SteadyFriction, Field(description="friction of steady sliding, which this one follows")]
