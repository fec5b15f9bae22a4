"""Time profiles of load and speed: piecewise linear shares of the full value."""

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

_BEGIN = Quantity("s", 0, 1e5, "time at which the change begins")


class TimeProfile(Model, family=True):
    """A share of the full value, from 0 to 1, over time.

    Notes
    -----
    Linear between its corners, constant before the first and after the last.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset({"share"})

    @abstractmethod
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return time [s], increasing, and share [1] of every corner."""

    @property
    def is_constant(self) -> bool:
        """Whether the share is the same at all times."""
        return len({share for _, share in self.corners()}) == 1

    def share(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the share of the full value.

        Parameters
        ----------
        time : array_like, any shape
            Times [s]; NaN gives NaN.

        Returns
        -------
        share : ndarray, same shape
            Share of the full value [1], from 0 to 1.
        """
        times, shares = np.transpose(self.corners())
        return np.asarray(np.interp(np.asarray(time, dtype=float), times, shares))

    def runs(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the share is above 0 or begins to rise from 0; False at the time of a stop."""
        times, shares = np.transpose(self.corners())
        above = np.append(np.append(shares[0], np.maximum(shares[1:], shares[:-1])), shares[-1]) > 0
        return np.asarray(above[np.searchsorted(times, np.asarray(time, dtype=float), side="right")])


class Steady(TimeProfile):
    """The full value at all times."""

    equation: ClassVar[Mapping[str, str]] = {"share": "1"}

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return one corner."""
        return ((0.0, 1.0),)


class Press(TimeProfile):
    """A linear rise from 0 to the full value, which is then held."""

    equation: ClassVar[Mapping[str, str]] = {"share": "Max(0, Min(1, (time - begin)/rise))"}
    example: ClassVar[Mapping[str, Any]] = {"rise": 0.05}

    begin: Annotated[Number, _BEGIN] = 0.0
    rise: Annotated[Number, Quantity("s", 1e-6, 1e5, "duration of the rise")]

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return the ends of the rise."""
        return ((self.begin, 0.0), (self.begin + self.rise, 1.0))


class LiftOff(TimeProfile):
    """The full value, then a linear fall to 0."""

    equation: ClassVar[Mapping[str, str]] = {"share": "Max(0, Min(1, (begin + fall - time)/fall))"}
    example: ClassVar[Mapping[str, Any]] = {"begin": 0.1, "fall": 0.05}

    begin: Annotated[Number, _BEGIN]
    fall: Annotated[Number, Quantity("s", 1e-6, 1e5, "duration of the fall")]

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return the ends of the fall."""
        return ((self.begin, 1.0), (self.begin + self.fall, 0.0))


class Swipe(TimeProfile):
    """A rise, a hold and a fall: one stroke of a finger."""

    equation: ClassVar[Mapping[str, str]] = {
        "end": "begin + rise + hold + fall",
        "share": "Max(0, Min(1, (time - begin)/rise, (end - time)/fall))",
    }
    example: ClassVar[Mapping[str, Any]] = {"rise": 0.05, "hold": 0.2, "fall": 0.05}

    begin: Annotated[Number, _BEGIN] = 0.0
    rise: Annotated[Number, Quantity("s", 1e-6, 1e5, "duration of the rise")]
    hold: Annotated[Number, Quantity("s", 0, 1e5, "duration of the full value")]
    fall: Annotated[Number, Quantity("s", 1e-6, 1e5, "duration of the fall")]

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return the corners of the trapezoidal profile."""
        top, end = self.begin + self.rise, self.begin + self.rise + self.hold
        corners = [(self.begin, 0.0), (top, 1.0), (end, 1.0), (end + self.fall, 0.0)]
        return tuple(dict(corners).items())  # three without a hold


class Corner(Model):
    """One corner of a time profile."""

    example: ClassVar[Mapping[str, Any]] = {"time": 0.1, "share": 1.0}

    time: Annotated[Number, Quantity("s", 0, 1e5, "time of the corner")]
    share: Annotated[Number, Quantity("1", 0, 1, "share of the full value")]


class Corners(TimeProfile):
    """A piecewise linear profile between given corners."""

    example: ClassVar[Mapping[str, Any]] = {
        "points": ({"time": 0.0, "share": 0.0}, {"time": 0.1, "share": 1.0}, {"time": 0.3, "share": 0.2})
    }

    points: Annotated[tuple[Corner, ...], Field(description="corners, in the order of their times")]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        times = [point.time for point in self.points]
        if not times or sorted(set(times)) != times:
            raise ValueError("points need at least one corner, in the order of their times, each time once")
        return self

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return the given corners."""
        return tuple((point.time, point.share) for point in self.points)
