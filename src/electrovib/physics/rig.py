"""The tribometer: what its sensors, conditioners and digitiser make of the forces.

The rig of Vezzoli et al. 2014 has a Kistler 9217A piezo under the plate for the normal force; a floating table on a Honeywell FSG
sensor with a Maxim max4209H conditioner for the lateral one; a Tektronix 3014B oscilloscope as digitiser. The paper
gives no resonance, damping, bandwidth, time constant, noise, resolution or range of any of them, so that none has a
default here: identify them on the rig, for instance from the ringing after a tap.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.stages import CreepResponse, HighPass, LowPass, Resonance, Stage, response

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

Resonant = Annotated[Number, Quantity("Hz", 0.1, 1e7, "natural frequency of what moves on the sensor")]
Damped = Annotated[Number, Quantity("1", 1e-4, 1e3, "damping of that resonance, 1 is critical")]
Noise = Annotated[
    Number, Quantity("N", 0, 1e3, "root mean square of the noise of one reading; 0: not modelled")
]


class SensorCreep(Model):
    """What a sensor goes on to show under a force that is held."""

    former_names: ClassVar[tuple[str, ...]] = ("Creep",)
    example: ClassVar[Mapping[str, Any]] = {"share": -0.02, "time": 5.0}

    share: Annotated[
        Number,
        Quantity("1", -0.99, 10, "what creep adds in the end, of the first reading; negative: it gives way"),
    ]
    time: Annotated[Number, Quantity("s", 1e-6, 1e6, "time constant of the creep")]


class LateralSensor(Model):
    """A moving table on a force sensor, and its conditioner.

    Notes
    -----
    The paper suspects the relaxation of this sensor behind the falling edges it cannot explain: `creep`.
    """

    example: ClassVar[Mapping[str, Any]] = {"natural_frequency": 500.0, "damping_ratio": 0.05}

    natural_frequency: Resonant
    damping_ratio: Damped
    bandwidth: Annotated[
        Number | None,
        Quantity("Hz", 1e-2, 1e9, "first-order bandwidth of the conditioner; none: beyond all else"),
    ] = None
    creep: SensorCreep | None = None
    noise: Noise = 0.0

    def stages(self) -> tuple[Stage, ...]:
        """Give the linear stages from force to reading."""
        stages: list[Stage] = [Resonance(self.natural_frequency, self.damping_ratio)]
        if self.bandwidth is not None:
            stages.append(LowPass(self.bandwidth))
        if self.creep is not None:
            stages.append(CreepResponse((self.creep.share,), (self.creep.time,)))
        return tuple(stages)

    def gain(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Reading per force [-], complex, at frequencies [Hz]."""
        return response(self.stages(), frequency)


