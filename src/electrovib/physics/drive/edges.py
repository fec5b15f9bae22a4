"""Drives made of straight pieces: step, square wave, pulse train, trapezoidal pulse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.levels import Levels
from electrovib.physics.drive.parts import Linear

if TYPE_CHECKING:
    from collections.abc import Mapping

_HIGH = Quantity("V", -1e5, 1e5, "high level")
_LOW = Quantity("V", -1e5, 1e5, "low level")
_EDGE = Quantity("s", 0, 1e3, "duration of an edge; 0 for a step")
_TRAIN = (
    "low + (high - low)*elapsed/edge if elapsed < edge"
    " else high if edge <= elapsed < width"
    " else high - (high - low)*(elapsed - width)/edge if width <= elapsed < width + edge"
    " else low"
)
_ROUNDED = 1 - 1e-12
"""Share of a period above which a time counts as the period, because sums of times are rounded."""


def _within(time: float, end: float) -> float:
    """Return the time, or the end where they differ by rounding only."""
    return end if time > end * _ROUNDED else time


def _pieces(points: list[tuple[float, float]], period: float | None = None) -> Linear:
    """Join points (time, voltage) by straight pieces; two points at one time are a step."""
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

    equation: ClassVar[Mapping[str, str]] = {"voltage": "level"}
    example: ClassVar[Mapping[str, Any]] = {"level": 100}

    level: Annotated[Number, Quantity("V", -1e5, 1e5, "constant voltage from time 0 on")]

    def parts(self) -> tuple[Linear, ...]:
        """Return one piece."""
        return (_pieces([(0.0, self.level)]),)

    @property
    def duration(self) -> float:
        """0.1 s, long compared with the charge relaxation of a finger."""
        return 0.1


class Trapezium(Levels):
    """A trapezoidal pulse: a ramp up, a hold and a ramp down, once or repeated with a period."""

    equation: ClassVar[Mapping[str, str]] = {
        "elapsed": "time if repeat is None else time % repeat",
        "top": "delay + rise",
        "end": "delay + rise + hold",
        "voltage": (
            "low if elapsed < delay"
            " else low + (high - low)*(elapsed - delay)/rise if delay <= elapsed < top"
            " else high if top <= elapsed < end"
            " else high - (high - low)*(elapsed - end)/fall if end <= elapsed < end + fall"
            " else low"
        ),
    }
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
            raise ValueError(why)
        return self

    def parts(self) -> tuple[Linear, ...]:
        """Return the straight pieces of the pulse."""
        ends = np.cumsum([self.delay, self.rise, self.hold, self.fall]).tolist()
        voltages = [self.low, self.high, self.high, self.low]
        points = [(0.0, self.low), *zip(ends, voltages, strict=True)]
        if self.repeat is None:
            return (_pieces(points),)
        points = [(_within(time, self.repeat), voltage) for time, voltage in points]
        return (_pieces([*points, (self.repeat, self.low)], self.repeat),)

    @property
    def period(self) -> float | None:
        """Period given as `repeat` [s]; None for a single pulse."""
        return self.repeat

    @property
    def duration(self) -> float:
        """The period, or for a single pulse its length and once more its hold [s]."""
        return self.repeat or self.delay + self.rise + 2 * self.hold + self.fall


class Square(Levels):
    """A square wave: a voltage that alternates between two levels, half a period each."""

    equation: ClassVar[Mapping[str, str]] = {
        "elapsed": "time % (1/frequency)",
        "width": "1/(2*frequency)",
        "voltage": _TRAIN,
    }
    example: ClassVar[Mapping[str, Any]] = {"high": 100, "low": -100, "frequency": 60}

    high: Annotated[Number, _HIGH]
    low: Annotated[Number, _LOW] = 0.0
    frequency: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "repetition frequency")]
    edge: Annotated[Number, _EDGE] = 0.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.edge * _ROUNDED > 0.5 / self.frequency:
            why = f"edge must fit in half a period, {0.5 / self.frequency:g} s"
            raise ValueError(why)
        return self

    def parts(self) -> tuple[Linear, ...]:
        """Return the straight pieces of one period, which begins with the rising edge."""
        return (_train(self.low, self.high, 0.5 / self.frequency, 1 / self.frequency, self.edge),)

    @property
    def period(self) -> float:
        """Reciprocal of the frequency [s]."""
        return 1 / self.frequency


class PulseTrain(Levels):
    """A pulse train: pulses of one width, repeated with a period."""

    equation: ClassVar[Mapping[str, str]] = {
        "elapsed": "time % (1/frequency)",
        "voltage": _TRAIN,
    }
    example: ClassVar[Mapping[str, Any]] = {"high": 100, "width": 1e-3, "frequency": 60}

    high: Annotated[Number, _HIGH]
    low: Annotated[Number, _LOW] = 0.0
    width: Annotated[
        Number, Quantity("s", 1e-9, 1e3, "time from the beginning of the rise to that of the fall")
    ]
    frequency: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "repetition frequency")]
    edge: Annotated[Number, _EDGE] = 0.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.edge > self.width or (self.width + self.edge) * _ROUNDED > 1 / self.frequency:
            why = f"edge <= width and width + edge <= period = {1 / self.frequency:g} s are needed"
            raise ValueError(why)
        return self

    def parts(self) -> tuple[Linear, ...]:
        """Return the straight pieces of one period, which begins with the rising edge."""
        return (_train(self.low, self.high, self.width, 1 / self.frequency, self.edge),)

    @property
    def period(self) -> float:
        """Reciprocal of the frequency [s]."""
        return 1 / self.frequency


def _train(low: float, high: float, width: float, period: float, edge: float) -> Linear:
    width, end = _within(width, period), _within(width + edge, period)
    points = [(0.0, low), (_within(edge, width), high), (width, high), (end, low), (period, low)]
    if edge == 0:
        points[0] = (0.0, high)
    return _pieces(points, period)
