"""How the finger moves: along the plate, and towards it."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.time_profile import Steady, TimeProfile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

_DISTANCE = Quantity("m", 1e-9, 1e-1, "distance of the finger from the plate")


class Separation(Model, family=True):
    """When a finger is off the plate.

    Notes
    -----
    A hand holds it there against the attraction. Off the plate nothing rubs; in touch load and attraction press.
    """

    @abstractmethod
    def breaks(self) -> tuple[float, ...]:
        """Times at which the finger begins or ends to touch [s], increasing, among others."""

    def touches(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger touches: never, unless a member says otherwise."""
        return np.zeros(np.shape(time), dtype=bool)


class HeldOff(Separation):
    """A finger held still off the plate, as far as the gap of the stack is thick."""

    def breaks(self) -> tuple[float, ...]:
        """Give none."""
        return ()


class Distance(Separation, family=True):
    """Distance of the finger from the plate over time: the thickness of the layer ``gap``.

    Notes
    -----
    Given, whatever the attraction. Smooth between its breaks.
    """

    @abstractmethod
    def gap(self, time: ArrayLike) -> NDArray[np.float64]:
        """Distance of the finger from the plate.

        Parameters
        ----------
        time : array_like, any shape
            s; NaN gives NaN.

        Returns
        -------
        ndarray
            m, above 0, same shape.
        """

    @abstractmethod
    def rate(self, time: ArrayLike) -> NDArray[np.float64]:
        """Rate of change of the distance, just after a break.

        Parameters
        ----------
        time : array_like, any shape
            s; NaN gives NaN.

        Returns
        -------
        ndarray
            m/s, negative on approach, same shape.
        """

    @abstractmethod
    def breaks(self) -> tuple[float, ...]:
        """Times at which the distance is not smooth, or the finger begins or ends to touch [s], increasing."""

    @property
    @abstractmethod
    def fastest(self) -> float:
        """Highest frequency that a grid of times has to resolve [Hz], above 0."""


class TremblingDistance(Distance):
    """A finger held near the plate, which no hand does without trembling."""

    example: ClassVar[Mapping[str, Any]] = {"mean": 100e-6, "amplitude": 10e-6, "frequency": 8.0}

    mean: Annotated[Number, _DISTANCE]
    amplitude: Annotated[Number, Quantity("m", 0, 1e-1, "largest departure from the mean distance")]
    frequency: Annotated[Number, Quantity("Hz", 1e-3, 1e3, "of the tremor")]

    @model_validator(mode="after")
    def _never_touches(self) -> Self:
        if self.amplitude >= self.mean:
            raise ValueError(
                "amplitude must be below the mean distance: the finger would go through the plate"
            )
        return self

    def gap(self, time: ArrayLike) -> NDArray[np.float64]:
        """Give a sine about the mean [m] at times [s]."""
        turn = 2 * np.pi * self.frequency * np.asarray(time, dtype=float)
        return np.asarray(self.mean + self.amplitude * np.sin(turn))

    def rate(self, time: ArrayLike) -> NDArray[np.float64]:
        """Give its rate of change [m/s] at times [s]."""
        angular = 2 * np.pi * self.frequency
        return np.asarray(angular * self.amplitude * np.cos(angular * np.asarray(time, dtype=float)))

    def breaks(self) -> tuple[float, ...]:
        """Give none."""
        return ()

    @property
    def fastest(self) -> float:
        """The tremor [Hz]."""
        return self.frequency