class PiezoSensor(Model):
    """A piezoelectric force sensor under the plate, and its charge amplifier: blind to what lasts."""

    equation: ClassVar[Mapping[str, str]] = {
        "gain": (
            "(2*pi*I*frequency*time_constant/(1 + 2*pi*I*frequency*time_constant))"
            "/(1 - (frequency/natural_frequency)**2 + 2*I*damping_ratio*frequency/natural_frequency)"
        )
    }
    example: ClassVar[Mapping[str, Any]] = {
        "natural_frequency": 2e3,
        "damping_ratio": 0.02,
        "time_constant": 10.0,
    }

    natural_frequency: Resonant
    damping_ratio: Damped
    time_constant: Annotated[
        Number, Quantity("s", 1e-4, 1e7, "time in which the charge amplifier forgets a held force")
    ]
    noise: Noise = 0.0

    def stages(self) -> tuple[Stage, ...]:
        """Give the linear stages from force to reading."""
        return (Resonance(self.natural_frequency, self.damping_ratio), HighPass(self.time_constant))

    def gain(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Reading per force [-], complex, at frequencies [Hz]."""
        return response(self.stages(), frequency)


class Digitiser(Model):
    """Samples at even times, held until the next; each rounded to one of 2^bits levels from -range up.

    Notes
    -----
    Level k is k 2 range/2^bits, k from -2^(bits - 1) to 2^(bits - 1) - 1. Beyond, the last level stands: a diagnostic says
    how often. Noise is normal, white from sample to sample, and one seed gives one record.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "sampling_rate": 1e4,
        "bits": 12,
        "normal_range": 2.0,
        "lateral_range": 1.0,
        "seed": 1,
    }

    sampling_rate: Annotated[Number, Quantity("Hz", 1e-3, 1e10, "readings per second of each channel")]
    bits: Annotated[int, Field(ge=1, le=32, description="resolution of both channels in bits, 1 to 32")]
    normal_range: Annotated[
        Number, Quantity("N", 1e-9, 1e6, "largest normal force that can be read, either sign")
    ]
    lateral_range: Annotated[
        Number, Quantity("N", 1e-9, 1e6, "largest lateral force that can be read, either sign")
    ]
    seed: Annotated[
        int, Field(ge=0, le=2**32 - 1, description="seed of the noise, a whole number of 32 bits")
    ]

    def levels(self, force: ArrayLike, *, full_scale: float) -> NDArray[np.float64]:
        """Levels nearest to forces, as if there were no last one.

        Parameters
        ----------
        force : array_like
            N.
        full_scale : float
            Range of the channel, `normal_range` or `lateral_range` [N].

        Returns
        -------
        ndarray, shape of `force`
            Whole numbers, as floats; one level is full_scale/2^(bits - 1).
        """
        return np.asarray(np.round(np.asarray(force, dtype=float) / full_scale * 2.0 ** (self.bits - 1)))

    def reading(self, force: ArrayLike, *, full_scale: float) -> NDArray[np.float64]:
        """Force that is read: the nearest level, or the last one.

        Parameters
        ----------
        force, full_scale
            As for `levels` [N].

        Returns
        -------
        ndarray, shape of `force`
            N.
        """
        half = 2.0 ** (self.bits - 1)
        return np.asarray(
            np.clip(self.levels(force, full_scale=full_scale), -half, half - 1) * (full_scale / half)
        )


class Rig(Model, family=True):
    """What measures the forces."""

    digitiser: Digitiser | None

    @abstractmethod
    def normal_stages(self) -> tuple[Stage, ...]:
        """Give the linear stages from normal force to its reading."""

    @abstractmethod
    def lateral_stages(self) -> tuple[Stage, ...]:
        """Give the linear stages from lateral force to its reading."""

    @abstractmethod
    def noises(self) -> tuple[float, float]:
        """Give the noise of one reading of the normal and of the lateral channel, root mean square [N]."""


class Tribometer(Rig):
    """Piezo sensor for the normal force, floating table for the lateral one, and what digitises both."""

    example: ClassVar[Mapping[str, Any]] = {
        "normal": PiezoSensor.example,
        "lateral": LateralSensor.example,
        "digitiser": Digitiser.example,
    }

    normal: Annotated[PiezoSensor, Field(description="sensor of the normal force, under the plate")]
    lateral: Annotated[LateralSensor, Field(description="sensor of the lateral force, with the table on it")]
    digitiser: Annotated[Digitiser | None, Field(description="what samples both channels")] = None

    @model_validator(mode="after")
    def _noise_belongs_to_readings(self) -> Self:
        if self.digitiser is None and max(self.noises()) > 0:
            why = "noise is that of one reading, so it needs a digitiser; or set noise to 0"
            raise PydanticCustomError("noise", "{why}", {"why": why})
        return self

    def normal_stages(self) -> tuple[Stage, ...]:
        """Give the linear stages from normal force to its reading."""
        return self.normal.stages()

    def lateral_stages(self) -> tuple[Stage, ...]:
        """Give the linear stages from lateral force to its reading."""
        return self.lateral.stages()

    def noises(self) -> tuple[float, float]:
        """Give the noise of one reading of the normal and of the lateral channel, root mean square [N]."""
        return self.normal.noise, self.lateral.noise
