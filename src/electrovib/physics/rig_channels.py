"""How the channels of a tribometer become forces and a position: sensitivities, signs and encoder counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.column_unit import column_unit
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.sampled import Refuse, StampTreatment

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

_REGISTERS = (2.0**31, 2.0**32)
"""Where counters wrap that do not say it: 32 bits with and without a sign bit."""


class ForceChannel(Model):
    """A column that is a force, or a voltage that stands for one.

    Notes
    -----
    With a `sensitivity` the column is a voltage; a sensor whose voltage falls under load has a negative one. With a
    `unit` it is a force already, and `sign` = -1 where load makes it negative.
    """

    equation: ClassVar[Mapping[str, str]] = {"force": "sensitivity*(reading - offset)"}
    example: ClassVar[Mapping[str, Any]] = {"column": 0, "sensitivity": 0.5}

    column: Annotated[str | int, Field(description="name or number of the column")]
    sensitivity: Annotated[
        Number | None,
        Quantity("N/V", -1e6, 1e6, "force per volt, negative if load lowers it; absent for a force"),
    ] = None
    offset: Annotated[Number, Quantity("V", -1e3, 1e3, "voltage without force, where it is known")] = 0.0
    unit: Annotated[
        Annotated[str, column_unit("N")] | None, Field(description="unit of a column that is a force")
    ] = None
    sign: Annotated[int, Field(description="-1 if load lowers a column that is a force, else 1")] = 1

    @model_validator(mode="after")
    def _measures_something(self) -> Self:
        why = ""
        if self.sensitivity == 0:
            why = "a sensitivity of 0 makes every force 0; for instance '0.31 N/V', or none for a column that is in N"
        elif (self.sensitivity is None) == (self.unit is None):
            why = (
                "a voltage needs a sensitivity, for instance '0.31 N/V', and a column that is a force already its"
                f" unit, for instance 'N': here are {'none' if self.unit is None else 'both'} of the two"
            )
        elif self.sign not in (1, -1):
            why = f"sign is 1 or -1, not {self.sign}"
        elif self.sensitivity is None and self.offset != 0:
            why = "an offset is a voltage and needs a sensitivity; the zero of a force is found in the record"
        elif self.sensitivity is not None and self.sign == -1:
            why = "a sensitivity has the sign of its own: leave sign out and write a negative sensitivity"
        if why:
            raise PydanticCustomError("sensitivity", "{why}", {"why": why})
        return self

    @property
    def read_as(self) -> str:
        """Unit in which the column is to be read: of a force or of a voltage."""
        return self.unit or "V"

    def force(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force [N] that a reading [V or N] stands for; the zero of the sensor is judged later, from the record."""
        if self.sensitivity is None:
            return self.sign * reading
        return self.sensitivity * (reading - self.offset)


class Encoder(Model):
    """Counts of a linear encoder, in a register that wraps.

    Notes
    -----
    With `wraps_at` = 0 it is found from the record: no carriage goes a quarter of 2^31 counts between two samples, so
    a jump beyond that is a wrap, at 2^31 or at 2^32, whichever it is nearer to.
    """

    example: ClassVar[Mapping[str, Any]] = {"column": 1, "step": 1e-6}

    column: Annotated[str | int, Field(description="name or number of the column")]
    step: Annotated[Number, Quantity("m", -1.0, 1.0, "way per count, negative if it counts backwards")]
    wraps_at: Annotated[Number, Quantity("1", 0, 2.0**53, "counts after which it wraps, 0 to find out")] = 0.0

    @model_validator(mode="after")
    def _counts_something(self) -> Self:
        if self.step == 0:
            why = "a step of 0 makes every position 0; for instance '0.5 um'"
            raise PydanticCustomError("step", "{why}", {"why": why})
        return self

    def wraps(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Counts that each sample has lost to wraps since the first one.

        Parameters
        ----------
        counts : ndarray, shape (n,)
            As recorded [1].

        Returns
        -------
        ndarray, shape (n,)
            To be added to the counts [1]; 0 throughout where nothing wraps.
        """
        jumps = np.diff(counts, prepend=counts[:1])
        if self.wraps_at:
            return np.asarray(-self.wraps_at * np.cumsum(np.rint(jumps / self.wraps_at)), dtype=np.float64)
        size = np.abs(jumps)
        low, high = _REGISTERS
        nearest = np.where(size < (low + high) / 2, low, high)
        return -np.cumsum(np.where(size > low / 4, np.sign(jumps) * nearest, 0.0))

    def position(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Way of the carriage since the first sample.

        Parameters
        ----------
        counts : ndarray, shape (n,)
            As recorded [1].

        Returns
        -------
        ndarray, shape (n,)
            Position [m], 0 at the first sample, wraps undone.
        """
        unwrapped = counts + self.wraps(counts)
        return np.asarray(self.step * (unwrapped - unwrapped[0]), dtype=np.float64)


class Clock(Model, family=True):
    """When the samples of a record were taken."""


class EvenSamples(Clock):
    """Samples at a fixed rate."""

    example: ClassVar[Mapping[str, Any]] = {"rate": 1e4}

    rate: Annotated[Number, Quantity("Hz", 1e-3, 1e9, "samples per second")]


class TimeColumn(Clock):
    """Time stamps in a column of their own."""

    example: ClassVar[Mapping[str, Any]] = {"column": 0}

    column: Annotated[str | int, Field(description="name or number of the column")]
    unit: Annotated[str, column_unit("s"), Field(description="unit of the column")] = "s"
    stamps: Annotated[StampTreatment, Field(description="what to do with stamps that do not increase")] = (
        Refuse()
    )


class TribometerChannels(Model):
    """Which columns of a record hold the normal force, the lateral force and the position, and their calibration."""

    example: ClassVar[Mapping[str, Any]] = {
        "normal": {"column": 0, "sensitivity": -0.31},
        "lateral": {"column": 1, "sensitivity": 0.5},
        "encoder": {"column": 2, "step": 1e-6},
        "clock": {"model": "EvenSamples", "rate": 1e4},
    }

    normal: ForceChannel
    lateral: ForceChannel
    encoder: Annotated[
        Encoder | None, Field(description="position of the carriage, where it was recorded")
    ] = None
    clock: Clock
    speed: Annotated[
        Number | None, Quantity("m/s", 0, 10, "sliding speed as set, where there is no encoder to tell it")
    ] = None
    missing_rows: Annotated[
        int, Field(description="largest number of rows with a NaN that may be left out")
    ] = 0

    @model_validator(mode="after")
    def _says_a_speed_once(self) -> Self:
        why = ""
        if self.encoder is not None and self.speed is not None:
            why = "the encoder tells the speed: leave out speed, or the encoder"
        elif not 0 <= self.missing_rows <= 10**9:
            why = f"missing_rows = {self.missing_rows}: expected a number of rows from 0 to 1e9"
        if why:
            raise PydanticCustomError("channels", "{why}", {"why": why})
        return self
