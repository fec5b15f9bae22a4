"""The tribometer: response of its sensors, conditioners and digitiser, and the calibration of its channels.

The rig of Vezzoli et al. 2014 has a Kistler 9217A piezoelectric sensor under the plate for the normal force, a floating
table on a Honeywell FSG sensor with a Maxim max4209H conditioner for the lateral force, and a Tektronix 3014B
oscilloscope as digitiser. The paper gives no resonance, damping, bandwidth, time constant, noise, resolution or range of
any of them, so none has a default here. They have to be identified on the rig, for instance from the ringing after a tap.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import ColumnName, Number, Quantity, column_unit
from electrovib.physics.drive.sampled import Refuse, StampTreatment
from electrovib.physics.stages import CreepResponse, HighPass, LowPass, Resonance, Stage, response

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


Resonant = Annotated[
    Number, Quantity("Hz", 0.1, 1e7, "natural frequency of the sensor with the parts that move on it")
]
Damped = Annotated[Number, Quantity("1", 1e-4, 1e3, "damping ratio of that resonance; 1 is critical damping")]
Noise = Annotated[
    Number, Quantity("N", 0, 1e3, "root mean square of the noise of one reading; 0: not modelled")
]


class SensorCreep(Model):
    """Creep of a sensor: the change of its reading under a constant force."""

    equation: ClassVar[Mapping[str, str]] = {"gain": "1 + share/(1 + 2*pi*I*frequency*time)"}
    example: ClassVar[Mapping[str, Any]] = {"share": -0.02, "time": 5.0}

    share: Annotated[
        Number,
        Quantity("1", -0.99, 10, "final change by creep over the first reading; negative for a decrease"),
    ]
    time: Annotated[Number, Quantity("s", 1e-6, 1e6, "time constant of the creep")]

    def stage(self) -> CreepResponse:
        """Return the linear stage from the reading without creep to that with it."""
        return CreepResponse((self.share,), (self.time,))

    def gain(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex reading with creep over that without it [1] at frequencies [Hz]."""
        return self.stage().at(frequency)


class LateralSensor(Model):
    """A moving table on a force sensor with a conditioner.

    Notes
    -----
    Vezzoli et al. 2014 name relaxation of this sensor, here `creep`, as a possible cause of falling edges that they
    cannot explain.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "resonance": "1/(1 - (frequency/natural_frequency)**2 + 2*I*damping_ratio*frequency/natural_frequency)",
        "conditioner": "1 if bandwidth is None else 1/(1 + I*frequency/bandwidth)",
        "crept": "1 if creep is None else 1 + creep.share/(1 + 2*pi*I*frequency*creep.time)",
        "gain": "resonance*conditioner*crept",
    }
    example: ClassVar[Mapping[str, Any]] = {"natural_frequency": 500.0, "damping_ratio": 0.05}

    natural_frequency: Resonant
    damping_ratio: Damped
    bandwidth: Annotated[
        Number | None,
        Quantity("Hz", 1e-2, 1e9, "first-order bandwidth of the conditioner; unlimited if absent"),
    ] = None
    creep: SensorCreep | None = None
    noise: Noise = 0.0

    def stages(self) -> tuple[Stage, ...]:
        """Return the linear stages from force to reading."""
        stages: list[Stage] = [Resonance(self.natural_frequency, self.damping_ratio)]
        if self.bandwidth is not None:
            stages.append(LowPass(self.bandwidth))
        if self.creep is not None:
            stages.append(self.creep.stage())
        return tuple(stages)

    def gain(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex reading per force [1] at frequencies [Hz]."""
        return response(self.stages(), frequency)


class PiezoSensor(Model):
    """A piezoelectric force sensor under the plate with a charge amplifier, which does not read constant forces."""

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
        Number, Quantity("s", 1e-4, 1e7, "time constant with which the reading of a constant force decays")
    ]
    noise: Noise = 0.0

    def stages(self) -> tuple[Stage, ...]:
        """Return the linear stages from force to reading."""
        return (Resonance(self.natural_frequency, self.damping_ratio), HighPass(self.time_constant))

    def gain(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex reading per force [1] at frequencies [Hz]."""
        return response(self.stages(), frequency)


class Digitiser(Model):
    """A sampler at a fixed rate with zero-order hold, which rounds to 2^bits levels from -range upwards.

    Notes
    -----
    Level k is k 2 range/2^bits, k from -2^(bits - 1) to 2^(bits - 1) - 1. Forces beyond are clipped to the last level,
    and a diagnostic states how often. The noise is normal and white from sample to sample, and determined by the seed.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "levels": "round(force/full_scale*2**(bits - 1))",
        "reading": (
            "full_scale/2**(bits - 1)*Max(-2**(bits - 1), Min(2**(bits - 1) - 1, levels(force, full_scale)))"
        ),
    }
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
        """Return the levels nearest to forces, without clipping.

        Parameters
        ----------
        force : array_like
            Force [N].
        full_scale : float
            Range of the channel, `normal_range` or `lateral_range` [N].

        Returns
        -------
        levels : ndarray, shape of `force`
            Numbers of the nearest levels, whole numbers as floats [1]; one level is full_scale/2^(bits - 1).
        """
        return np.asarray(np.round(np.asarray(force, dtype=float) / full_scale * 2.0 ** (self.bits - 1)))

    def reading(self, force: ArrayLike, *, full_scale: float) -> NDArray[np.float64]:
        """Return the digitised force: the nearest level, clipped to the range.

        Parameters
        ----------
        force, full_scale
            Force and range of the channel [N], as for `levels`.

        Returns
        -------
        reading : ndarray, shape of `force`
            Digitised force [N].
        """
        half = 2.0 ** (self.bits - 1)
        return np.asarray(
            np.clip(self.levels(force, full_scale=full_scale), -half, half - 1) * (full_scale / half)
        )


