"""A drive from a recorded voltage, or from samples that an output holds."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.arrays import Real
from electrovib.core.files import UNREAD
from electrovib.core.model import Model
from electrovib.core.quantity import ColumnName, Number, Quantity, column_unit
from electrovib.core.samples import Samples, fault_of_record
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Linear, even_step
from electrovib.physics.drive.readback import Readback, WholeVoltage

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


_VOLTAGE: Final = Quantity("V", -1e5, 1e5, "voltage of a sample")
_NAME_ONE: Final = 'name the record, for instance file = "record.csv"'
_SHORTEST_STEP: Final = 1e-24
_DURATION: Final = Quantity("s", 1e-9, 1e6, "time from the first sample to the last")


class StampTreatment(Model, family=True):
    """Treatment of time stamps that do not increase."""

    @abstractmethod
    def keep(self, time: Real) -> NDArray[np.bool_]:
        """Tell which samples to keep from their time stamps [s]; raise ValueError to refuse the record."""


class Refuse(StampTreatment):
    """Refuse the record: the default, because a repeated time stamp is usually a fault of the recording."""

    def keep(self, time: Real) -> NDArray[np.bool_]:
        """Keep all samples, or refuse the record at the first time stamp that does not increase."""
        faults = np.flatnonzero(np.diff(time) <= 0) + 1
        if len(faults):
            first = int(faults[0])
            word = "repeats" if time[first] == time[first - 1] else "goes back"
            raise ValueError(
                f"time must increase, but {len(faults)} of {len(time)} time stamps do not: sample {first}"
                f" ({time[first]:.9g} s) {word} after {time[first - 1]:.9g} s. To drop such samples add"
                ' stamps = { model = "KeepIncreasing" } to the drive'
            )
        return np.ones(len(time), bool)


class KeepIncreasing(StampTreatment):
    """Drop every sample whose time stamp is not later than all before it; the first of equal ones is kept.

    Notes
    -----
    Suited to repeated time stamps and short steps back. One time stamp that is far too late drops all samples after
    it; the Trace states how many samples were dropped.
    """

    def keep(self, time: Real) -> NDArray[np.bool_]:
        """Keep the samples that are later than all before them."""
        latest = np.maximum.accumulate(time)
        return np.concatenate([[True], time[1:] > latest[:-1]])


class Sampled(Drive):
    """A recorded voltage, linear between its samples and held after the last one.

    Notes
    -----
    Time counts from the first sample; the voltage before it is 0. Time stamps need not be evenly spaced. A record with
    a NaN is refused with its place, because every later state would be NaN. The record need not be the voltage that
    drives the stack: `readback` states their relation.
    """

    example: ClassVar[Mapping[str, Any]] = {"time_samples": [0, 1e-3, 3e-3], "voltage_samples": [0, 10, 0]}

    file: Annotated[str, Field(description="csv, npy or nc file with the record")] = ""
    time_column: ColumnName = "time"
    time_unit: Annotated[str, column_unit("s"), Field(description="unit of the column")] = "s"
    voltage_column: ColumnName = "voltage"
    voltage_unit: Annotated[str, column_unit("V"), Field(description="unit of the column")] = "V"
    stamps: StampTreatment = Refuse()
    readback: Annotated[Readback, Field(description="relation of the record to the driving voltage")] = (
        WholeVoltage()
    )
    time_samples: Annotated[Samples, Field(description="time stamps [s], in place of a file")] = Samples([])
    voltage_samples: Annotated[Samples, Field(description="voltages [V], in place of a file")] = Samples([])

    @model_validator(mode="after")
    def _is_a_record(self) -> Self:
        time, voltage = self.time_samples.values, self.voltage_samples.values
        _check_numbers(time, voltage, self.file)
        if np.count_nonzero(self.stamps.keep(time)) < 2:
            raise ValueError("fewer than 2 samples are left")
        _check_times(self._pieces.times)
        return self

    @functools.cached_property
    def _pieces(self) -> Linear:
        """Straight pieces between the kept samples, with their time step where it is even."""
        stamps, voltage = self.time_samples.values, self.voltage_samples.values
        kept = self.stamps.keep(stamps)
        if not np.all(kept):
            stamps, voltage = stamps[kept], voltage[kept]
        with np.errstate(over="ignore", invalid="ignore"):  # of impossible times, which are refused
            time = stamps - stamps[0] if stamps[0] else stamps  # no copy of stamps that count from 0
            step = even_step(time, fewest=2, largest=float(np.max(np.abs(stamps[[0, -1]]))))
        after = self.readback.driving(time, voltage)
        before = after  # one array where nothing jumps, not even at time 0
        if after[0]:
            before = after.copy()
            before[0] = 0.0
        for each in (time, before, after):
            each.flags.writeable = False
        return Linear(time, before, after, step=step)

    @property
    def dropped(self) -> int:
        """Number of samples that the treatment of the time stamps drops."""
        return len(self.time_samples) - len(self._pieces.times)

    def parts(self) -> tuple[Linear, ...]:
        """Return the straight pieces between the samples."""
        return (self._pieces,)

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return float(self._pieces.times[-1])

    @property
    def time_stamps(self) -> Real:
        """Times of the samples, counted from the first [s]."""
        return self._pieces.times


def _check_numbers(time: Real, voltage: Real, file: str) -> None:
    """Refuse a record that is not a finite voltage within range at two times or more."""
    differing = f"{len(time)} time stamps but {len(voltage)} voltages"
    columns, missing = {"time": time, "voltage": voltage}, UNREAD if file else _NAME_ONE
    why = fault_of_record(columns, missing=missing, differing=differing, needing="a drive")
    beyond = np.abs(voltage) > _VOLTAGE.high
    if not why and np.any(beyond):
        first = int(np.argmax(beyond))
        why = (
            f"the voltage of sample {first} is {voltage[first]:.9g} V, but a drive lies between {_VOLTAGE.range()};"
            " is voltage_unit right?"
        )
    if why:
        raise ValueError(why)


def _check_times(time: Real) -> None:
    """Refuse a duration or a time step outside the range of recordings, from time stamps counted from the first."""
    if not _DURATION.low <= time[-1] <= _DURATION.high:
        why = f"the record lasts {time[-1]:.4g} s, but a drive lasts between {_DURATION.range()}; is time_unit right?"
        raise ValueError(why)
    shortest = int(np.argmin(np.diff(time)))
    if time[shortest + 1] - time[shortest] < _SHORTEST_STEP:
        why = f"samples {shortest} and {shortest + 1} of those kept are less than {_SHORTEST_STEP:g} s apart; omit one"
        raise ValueError(why)


_ROUNDED: Final = 1e-9
"""Difference over a time that counts as rounding."""


class Held(Drive):
    """A voltage that is held from each sample to the next, with a straight edge between two levels.

    Notes
    -----
    The edge to each level begins at the time stamp of its sample; the first one is from 0 V. `edge` is the height of a step
    over its steepest slope: for one pole at the frequency f that is 1/(2 pi f), and the straight edge then takes up at least
    as much current as that pole, because it keeps the steepest slope for the whole edge. An edge of one interval joins the
    samples by straight lines, one interval later.
    """

    example: ClassVar[Mapping[str, Any]] = {"samples": Sampled.example, "edge": 1e-5}

    samples: Annotated[Sampled, Field(description="the samples, as a table of the drive Sampled")]
    edge: Annotated[
        Number, Quantity("s", 0, 1e3, "height of a step over its steepest slope; 0 for a discontinuity")
    ] = 0.0

    @model_validator(mode="after")
    def _ends_before_the_next(self) -> Self:
        shortest = float(np.min(np.diff(self.samples.time_stamps)))
        if self.edge > shortest * (1 + _ROUNDED):
            raise ValueError(
                f"the edge of {self.edge:.9g} s is longer than the shortest interval between samples, {shortest:.9g} s"
            )
        return self

    @functools.cached_property
    def _pieces(self) -> Linear:
        """Levels and edges, or levels alone where an edge takes no time."""
        (record,) = self.samples.parts()
        time, voltage = record.times, record.after
        last = np.append(0.0, voltage[:-1])
        if self.edge == 0:
            return Linear(time, last, voltage, step=record.step)
        times = np.stack([time, time + self.edge], axis=1).ravel()
        values = np.stack([last, voltage], axis=1).ravel()
        apart = np.append(np.diff(times) > _ROUNDED * self.edge, True)  # one edge ends where the next begins
        times, values = times[apart], values[apart]
        return Linear(times, values, values)

    def parts(self) -> tuple[Linear, ...]:
        """Return the levels and the edges between them."""
        return (self._pieces,)

    @property
    def duration(self) -> float:
        """Time from the first sample to the end of the edge to the last [s]."""
        return float(self._pieces.times[-1])

    @property
    def time_stamps(self) -> Real:
        """Times at which levels begin and edges end, counted from the first sample [s]."""
        return self._pieces.times
