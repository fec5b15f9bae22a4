"""How load, speed and distance change over time: straight pieces between times, as a person or a stage does it."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

_BEGIN = Quantity("s", 0, 1e5, "when it begins")


class TimeProfile(Model, family=True):
    """A share of the full value, from 0 to 1, over time.

    Notes
    -----
    Straight between its corners, constant before the first and after the last.
    """

    @abstractmethod
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give time [s], increasing, and share [1] of every corner."""

    def share(self, time: ArrayLike) -> NDArray[np.float64]:
        """Share of the full value.

        Parameters
        ----------
        time : array_like, any shape
            s; NaN gives NaN.

        Returns
        -------
        ndarray
            1, same shape.
        """
        times, shares = np.transpose(self.corners())
        return np.asarray(np.interp(np.asarray(time, dtype=float), times, shares))

    def runs(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the share is above 0, or rises from 0 just then; at a stop it has stopped."""
        times, shares = np.transpose(self.corners())
        above = np.append(np.append(shares[0], np.maximum(shares[1:], shares[:-1])), shares[-1]) > 0
        return np.asarray(above[np.searchsorted(times, np.asarray(time, dtype=float), side="right")])


class Steady(TimeProfile):
    """The full value all the time."""

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give one corner."""
        return ((0.0, 1.0),)


class Press(TimeProfile):
    """Nothing before it begins, then a straight rise to the full value, which stays."""

    example: ClassVar[Mapping[str, Any]] = {"rise": 0.05}

    begin: Annotated[Number, _BEGIN] = 0.0
    rise: Annotated[Number, Quantity("s", 1e-6, 1e5, "time of the rise")]

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give the ends of the rise."""
        return ((self.begin, 0.0), (self.begin + self.rise, 1.0))


class LiftOff(TimeProfile):
    """The full value, then a straight fall to nothing."""

    example: ClassVar[Mapping[str, Any]] = {"begin": 0.1, "fall": 0.05}

    begin: Annotated[Number, _BEGIN]
    fall: Annotated[Number, Quantity("s", 1e-6, 1e5, "time of the fall")]

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give the ends of the fall."""
        return ((self.begin, 1.0), (self.begin + self.fall, 0.0))


class Swipe(TimeProfile):
    """A rise, a steady stretch and a fall: one stroke of a finger."""

    example: ClassVar[Mapping[str, Any]] = {"rise": 0.05, "hold": 0.2, "fall": 0.05}

    begin: Annotated[Number, _BEGIN] = 0.0
    rise: Annotated[Number, Quantity("s", 1e-6, 1e5, "time of the rise")]
    hold: Annotated[Number, Quantity("s", 0, 1e5, "time at the full value")]
    fall: Annotated[Number, Quantity("s", 1e-6, 1e5, "time of the fall")]

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give the corners of the trapezoidal pulse."""
        top, end = self.begin + self.rise, self.begin + self.rise + self.hold
        corners = [(self.begin, 0.0), (top, 1.0), (end, 1.0), (end + self.fall, 0.0)]
        return tuple(dict(corners).items())  # without a stretch, three


class Corner(Model):
    """One corner of a time profile."""

    example: ClassVar[Mapping[str, Any]] = {"time": 0.1, "share": 1.0}

    time: Annotated[Number, Quantity("s", 0, 1e5, "when")]
    share: Annotated[Number, Quantity("1", 0, 1, "of the full value")]


class Corners(TimeProfile):
    """Any straight pieces between given corners."""

    example: ClassVar[Mapping[str, Any]] = {
        "points": ({"time": 0.0, "share": 0.0}, {"time": 0.1, "share": 1.0}, {"time": 0.3, "share": 0.2})
    }

    points: Annotated[tuple[Corner, ...], Field(description="corners, in the order of their times")]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        times = [point.time for point in self.points]
        if not times or sorted(set(times)) != times:
            raise ValueError("points must be at least one, in the order of their times, each time once")
        return self

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Give what was given."""
        return tuple((point.time, point.share) for point in self.points)