class Rig(Model, family=True):
    """A rig that measures the forces."""

    digitiser: Digitiser | None

    @abstractmethod
    def normal_stages(self) -> tuple[Stage, ...]:
        """Return the linear stages from normal force to its reading."""

    @abstractmethod
    def lateral_stages(self) -> tuple[Stage, ...]:
        """Return the linear stages from lateral force to its reading."""

    @abstractmethod
    def noises(self) -> tuple[float, float]:
        """Return the root mean square noise of one reading of the normal and of the lateral channel [N]."""


class Tribometer(Rig):
    """A piezoelectric sensor for the normal force, a floating table for the lateral force, and a digitiser for both."""

    example: ClassVar[Mapping[str, Any]] = {
        "normal": PiezoSensor.example,
        "lateral": LateralSensor.example,
        "digitiser": Digitiser.example,
    }

    normal: Annotated[PiezoSensor, Field(description="sensor of the normal force, under the plate")]
    lateral: Annotated[LateralSensor, Field(description="sensor of the lateral force, with the table on it")]
    digitiser: Annotated[Digitiser | None, Field(description="digitiser of both channels")] = None

    @model_validator(mode="after")
    def _noise_belongs_to_readings(self) -> Self:
        if self.digitiser is None and max(self.noises()) > 0:
            why = "noise is defined for one digitised reading, so it needs a digitiser; add rig.digitiser, or set noise to 0"
            raise ValueError(why)
        return self

    def normal_stages(self) -> tuple[Stage, ...]:
        """Return the linear stages from normal force to its reading."""
        return self.normal.stages()

    def lateral_stages(self) -> tuple[Stage, ...]:
        """Return the linear stages from lateral force to its reading."""
        return self.lateral.stages()

    def noises(self) -> tuple[float, float]:
        """Return the root mean square noise of one reading of the normal and of the lateral channel [N]."""
        return self.normal.noise, self.lateral.noise


_REGISTERS = (2.0**31, 2.0**32)
"""Counts at which registers of 32 bits wrap, with and without a sign bit."""


