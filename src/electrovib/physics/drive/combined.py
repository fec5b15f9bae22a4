"""Drives made of other drives: a sum, and a DC offset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.arrays import Real
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive, common_period
from electrovib.physics.drive.parts import Linear, Part

if TYPE_CHECKING:
    from collections.abc import Mapping


class Offset(Drive):
    """A drive with a constant voltage added from time 0 on."""

    equation: ClassVar[Mapping[str, str]] = {"voltage": "drive.voltage(time) + level"}
    example: ClassVar[Mapping[str, Any]] = {
        "drive": {"model": "Sine", "amplitude": 50, "frequency": 125},
        "level": 100,
    }

    drive: Drive
    level: Annotated[Number, Quantity("V", -1e5, 1e5, "constant voltage added")]

    def parts(self) -> tuple[Part, ...]:
        """Return the drive's parts and a step at time 0."""
        step = Linear(np.zeros(1), np.zeros(1), np.array([self.level]), None)
        return (*self.drive.parts(), step)

    @property
    def period(self) -> float | None:
        """Period of the drive [s]."""
        return self.drive.period

    @property
    def duration(self) -> float:
        """Duration of the drive [s]."""
        return self.drive.duration

    @property
    def time_stamps(self) -> Real | None:
        """Times at which the drive was measured [s]; None for a formula."""
        return self.drive.time_stamps


class Sum(Drive):
    """A sum of drives."""

    equation: ClassVar[Mapping[str, str]] = {"voltage": "sum(drive.voltage(time) for drive in drives)"}
    example: ClassVar[Mapping[str, Any]] = {
        "drives": [
            {"model": "Sine", "amplitude": 50, "frequency": 100},
            {"model": "Sine", "amplitude": 20, "frequency": 250},
        ]
    }

    drives: Annotated[tuple[Drive, ...], Field(description="drives that are added, at least one")]

    @model_validator(mode="after")
    def _has_drives(self) -> Self:
        if not self.drives:
            raise ValueError("a sum needs at least one drive")
        return self

    def parts(self) -> tuple[Part, ...]:
        """Return the parts of all drives."""
        return tuple(part for drive in self.drives for part in drive.parts())

    @property
    def period(self) -> float | None:
        """Common period of the drives that are not constant [s]; None where there is none."""
        moving = [drive for drive in self.drives if not all(part.is_step for part in drive.parts())]
        periods = [drive.period for drive in moving]
        known = [period for period in periods if period is not None]
        return common_period(known) if len(known) == len(periods) else None

    @property
    def duration(self) -> float:
        """Longest duration of the drives [s]."""
        return max(drive.duration for drive in self.drives)

    @property
    def time_stamps(self) -> Real | None:
        """Times at which any of the drives was measured [s]; None if all are formulas."""
        found = [stamps for drive in self.drives if (stamps := drive.time_stamps) is not None]
        return np.unique(np.concatenate(found)) if found else None