class TouchAndLift(Distance):
    """From far to touch and off again, with smooth ends: half a cosine in the logarithm of the distance.

    Notes
    -----
    The logarithm, because the last micrometres change the field as much as the first millimetre.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "far": 1e-3,
        "near": 1e-6,
        "approach": 0.1,
        "touch": 0.1,
        "lift": 0.1,
    }

    far: Annotated[Number, _DISTANCE]
    near: Annotated[Number, Quantity("m", 1e-9, 1e-1, "gap that remains while it touches")]
    begin: Annotated[Number, Quantity("s", 0, 1e5, "when the approach begins")] = 0.0
    approach: Annotated[Number, Quantity("s", 1e-6, 1e5, "time from far to touch")]
    touch: Annotated[Number, Quantity("s", 0, 1e5, "time in touch")]
    lift: Annotated[Number, Quantity("s", 1e-6, 1e5, "time from touch to far")]

    @model_validator(mode="after")
    def _comes_nearer(self) -> Self:
        if self.near >= self.far:
            raise ValueError("near must be below far")
        return self

    def gap(self, time: ArrayLike) -> NDArray[np.float64]:
        """Distance [m] at times [s]."""
        times = np.asarray(time, dtype=float)
        begin, top, end, far = self.breaks()
        down = np.clip((times - begin) / (top - begin), 0.0, 1.0)
        up = np.clip((times - end) / (far - end), 0.0, 1.0)
        near = (np.cos(np.pi * up) - np.cos(np.pi * down)) / 2  # 0 far, 1 near
        return np.asarray(self.far * (self.near / self.far) ** near)

    def rate(self, time: ArrayLike) -> NDArray[np.float64]:
        """Rate of change [m/s] at times [s]; 0 at the ends of approach and lift."""
        times = np.asarray(time, dtype=float)
        begin, top, end, far = self.breaks()
        down = np.clip((times - begin) / (top - begin), 0.0, 1.0)
        up = np.clip((times - end) / (far - end), 0.0, 1.0)
        approaches, lifts = ((share > 0) & (share < 1) for share in (down, up))
        nearing = approaches * np.sin(np.pi * down) / (top - begin) - lifts * np.sin(np.pi * up) / (far - end)
        return np.asarray(self.gap(times) * np.log(self.near / self.far) * np.pi / 2 * nearing)

    def touches(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] it is as near as it comes: from the end of the approach until the lift begins."""
        _, top, end, _ = self.breaks()
        times = np.asarray(time, dtype=float)
        return np.asarray((times >= top) & (times < end))

    def breaks(self) -> tuple[float, ...]:
        """Give the ends of approach and lift."""
        top = self.begin + self.approach
        return (self.begin, top, top + self.touch, top + self.touch + self.lift)

    @property
    def fastest(self) -> float:
        """One over twice the shorter of approach and lift, times the octaves it goes through [Hz]."""
        octaves = max(1.0, float(np.log2(self.far / self.near)))
        return octaves / (2 * min(self.approach, self.lift))


class Motion(Model):
    """Sliding speed over time, whether sliding renews the film, and when the finger is off the plate.

    Notes
    -----
    Without a speed the finger slides, at a speed that is not stated; it rests where the speed is 0 and where its
    time profile has stopped. It touches unless `distance` says otherwise, however thick a layer ``gap`` is.
    With `renews_film`, film that comes under the leading edge brings its own charge (the ``initial_charge`` of
    its layer, none by default) and takes what has leaked onto it away at the trailing edge.
    """

    former_parameters: ClassVar[Mapping[str, str]] = {"programme": "time_profile"}

    speed: Annotated[Number | None, Quantity("m/s", 0, 100, "full sliding speed of the finger")] = None
    time_profile: TimeProfile = Steady()
    renews_film: Annotated[bool, Field(description="whether sliding brings fresh film under the finger")] = (
        False
    )
    distance: Annotated[
        Separation | None,
        Field(description="when the finger is off the plate; it touches all the time without"),
    ] = None

    @model_validator(mode="after")
    def _a_speed_is_there(self) -> Self:
        if self.speed is None and not isinstance(self.time_profile, Steady):
            raise ValueError(
                "time profile needs the speed that it is a share of, for instance speed = '30 mm/s'"
            )
        if self.renews_film and not self.speed:
            raise ValueError("renews_film needs a speed, for instance speed = '30 mm/s'")
        if self.renews_film and self.distance is not None:
            raise ValueError("renews_film goes with a finger in touch: leave distance away")
        return self

    @property
    def moved_gap(self) -> Distance | None:
        """Distance that moves the layer ``gap``; None where it stays as it is."""
        return self.distance if isinstance(self.distance, Distance) else None

    def speeds(self, time: ArrayLike) -> NDArray[np.float64]:
        """Sliding speed [m/s] at times [s]; 0 without a speed."""
        return np.asarray((self.speed or 0.0) * self.time_profile.share(time))

    def touches(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger touches the plate."""
        return np.ones(np.shape(time), dtype=bool) if self.distance is None else self.distance.touches(time)

    def slides(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] it touches and moves; at the moment of a stop it rests."""
        if self.speed is None:
            return self.touches(time)
        return np.asarray(self.touches(time) & self.time_profile.runs(time) & (self.speed > 0))

    def rests(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] it touches and does not move."""
        return np.asarray(self.touches(time) & ~self.slides(time))

    def breaks(self) -> tuple[float, ...]:
        """Times at which it may begin or end to touch or to slide [s], increasing."""
        held = () if self.distance is None else self.distance.breaks()
        return tuple(sorted({*held, *(time for time, _ in self.time_profile.corners())}))
