"""The family of textures."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class RenderingPlate:
    """Forces of the plate on which a texture is rendered.

    Parameters
    ----------
    normal_force : float
        Load of the finger [N].
    largest_added_friction : float
        Friction force at the largest attraction of the hardware minus that without attraction [N].
    """

    normal_force: float
    largest_added_friction: float


class Texture(Model, family=True):
    """Friction that a finger is to feel, as a function of its position and velocity.

    Notes
    -----
    A texture states the friction force that is added to the plate's own friction. Attraction cannot reduce friction, so the
    added force has to be 0 or more.
    """

    checked_elsewhere: ClassVar[frozenset[str]] = frozenset({"added_friction", "along"})

    @abstractmethod
    def added_friction(self, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
        """Return the friction force that is added to the plate's own friction.

        Parameters
        ----------
        position : ndarray, shape (n, 2)
            Places x and y of the finger [m].
        velocity : ndarray, shape (n, 2)
            Velocity of the finger [m/s].
        plate : RenderingPlate
            Load and largest added friction.

        Returns
        -------
        force : ndarray, shape (n,)
            Added friction force [N]; a negative force cannot be rendered.
        """

    @property
    @abstractmethod
    def length(self) -> float:
        """Length of a stroke over the texture along x [m], where no other is given."""

    @property
    def across(self) -> float:
        """Place y of a stroke along x [m], where no other is given."""
        return 0.0


class TextureAlongLine(Texture, family=True):
    """Texture that varies along one direction."""

    angle: Annotated[Number, Quantity("rad", -10, 10, "direction of variation, from x towards y")] = 0.0

    def along(self, vectors: Real) -> Real:
        """Return the components of vectors along the direction of variation.

        Parameters
        ----------
        vectors : ndarray, shape (n, 2)
            Positions [m] or velocities [m/s].

        Returns
        -------
        components : ndarray, shape (n,)
            Components along the direction of variation, in the unit of the vectors.
        """
        if self.angle == 0:
            return np.asarray(vectors[:, 0])
        return np.asarray(vectors @ (math.cos(self.angle), math.sin(self.angle)))
