"""Drives made of straight pieces: constant, square, pulse train, trapezoidal pulse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.levels import Levels
from electrovib.physics.drive.pieces import Linear

if TYPE_CHECKING:
    from collections.abc import Mapping

_VOLTAGE = Quantity("V", -1e5, 1e5, "voltage")
_EDGE = Quantity("s", 0, 1e3, "time an edge takes; 0 for a jump")
_ROUNDED = 1 - 1e-12
"""Times that add up to a period may miss it by rounding."""


def _within(time: float, end: float) -> float:
    """Give the time, or the end if it comes that close."""
    return end if time > end * _ROUNDED else time


def _pieces(points: list[tuple[float, float]], period: float | None = None) -> Linear:
    """Join points (time, voltage); two points at one time are a jump."""
    merged: list[list[float]] = []
    for time, voltage in points:
        if merged and time == merged[-1][0]:
            merged[-1][2] = voltage
        else:
            merged.append([time, voltage, voltage])
    times, before, after = (np.array(column) for column in zip(*merged, strict=True))
    if period is None:
        before[0] = 0.0  # off before it begins
    return Linear(times, before, after, period)


class Step(Drive):
    """A voltage switched on at time 0 and held."""

    former_names: ClassVar[tuple[str, ...]] = ("Constant",)
    example: ClassVar[Mapping[str, Any]] = {"level": 100}

    level: Annotated[Number, Quantity("V", -1e5, 1e5, "voltage held")]

    def parts(self) -> tuple[Linear, ...]:
        """Give one piece."""
        return (_pieces([(0.0, self.level)]),)

    @property
    def period(self) -> None:
        """A step has no period of its own."""

    @property
    def duration(self) -> float:
        """Long against the decay of a finger."""
        return 0.1


class Trapezium(Levels):
    """A ramp up, a hold, a ramp down: once, or repeated when a period is given."""

    example: ClassVar[Mapping[str, Any]] = {"high": 1000, "rise": 36e-3, "hold": 0.1, "fall": 36e-3}

    low: Annotated[Number, Quantity("V", -1e5, 1e5, "voltage before and after")] = 0.0
    high: Annotated[Number, Quantity("V", -1e5, 1e5, "voltage of the hold")]
    delay: Annotated[Number, Quantity("s", 0, 1e3, "time before the rise")] = 0.0
    rise: Annotated[Number, _EDGE]
    hold: Annotated[Number, Quantity("s", 0, 1e3, "time at the high voltage")]
    fall: Annotated[Number, _EDGE]
    repeat: Annotated[Number | None, Quantity("s", 1e-9, 1e4, "period, if the trapezoidal pulse repeats")] = (
        None
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        length = self.delay + self.rise + self.hold + self.fall
        if self.repeat is not None and self.repeat < length * _ROUNDED:
            why = f"repeat must be at least delay + rise + hold + fall = {length:g} s"
            raise PydanticCustomError("period", "{why}", {"why": why})
        return self

    def parts(self) -> tuple[Linear, ...]:
        """Give the corners."""
        ends = np.cumsum([self.delay, self.rise, self.hold, self.fall]).tolist()
        voltages = [self.low, self.high, self.high, self.low]
        points = [(0.0, self.low), *zip(ends, voltages, strict=True)]
        if self.repeat is None:
            return (_pieces(points),)
        points = [(_within(time, self.repeat), voltage) for time, voltage in points]
        return (_pieces([*points, (self.repeat, self.low)], self.repeat),)

    @property
    def period(self) -> float | None:
        """The time given as `repeat`."""
        return self.repeat

    @property
    def duration(self) -> float:
        """One trapezoidal pulse and as long again after it as its hold, or one period."""
        return self.repeat or self.delay + self.rise + 2 * self.hold + self.fall


class Square(Levels):
    """A voltage that alternates between two levels, half a period each."""

    example: ClassVar[Mapping[str, Any]] = {"high": 100, "low": -100, "frequency": 60}

    high: Annotated[Number, _VOLTAGE]
    low: Annotated[Number, _VOLTAGE] = 0.0
    frequency: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "repetition frequency")]
    edge: Annotated[Number, _EDGE] = 0.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.edge * _ROUNDED > 0.5 / self.frequency:
            why = f"edge must fit in half a period, {0.5 / self.frequency:g} s"
            raise PydanticCustomError("edge", "{why}", {"why": why})
        return self

    def parts(self) -> tuple[Linear, ...]:
        """Give the corners of one period, which begins with the rising edge."""
        return (_train(self.low, self.high, 0.5 / self.frequency, 1 / self.frequency, self.edge),)

    @property
    def period(self) -> float:
        """One over the frequency."""
        return 1 / self.frequency

    @property
    def duration(self) -> float:
        """Five periods."""
        return 5 / self.frequency


class PulseTrain(Levels):
    """Pulses of one width, repeated."""

    example: ClassVar[Mapping[str, Any]] = {"high": 100, "width": 1e-3, "frequency": 60}

    high: Annotated[Number, _VOLTAGE]
    low: Annotated[Number, _VOLTAGE] = 0.0
    width: Annotated[Number, Quantity("s", 1e-9, 1e3, "from the beginning of the rise to that of the fall")]
    frequency: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "repetition frequency")]
    edge: Annotated[Number, _EDGE] = 0.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.edge > self.width or (self.width + self.edge) * _ROUNDED > 1 / self.frequency:
            why = f"edge <= width and width + edge <= period = {1 / self.frequency:g} s are needed"
            raise PydanticCustomError("width", "{why}", {"why": why})
        return self

    def parts(self) -> tuple[Linear, ...]:
        """Give the corners of one period, which begins with the rising edge."""
        return (_train(self.low, self.high, self.width, 1 / self.frequency, self.edge),)

    @property
    def period(self) -> float:
        """One over the frequency."""
        return 1 / self.frequency

    @property
    def duration(self) -> float:
        """Five periods."""
        return 5 / self.frequency


def _train(low: float, high: float, width: float, period: float, edge: float) -> Linear:
    width, end = _within(width, period), _within(width + edge, period)
    points = [(0.0, low), (_within(edge, width), high), (width, high), (end, low), (period, low)]
    if edge == 0:
        points[0] = (0.0, high)
    return _pieces(points, period)
