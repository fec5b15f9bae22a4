"""Textures, and gratings as the simplest of them."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

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


_PERIODS = 10
"""Periods of a stroke over a grating, where no length is given; a choice."""
_EDGE = Quantity("1", 1e-6, 0.5, "length of an edge over the period", "a choice")


class GratingWaveform(Model, family=True):
    """Waveform of a grating, between -1 and 1."""

    @abstractmethod
    def value(self, periods: Real) -> Real:
        """Return the waveform.

        Parameters
        ----------
        periods : ndarray, any shape
            Position over the period [1].

        Returns
        -------
        value : ndarray, same shape
            Value of the waveform, dimensionless, from -1 to 1.
        """


class SinusoidalWaveform(GratingWaveform):
    """A sine that is 0 and rises at position 0."""

    equation: ClassVar[Mapping[str, str]] = {"value": "sin(2*pi*periods)"}

    def value(self, periods: Real) -> Real:
        """Return sin(2 pi s) at positions s over the period [1]."""
        return np.asarray(np.sin(2 * math.pi * periods))


class TriangularWaveform(GratingWaveform):
    """Straight flanks between -1 and 1, 0 and rising at position 0."""

    equation: ClassVar[Mapping[str, str]] = {"value": "1 - 4*Abs((periods + 1/4) % 1 - 1/2)"}

    def value(self, periods: Real) -> Real:
        """Return the triangle at positions over the period [1]."""
        return np.asarray(1 - 4 * _distance(periods - 0.25))


class RectangularWaveform(GratingWaveform):
    """Ridges at 1 and grooves at -1, joined by straight edges; a ridge begins at position 0."""

    equation: ClassVar[Mapping[str, str]] = {
        "distance": "Abs((periods + (1 - duty)/2) % 1 - 1/2)",
        "value": "Max(-1, Min(1, (duty - 2*distance)/edge))",
    }

    duty: Annotated[Number, Quantity("1", 1e-3, 0.999, "width of a ridge over the period")] = 0.5
    edge: Annotated[Number, _EDGE] = 0.05

    @model_validator(mode="after")
    def _edges_fit(self) -> Self:
        if self.edge > min(self.duty, 1 - self.duty):
            raise ValueError("edge must not be longer than a ridge or a groove: reduce edge")
        return self

    def value(self, periods: Real) -> Real:
        """Return the trapezoidal wave at positions over the period [1]."""
        from_edge = self.duty / 2 - _distance(periods - self.duty / 2)
        return np.asarray(np.clip(2 * from_edge / self.edge, -1.0, 1.0))


class SawtoothWaveform(GratingWaveform):
    """A straight rise from -1 to 1 that begins at position 0, and a short straight fall."""

    equation: ClassVar[Mapping[str, str]] = {
        "share": "periods % 1",
        "value": "Min(2*share/(1 - edge) - 1, 2*(1 - share)/edge - 1)",
    }

    edge: Annotated[Number, _EDGE] = 0.05

    def value(self, periods: Real) -> Real:
        """Return the sawtooth at positions over the period [1]."""
        share = periods - np.floor(periods)
        return np.asarray(np.minimum(2 * share / (1 - self.edge) - 1, 2 * (1 - share) / self.edge - 1))


class Grating(TextureAlongLine):
    """Added friction that varies periodically between 0 and twice its amplitude.

    Notes
    -----
    F(s) = amplitude (1 + w(s/period)) with the waveform w between -1 and 1 and the coordinate s along the direction of
    variation. At the speed u the friction has the fundamental frequency u/period.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "along": "vectors[x]*cos(angle) + vectors[y]*sin(angle)",
        "added_friction": "amplitude*(1 + waveform.value(along(position)/period))",
    }
    example: ClassVar[Mapping[str, Any]] = {"period": 2e-3, "amplitude": 1e-3}

    period: Annotated[Number, Quantity("m", 1e-6, 1, "length of a period")]
    amplitude: Annotated[Number, Quantity("N", 0, 1e3, "half the variation of the friction force")]
    waveform: GratingWaveform = SinusoidalWaveform()

    def added_friction(self, position: Real, velocity: Real, plate: RenderingPlate) -> Real:
        """Return amplitude (1 + w) [N]."""
        del velocity, plate
        wave = self.waveform.value(self.along(position) / self.period)
        return np.asarray(self.amplitude * (1 + wave))

    @property
    def length(self) -> float:
        """Ten periods [m]."""
        return _PERIODS * self.period


def _distance(periods: Real) -> Real:
    """Return the distance from the nearest whole number."""
    return np.asarray(np.abs(periods - np.rint(periods)))
