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
    """A voltage that stands for a force; a sensor whose voltage falls under load has a negative sensitivity."""

    equation: ClassVar[Mapping[str, str]] = {"force": "sensitivity*(reading - offset)"}
    example: ClassVar[Mapping[str, Any]] = {"column": 0, "sensitivity": 0.5}

    column: Annotated[str | int, Field(description="name or number of the column")]
    sensitivity: Annotated[Number, Quantity("N/V", -1e6, 1e6, "force per volt, negative if load lowers it")]
    offset: Annotated[Number, Quantity("V", -1e3, 1e3, "voltage without force, where it is known")] = 0.0

    @model_validator(mode="after")
    def _measures_something(self) -> Self:
        if self.sensitivity == 0:
            why = "a sensitivity of 0 makes every force 0; for instance '0.31 N/V'"
            raise PydanticCustomError("sensitivity", "{why}", {"why": why})
        return self

    def force(self, reading: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force [N] that a reading [V] stands for; the zero of the sensor is judged later, from the record."""
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
    encoder: Encoder
    clock: Clock
