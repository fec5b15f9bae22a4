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
    """Times at which the finger is off the plate.

    Notes
    -----
    The finger is held off the plate against the attraction. Off the plate there is no friction; in contact, load and
    attraction press.
    """

    @abstractmethod
    def breaks(self) -> tuple[float, ...]:
        """Return the increasing times [s] at which contact begins or ends, or a distance is not smooth."""

    def touches(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger touches the plate: at none, unless a member defines contact."""
        return np.zeros(np.shape(time), dtype=bool)


class HeldOff(Separation):
    """A finger at rest off the plate, at a distance equal to the thickness of the layer ``gap``."""

    def breaks(self) -> tuple[float, ...]:
        """Return no times."""
        return ()


class Distance(Separation, family=True):
    """Distance of the finger from the plate over time, which is the thickness of the layer ``gap``.

    Notes
    -----
    The distance is prescribed and does not depend on the attraction. It is smooth between its breaks.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset({"gap", "fastest"})

    @abstractmethod
    def gap(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the distance of the finger from the plate.

        Parameters
        ----------
        time : array_like, any shape
            Times [s]; NaN gives NaN.

        Returns
        -------
        distance : ndarray, same shape
            Distance [m], above 0.
        """

    @abstractmethod
    def rate(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the rate of change of the distance; at a break that just after it.

        Parameters
        ----------
        time : array_like, any shape
            Times [s]; NaN gives NaN.

        Returns
        -------
        rate : ndarray, same shape
            Rate of change [m/s], negative on approach.
        """

    @property
    @abstractmethod
    def fastest(self) -> float:
        """Highest frequency of the motion that a grid of times has to resolve [Hz], above 0."""


class TremblingDistance(Distance):
    """A finger held near the plate with a sinusoidal tremor."""

    equation: ClassVar[Mapping[str, str]] = {
        "gap": "mean + amplitude*sin(2*pi*frequency*time)",
        "rate": "2*pi*frequency*amplitude*cos(2*pi*frequency*time)",
    }
    example: ClassVar[Mapping[str, Any]] = {"mean": 100e-6, "amplitude": 10e-6, "frequency": 8.0}

    mean: Annotated[Number, _DISTANCE]
    amplitude: Annotated[Number, Quantity("m", 0, 1e-1, "amplitude of the tremor about the mean distance")]
    frequency: Annotated[Number, Quantity("Hz", 1e-3, 1e3, "frequency of the tremor")]

    @model_validator(mode="after")
    def _never_touches(self) -> Self:
        if self.amplitude >= self.mean:
            raise ValueError(
                "amplitude must be below the mean distance, because the distance has to stay above 0"
            )
        return self

    def gap(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the distance [m] at times [s]: a sine about the mean."""
        turn = 2 * np.pi * self.frequency * np.asarray(time, dtype=float)
        return np.asarray(self.mean + self.amplitude * np.sin(turn))

    def rate(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the rate of change of the distance [m/s] at times [s]."""
        angular = 2 * np.pi * self.frequency
        return np.asarray(angular * self.amplitude * np.cos(angular * np.asarray(time, dtype=float)))

    def breaks(self) -> tuple[float, ...]:
        """Return no times."""
        return ()

    @property
    def fastest(self) -> float:
        """Frequency of the tremor [Hz]."""
        return self.frequency


class TouchAndLift(Distance):
    """Approach, contact and lift of the finger: half a cosine in the logarithm of the distance for each.

    Notes
    -----
    The logarithm is used because the last micrometres change the field as much as the first millimetre.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "approached": "Max(0, Min(1, (time - begin)/approach))",
        "lifted": "Max(0, Min(1, (time - begin - approach - touch)/lift))",
        "nearness": "(cos(pi*lifted) - cos(pi*approached))/2",
        "gap": "far*(near/far)**nearness",
        "rate": "far*(near/far)**nearness*log(near/far)*pi/2*(sin(pi*approached)/approach - sin(pi*lifted)/lift)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "far": 1e-3,
        "near": 1e-6,
        "approach": 0.1,
        "touch": 0.1,
        "lift": 0.1,
    }

    far: Annotated[Number, _DISTANCE]
    near: Annotated[Number, Quantity("m", 1e-9, 1e-1, "gap that remains in contact")]
    begin: Annotated[Number, Quantity("s", 0, 1e5, "time at which the approach begins")] = 0.0
    approach: Annotated[Number, Quantity("s", 1e-6, 1e5, "duration of the approach")]
    touch: Annotated[Number, Quantity("s", 0, 1e5, "duration of the contact")]
    lift: Annotated[Number, Quantity("s", 1e-6, 1e5, "duration of the lift")]

    @model_validator(mode="after")
    def _comes_nearer(self) -> Self:
        if self.near >= self.far:
            raise ValueError("near must be below far")
        return self

    def _shares(self, time: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return how much of approach and of lift is over at times [s]."""
        times = np.asarray(time, dtype=float)
        begin, top, end, far = self.breaks()
        return np.clip((times - begin) / (top - begin), 0.0, 1.0), np.clip(
            (times - end) / (far - end), 0.0, 1.0
        )

    def gap(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the distance [m] at times [s]."""
        down, up = self._shares(time)
        near = (np.cos(np.pi * up) - np.cos(np.pi * down)) / 2  # 0 far, 1 near
        return np.asarray(self.far * (self.near / self.far) ** near)

    def rate(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the rate of change [m/s] at times [s]; 0 at the ends of approach and lift."""
        begin, top, end, far = self.breaks()
        down, up = self._shares(time)
        approaches, lifts = ((share > 0) & (share < 1) for share in (down, up))
        nearing = approaches * np.sin(np.pi * down) / (top - begin) - lifts * np.sin(np.pi * up) / (far - end)
        return np.asarray(self.gap(time) * np.log(self.near / self.far) * np.pi / 2 * nearing)

    def touches(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger is in contact: from the end of the approach until the lift begins."""
        _, top, end, _ = self.breaks()
        times = np.asarray(time, dtype=float)
        return np.asarray((times >= top) & (times < end))

    def breaks(self) -> tuple[float, ...]:
        """Return the times at which approach and lift begin and end [s]."""
        top = self.begin + self.approach
        return (self.begin, top, top + self.touch, top + self.touch + self.lift)

    @property
    def fastest(self) -> float:
        """Octaves of distance over twice the shorter of approach and lift [Hz]."""
        octaves = max(1.0, float(np.log2(self.far / self.near)))
        return octaves / (2 * min(self.approach, self.lift))


class Motion(Model):
    """Motion of the finger: sliding speed, renewal of the film by sliding, and distance from the plate.

    Notes
    -----
    Without `speed` the finger slides at an unspecified speed; it is at rest where the speed is 0 or its time profile has
    stopped. The finger is in contact unless `distance` is given, whatever the thickness of a layer ``gap``. With
    `renews_film`, film that enters at the leading edge brings its own charge (the ``initial_charge`` of its layer, 0
    by default), and film that leaves at the trailing edge carries away the charge that has leaked onto it.
    """

    equation: ClassVar[Mapping[str, str]] = {"speeds": "speed*time_profile.share(time)"}

    speed: Annotated[Number | None, Quantity("m/s", 0, 100, "full sliding speed of the finger")] = None
    time_profile: TimeProfile = Steady()
    renews_film: Annotated[bool, Field(description="whether sliding brings fresh film under the finger")] = (
        False
    )
    distance: Annotated[
        Separation | None,
        Field(description="distance from the plate over time; without it the finger is always in contact"),
    ] = None

    @model_validator(mode="after")
    def _a_speed_is_there(self) -> Self:
        if self.speed is None and not isinstance(self.time_profile, Steady):
            raise ValueError("time_profile scales the speed and needs one, for instance speed = '30 mm/s'")
        if self.renews_film and not self.speed:
            raise ValueError("renews_film needs a speed, for instance speed = '30 mm/s'")
        if self.renews_film and self.distance is not None:
            raise ValueError("renews_film requires a finger in contact: omit distance")
        return self

    @property
    def moved_gap(self) -> Distance | None:
        """Prescribed distance that sets the thickness of the layer ``gap``; None where that is constant."""
        return self.distance if isinstance(self.distance, Distance) else None

    def speeds(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the sliding speed [m/s] at times [s]; 0 without a speed."""
        return np.asarray((self.speed or 0.0) * self.time_profile.share(time))

    def touches(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger touches the plate."""
        return np.ones(np.shape(time), dtype=bool) if self.distance is None else self.distance.touches(time)

    def slides(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger slides in contact; at the time of a stop it is at rest."""
        if self.speed is None:
            return self.touches(time)
        return np.asarray(self.touches(time) & self.time_profile.runs(time) & (self.speed > 0))

    def rests(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Tell at which times [s] the finger is at rest in contact."""
        return np.asarray(self.touches(time) & ~self.slides(time))

    def breaks(self) -> tuple[float, ...]:
        """Return the increasing times [s] at which contact or sliding may begin or end."""
        held = () if self.distance is None else self.distance.breaks()
        return tuple(sorted({*held, *(time for time, _ in self.time_profile.corners())}))
