"""Calibration of the channels of a tribometer: sensitivities, signs and encoder counts."""

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

    column: Annotated[str | int, Field(description="name or number of the column")]
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
            raise PydanticCustomError("sensitivity", "{why}", {"why": why})
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

    column: Annotated[str | int, Field(description="name or number of the column")]
    step: Annotated[Number, Quantity("m", -1.0, 1.0, "distance per count, negative if it counts backwards")]
    wraps_at: Annotated[
        Number,
        Quantity("1", 0, 2.0**53, "counts at which the register wraps; 0 to determine it from the record"),
    ] = 0.0

    @model_validator(mode="after")
    def _counts_something(self) -> Self:
        if self.step == 0:
            why = "a step of 0 makes every position 0; give for instance '0.5 um'"
            raise PydanticCustomError("step", "{why}", {"why": why})
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

    column: Annotated[str | int, Field(description="name or number of the column")]
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
            raise PydanticCustomError("channels", "{why}", {"why": why})
        return self
