"""Paths of the finger over a texture."""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.files import UNREAD
from electrovib.core.model import Model
from electrovib.core.quantity import ColumnName, Number, Quantity, column_unit
from electrovib.core.samples import Samples, fault_of_record

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real

_PLACE = Quantity("m", -10, 10, "place on the plate")
_NAME_ONE: Final = 'name the record, for instance file = "path.csv"'
_LONGEST: Final = 3600.0
"""Longest path [s]."""
_FURTHEST: Final = 10.0
"""Largest coordinate of a path [m]."""


class FingerPath(Model, family=True):
    """Position of the finger on the plate over time."""

    checked_elsewhere: ClassVar[frozenset[str]] = frozenset({"positions"})

    @abstractmethod
    def positions(self, time: Real) -> Real:
        """Return the position of the finger.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Time from the beginning of the path [s]; before it and after its end the finger is at its ends.

        Returns
        -------
        position : ndarray, shape (n, 2)
            Position of the finger, x and y [m].
        """

    @property
    @abstractmethod
    def duration(self) -> float:
        """Time from the beginning to the end [s]."""

    @property
    @abstractmethod
    def steady_speed(self) -> float | None:
        """Speed [m/s] where it is constant; else None."""


class ConstantSpeed(FingerPath):
    """A straight stroke along x at constant speed."""

    equation: ClassVar[Mapping[str, str]] = {"positions": "(begin + Max(0, Min(stroke, speed*time)), across)"}
    example: ClassVar[Mapping[str, Any]] = {"speed": 0.03, "stroke": 0.02}

    speed: Annotated[Number, Quantity("m/s", 1e-6, 10, "speed of the finger")]
    stroke: Annotated[Number, Quantity("m", 1e-6, 10, "length of the stroke")]
    begin: Annotated[Number, _PLACE] = 0.0
    across: Annotated[Number, Quantity("m", -10, 10, "place y of the stroke")] = 0.0

    def positions(self, time: Real) -> Real:
        """Return x = begin + speed t and the constant y [m]."""
        x = self.begin + self.speed * np.clip(time, 0.0, self.duration)
        return np.stack([x, np.full(np.shape(x), self.across)], axis=-1)

    @property
    def duration(self) -> float:
        """Length of the stroke over the speed [s]."""
        return self.stroke / self.speed

    @property
    def steady_speed(self) -> float:
        """Speed of the stroke [m/s]."""
        return self.speed


class RecordedPath(FingerPath):
    """A recorded path, linear between its samples."""

    unit_of_columns: ClassVar[str] = "position_unit"
    example: ClassVar[Mapping[str, Any]] = {"time_samples": [0, 0.1, 0.3], "x_samples": [0, 1e-3, 9e-3]}

    file: Annotated[str, Field(description="csv, npy or nc file with the record")] = ""
    time_column: ColumnName = "time"
    time_unit: Annotated[str, column_unit("s"), Field(description="unit of the column")] = "s"
    x_column: ColumnName = "x"
    y_column: Annotated[
        str | int | None, Field(description="name or number of the column, if there is one")
    ] = None
    position_unit: Annotated[str, column_unit("m"), Field(description="unit of x and y")] = "m"
    time_samples: Annotated[Samples, Field(description="time stamps [s], in place of a file")] = Samples([])
    x_samples: Annotated[Samples, Field(description="positions [m], in place of a file")] = Samples([])
    y_samples: Annotated[Samples, Field(description="positions [m], in place of a file")] = Samples([])
    across: Annotated[Number, Quantity("m", -10, 10, "place y, where the record has none")] = 0.0

    @model_validator(mode="after")
    def _is_a_path(self) -> Self:
        columns = {"time": self.time_samples.values, "x": self.x_samples.values}
        if len(self.y_samples):
            columns["y"] = self.y_samples.values
        why = _fault(columns, self.file)
        if why:
            raise ValueError(why)
        return self

    @functools.cached_property
    def _times(self) -> Real:
        stamps = self.time_samples.values
        return np.asarray(stamps - stamps[0])

    def positions(self, time: Real) -> Real:
        """Return the position [m] on straight lines between the samples."""
        x = np.interp(time, self._times, self.x_samples.values)
        if not len(self.y_samples):
            return np.stack([x, np.full(np.shape(x), self.across)], axis=-1)
        return np.stack([x, np.interp(time, self._times, self.y_samples.values)], axis=-1)

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return float(self._times[-1])

    @property
    def steady_speed(self) -> None:
        """None: the speed of a recorded path varies."""


def _fault(columns: Mapping[str, Real], file: str) -> str:
    """Return what is wrong with the columns of a path; empty if nothing is."""
    listed = ", ".join(f"{len(values)} of {name}" for name, values in columns.items())
    differing = f"the columns have different numbers of samples: {listed}"
    missing = UNREAD if file else _NAME_ONE
    why = fault_of_record(columns, missing=missing, differing=differing, needing="a path")
    return why or _out_of_range(columns)


def _out_of_range(columns: Mapping[str, Real]) -> str:
    """Return what is wrong with finite times and places; empty if nothing is."""
    time = columns["time"]
    if np.any(np.diff(time) <= 0):
        first = int(np.argmax(np.diff(time) <= 0)) + 1
        return f"time must increase, but sample {first} ({time[first]:.9g} s) follows {time[first - 1]:.9g} s"
    if time[-1] - time[0] > _LONGEST:
        return f"the path lasts {time[-1] - time[0]:.4g} s, and an hour is allowed; is time_unit right?"
    places = [values for name, values in columns.items() if name != "time"]
    if max(float(np.max(np.abs(values))) for values in places) > _FURTHEST:
        return "positions lie between -10 m and 10 m; is position_unit right?"
    return ""