class ForceChannel(Model):
    """A recorded column that holds a force, or a voltage from which a force is computed.

    Notes
    -----
    With a `sensitivity` the column is a voltage; the sensitivity of a sensor whose voltage falls under load is
    negative. With a `unit` the column is a force, and `sign` = -1 where load makes it negative.
    """

    equation: ClassVar[Mapping[str, str]] = {"force": "sensitivity*(reading - offset)"}
    example: ClassVar[Mapping[str, Any]] = {"column": 0, "sensitivity": 0.5}

    column: ColumnName
    sensitivity: Annotated[
        Number | None,
        Quantity("N/V", -1e6, 1e6, "force per volt, negative if load lowers it; absent for a force"),
    ] = None
    offset: Annotated[Number, Quantity("V", -1e3, 1e3, "voltage without force, if known")] = 0.0
    unit: Annotated[
        Annotated[str, column_unit("N")] | None, Field(description="unit of a column that is a force")
    ] = None
    sign: Annotated[int, Field(description="-1 if load lowers a column that is a force, else 1")] = 1

    @model_validator(mode="after")
    def _measures_something(self) -> Self:
        why = ""
        if self.sensitivity == 0:
            why = "a sensitivity of 0 makes every force 0; give for instance '0.31 N/V', or omit it for a column in N"
        elif (self.sensitivity is None) == (self.unit is None):
            why = (
                "a column of voltages needs a sensitivity, for instance '0.31 N/V', and a column of forces a unit, for"
                f" instance 'N'; {'neither' if self.unit is None else 'both'} of the two given"
            )
        elif self.sign not in (1, -1):
            why = f"sign is 1 or -1, not {self.sign}"
        elif self.sensitivity is None and self.offset != 0:
            why = "an offset is a voltage and needs a sensitivity; the zero of a column of forces is determined from the record"
        elif self.sensitivity is not None and self.sign == -1:
            why = (
                "the sign of a voltage is that of its sensitivity: omit sign and give a negative sensitivity"
            )
        if why:
            raise ValueError(why)
        return self

    @property
    def read_as(self) -> str:
        """Unit of the column: that of a force, or V."""
        return self.unit or "V"

    def force(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the force before the zero of the sensor is determined from the record.

        Parameters
        ----------
        reading : ndarray, any shape
            Reading [V]; of a column that holds a force, in N.

        Returns
        -------
        force : ndarray, same shape
            Force [N]; of a column that holds a force, the sign times the reading.
        """
        if self.sensitivity is None:
            return self.sign * reading
        return self.sensitivity * (reading - self.offset)


class Encoder(Model):
    """Counts of a linear encoder in a register that wraps.

    Notes
    -----
    With `wraps_at` = 0 the size of the register is determined from the record: a change by more than a quarter of 2^31
    counts between two samples is taken as a wrap at 2^31 or 2^32, whichever is nearer.
    """

    equation: ClassVar[Mapping[str, str]] = {"position": "step*(counts + wraps(counts) - counts[first])"}
    example: ClassVar[Mapping[str, Any]] = {"column": 1, "step": 1e-6}

    column: ColumnName
    step: Annotated[Number, Quantity("m", -1.0, 1.0, "distance per count, negative if it counts backwards")]
    wraps_at: Annotated[
        Number,
        Quantity("1", 0, 2.0**53, "counts at which the register wraps; 0 to determine it from the record"),
    ] = 0.0

    @model_validator(mode="after")
    def _counts_something(self) -> Self:
        if self.step == 0:
            why = "a step of 0 makes every position 0; give for instance '0.5 um'"
            raise ValueError(why)
        return self

    def wraps(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the counts that each sample has lost to wraps since the first one.

        Parameters
        ----------
        counts : ndarray, shape (n,)
            Recorded counts [1].

        Returns
        -------
        lost : ndarray, shape (n,)
            Counts to be added to the recorded ones [1]; 0 throughout without a wrap.
        """
        jumps = np.diff(counts, prepend=counts[:1])
        if self.wraps_at:
            return np.asarray(-self.wraps_at * np.cumsum(np.rint(jumps / self.wraps_at)), dtype=np.float64)
        size = np.abs(jumps)
        low, high = _REGISTERS
        nearest = np.where(size < (low + high) / 2, low, high)
        return -np.cumsum(np.where(size > low / 4, np.sign(jumps) * nearest, 0.0))

    def position(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the displacement of the carriage since the first sample.

        Parameters
        ----------
        counts : ndarray, shape (n,)
            Recorded counts [1].

        Returns
        -------
        position : ndarray, shape (n,)
            Position [m] relative to the first sample, with wraps removed.
        """
        unwrapped = counts + self.wraps(counts)
        return np.asarray(self.step * (unwrapped - unwrapped[0]), dtype=np.float64)


class Clock(Model, family=True):
    """Times at which the samples of a record were taken."""


class EvenSamples(Clock):
    """Samples at a fixed rate."""

    example: ClassVar[Mapping[str, Any]] = {"rate": 1e4}

    rate: Annotated[Number, Quantity("Hz", 1e-3, 1e9, "samples per second")]


class TimeColumn(Clock):
    """Time stamps in a column of the record."""

    example: ClassVar[Mapping[str, Any]] = {"column": 0}

    column: ColumnName
    unit: Annotated[str, column_unit("s"), Field(description="unit of the column")] = "s"
    stamps: Annotated[StampTreatment, Field(description="treatment of time stamps that do not increase")] = (
        Refuse()
    )


class TribometerChannels(Model):
    """Columns of a record that hold the normal force, the lateral force and the position, with their calibration."""

    example: ClassVar[Mapping[str, Any]] = {
        "normal": {"column": 0, "sensitivity": -0.31},
        "lateral": {"column": 1, "sensitivity": 0.5},
        "encoder": {"column": 2, "step": 1e-6},
        "clock": {"model": "EvenSamples", "rate": 1e4},
    }

    normal: ForceChannel
    lateral: ForceChannel
    encoder: Annotated[Encoder | None, Field(description="encoder of the carriage position, if recorded")] = (
        None
    )
    clock: Clock
    speed: Annotated[
        Number | None, Quantity("m/s", 0, 10, "set sliding speed, for a record without an encoder")
    ] = None
    missing_rows: Annotated[
        int, Field(description="largest number of rows with a NaN that may be omitted")
    ] = 0

    @model_validator(mode="after")
    def _says_a_speed_once(self) -> Self:
        why = ""
        if self.encoder is not None and self.speed is not None:
            why = "the speed follows from the encoder: omit speed, or the encoder"
        elif not 0 <= self.missing_rows <= 10**9:
            why = f"missing_rows = {self.missing_rows}: expected a number of rows from 0 to 1e9"
        if why:
            raise ValueError(why)
        return self
