"""When and over which frequencies a result is wanted, and what came before."""

from __future__ import annotations

from typing import Annotated, Final, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.arrays import Real
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive

FORMULA_SAMPLES: Final = 2001
"""Even times at which a drive is looked at that is a formula, if nothing else is said."""
ROUNDING: Final = 8 * float(np.finfo(float).eps)
"""Share of a time by which two times may differ and still be one."""


class InitialState(Model, family=True):
    """What came before time 0."""


class AtRest(InitialState):
    """No field before time 0: the drive is switched on then."""


class PeriodicState(InitialState):
    """The drive has been repeating for ever."""


class TimeGrid(Model):
    """When the result is wanted."""

    duration: Annotated[
        Number | None, Quantity("s", 1e-9, 1e5, "how long; the drive's own length if absent")
    ] = None
    samples: int | None = None
    initial_state: InitialState = AtRest()

    @model_validator(mode="after")
    def _enough(self) -> Self:
        if self.samples is not None and not 2 <= self.samples <= 10**8:
            raise ValueError("samples must be a whole number from 2 to 1e8")
        return self

    def count(self, drive: Drive) -> int:
        """Count the times at which the result is wanted; at most so many where a measured drive has more stamps.

        Parameters
        ----------
        drive : Drive
            Of the scenario.

        Returns
        -------
        int
            As many as `times` gives, or a few more.
        """
        if self.samples is not None or drive.time_stamps is None:
            return self.samples or FORMULA_SAMPLES
        return len(drive.time_stamps) + FORMULA_SAMPLES

    def times(self, drive: Drive) -> Real:
        """Give the times at which the result is wanted [s].

        Parameters
        ----------
        drive : Drive
            Of the scenario.

        Returns
        -------
        ndarray, shape (n,)
            `samples` even times if that is given. Else the stamps of a measured drive, up to the end and, where the
            end comes later than the record, as many even times after it as a formula gets; else 2001 even times.
        """
        end = self.duration or drive.duration
        if self.samples is not None or drive.time_stamps is None:
            return np.linspace(0.0, end, self.samples or FORMULA_SAMPLES)
        stamps = _apart(drive.time_stamps)
        count = int(np.searchsorted(stamps, end * (1 + ROUNDING), side="right"))
        inside = stamps if count == len(stamps) else stamps[:count]
        if end <= inside[-1] * (1 + ROUNDING):
            return inside
        few = len(inside) < len(stamps)  # the next stamp comes after the end
        return np.append(inside, np.linspace(inside[-1], end, 2 if few else FORMULA_SAMPLES)[1:])


def _apart(stamps: Real) -> Real:
    """Leave out stamps that only rounding tells from the one before, as two records of one clock have them."""
    apart = np.diff(stamps, prepend=-np.inf) > ROUNDING * stamps
    return stamps if np.all(apart) else stamps[apart]


class FrequencyGrid(Model):
    """Over which frequencies the response is wanted; materials are reduced over these and over what the run needs."""

    low: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "lowest frequency")] = 1.0
    high: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "highest frequency")] = 1e6
    samples: int = 121

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low >= self.high or not 2 <= self.samples <= 10**6:
            raise ValueError("low must be below high, and samples a whole number from 2 to 1e6")
        return self

    def frequencies(self) -> Real:
        """Evenly spaced in the logarithm."""
        return np.geomspace(self.low, self.high, self.samples)
