"""Relation of a recorded voltage to the voltage that drives the stack."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Indices, Real


class Readback(Model, family=True):
    """Relation of a recorded voltage to the voltage that drives the stack."""

    @abstractmethod
    def driving(self, time: Real, voltage: Real) -> Real:
        """Return the voltage that drives the stack.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Times [s], increasing, counted from the first sample.
        voltage : ndarray, shape (n,)
            Recorded voltage [V].

        Returns
        -------
        driving_voltage : ndarray, shape (n,)
            Voltage at the same times [V].

        Raises
        ------
        ValueError
            If the record cannot be what it is declared to be.
        """


class WholeVoltage(Readback):
    """The record is the voltage that drives the stack."""

    equation: ClassVar[Mapping[str, str]] = {"driving": "voltage"}

    def driving(self, time: Real, voltage: Real) -> Real:
        """Return the record itself."""
        del time
        return voltage


class OneOfTwoInAntiphase(Readback):
    """The record is the voltage of one of two electrodes in antiphase: while it is at 0, the other is at the supply.

    Notes
    -----
    With v1 + v2 equal to the supply V while the drive is on, the voltage between the electrodes is
    v1 - v2 = 2 v1 - V: it alternates between +V and -V without pauses, and is 0 while the drive is off. Without
    `supply`, V is the sum of the upper and the lower level of the record, so that an offset of the read-back cancels
    and +V and -V are equally large. An edge is assumed to be mirrored on the other electrode, so a slow or poorly
    sampled edge passes through 0. While the first electrode is at 0, the record alone does not show whether the drive
    is on: without `start` and `stop` it counts as on from the first to the last sample at the upper level, and may
    have been on for up to half a period more on either side.
    """

    equation: ClassVar[Mapping[str, str]] = {"driving": "2*voltage - supply if start <= time <= stop else 0"}

    supply: Annotated[
        Number | None, Quantity("V", -1e5, 1e5, "voltage of the supply, determined from the record if absent")
    ] = None
    start: Annotated[
        Number | None,
        Quantity("s", 0, 1e6, "time at which the drive is switched on, counted from the first sample"),
    ] = None
    stop: Annotated[
        Number | None,
        Quantity("s", 0, 1e6, "time at which the drive is switched off, counted from the first sample"),
    ] = None

    @model_validator(mode="after")
    def _is_a_drive(self) -> Self:
        why = ""
        if self.supply == 0:
            why = "a supply of 0 V drives nothing; omit supply to determine it from the record"
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            why = f"start = {self.start:g} s has to lie before stop = {self.stop:g} s"
        if why:
            raise ValueError(why)
        return self

    def driving(self, time: Real, voltage: Real) -> Real:
        """Return 2 v1 - V while the drive is on, and 0 before and after [V].

        A record is refused that is 0 V throughout, that has both signs, which one of two electrodes in
        antiphase has not, or in which the drive is on at no sample.
        """
        upper, lower, high = _levels(voltage)
        first = float(time[high[0]]) if self.start is None else self.start
        last = float(time[high[-1]]) if self.stop is None else self.stop
        on = (time >= first) & (time <= last)
        if not np.any(on):
            why = f"the drive is on at no sample: start and stop are {first:g} and {last:g} s, the record ends at {time[-1]:g} s"
            raise ValueError(why)
        supply = upper + lower if self.supply is None else self.supply
        return np.where(on, 2 * voltage - supply, 0.0)


def _levels(voltage: Real) -> tuple[float, float, Indices]:
    """Return the upper and the lower level of a record [V], and the indices of the samples nearer to the upper one."""
    extreme = float(voltage[np.argmax(np.abs(voltage))])
    if extreme == 0:
        raise ValueError("the record is 0 V throughout, so its electrode is not driven")
    share = voltage / extreme
    if share.min() < -0.1:
        why = (
            f"the record extends from {voltage.min():g} to {voltage.max():g} V, but the voltage of one of two electrodes"
            " driven in antiphase lies between 0 and the supply; for a record of the whole voltage omit readback"
        )
        raise ValueError(why)
    high = share > 0.5
    lower = float(np.median(voltage[~high])) if not np.all(high) else 0.0
    return float(np.median(voltage[high])), lower, np.flatnonzero(high)
