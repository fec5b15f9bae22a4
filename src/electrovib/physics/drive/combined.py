"""Drives made of other drives: a sum, and a DC offset."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import lcm
from typing import Annotated, Any, ClassVar

import numpy as np

from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.parts import Linear, Part


class Offset(Drive):
    """Another drive on top of a constant voltage."""

    example: ClassVar[Mapping[str, Any]] = {
        "drive": {"model": "Sine", "amplitude": 50, "frequency": 125},
        "level": 100,
    }

    drive: Drive
    level: Annotated[Number, Quantity("V", -1e5, 1e5, "constant voltage added")]

    def parts(self) -> tuple[Part, ...]:
        """Give the drive's parts and a step at time 0."""
        step = Linear(np.zeros(1), np.zeros(1), np.array([self.level]), None)
        return (*self.drive.parts(), step)

    @property
    def period(self) -> float | None:
        """The period of the drive."""
        return self.drive.period

    @property
    def duration(self) -> float:
        """The duration of the drive."""
        return self.drive.duration


class Sum(Drive):
    """Several drives added."""

    example: ClassVar[Mapping[str, Any]] = {
        "drives": [
            {"model": "Sine", "amplitude": 50, "frequency": 100},
            {"model": "Sine", "amplitude": 20, "frequency": 250},
        ]
    }

    drives: tuple[Drive, ...]

    def parts(self) -> tuple[Part, ...]:
        """Give the parts of all."""
        return tuple(part for drive in self.drives for part in drive.parts())

    @property
    def period(self) -> float | None:
        """Shortest time that holds a whole number of periods of each."""
        found = [drive.period for drive in self.drives]
        periods = [period for period in found if period is not None]
        if len(periods) < len(found) or not periods:
            return None
        ratios = [Fraction(period / periods[0]).limit_denominator(1000) for period in periods]
        if any(abs(float(r) * periods[0] / p - 1) > 1e-12 for r, p in zip(ratios, periods, strict=True)):
            return None
        common = lcm(*(ratio.denominator for ratio in ratios))
        return periods[0] * lcm(*(int(ratio * common) for ratio in ratios)) / common

    @property
    def duration(self) -> float:
        """The longest of them."""
        return max(drive.duration for drive in self.drives)
