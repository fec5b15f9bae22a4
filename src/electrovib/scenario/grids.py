"""Output times and frequencies of a result, and the state before time 0."""

from __future__ import annotations

from typing import Annotated, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.arrays import Real
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive

FORMULA_SAMPLES: Final = 2001
"""Number of evenly spaced output times of a drive that is given by a formula, by default."""
ROUNDING: Final = 8 * float(np.finfo(float).eps)
"""Relative difference up to which two times count as one."""


class InitialState(Model, family=True):
    """State before time 0."""


class AtRest(InitialState):
    """No field before time 0, when the drive is switched on."""


class PeriodicState(InitialState):
    """The state in which every period of the drive gives the same response."""


class TimeGrid(Model):
    """Output times of a result."""

    duration: Annotated[
        Number | None, Quantity("s", 1e-9, 1e5, "last output time; the duration of the drive if absent")
    ] = None
    samples: Annotated[int | None, Field(description="number of output times, 2 to 1e8")] = None
    initial_state: InitialState = AtRest()

    @model_validator(mode="after")
    def _enough(self) -> Self:
        if self.samples is not None and not 2 <= self.samples <= 10**8:
            raise ValueError("samples must be a whole number from 2 to 1e8")
        return self

    def count(self, drive: Drive) -> int:
        """Count the output times.

        Parameters
        ----------
        drive : Drive
            Drive of the scenario.

        Returns
        -------
        count : int
            Number of the times that `times` returns, or of a measured drive an upper bound of it.
        """
        if self.samples is not None or drive.time_stamps is None:
            return self.samples or FORMULA_SAMPLES
        return len(drive.time_stamps) + FORMULA_SAMPLES

    def times(self, drive: Drive) -> Real:
        """Return the output times.

        Parameters
        ----------
        drive : Drive
            Drive of the scenario.

        Returns
        -------
        times : ndarray, shape (n,)
            Output times [s], increasing from 0: `samples` evenly spaced times if that is given; else the time stamps of a
            measured drive up to the end, followed by evenly spaced times where the end lies after the record; else 2001
            evenly spaced times.
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
    """Omit time stamps that differ from the one before by rounding only, as those of two records of one clock do."""
    apart = np.diff(stamps, prepend=-np.inf) > ROUNDING * stamps
    return stamps if np.all(apart) else stamps[apart]


class FrequencyGrid(Model):
    """Frequencies of the response; materials are reduced over their band and over the band that the run needs."""

    low: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "lowest frequency")] = 1.0
    high: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "highest frequency")] = 1e6
    samples: Annotated[int, Field(description="number of frequencies, 2 to 1e6")] = 121

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low >= self.high or not 2 <= self.samples <= 10**6:
            raise ValueError("low must be below high, and samples a whole number from 2 to 1e6")
        return self

    def frequencies(self) -> Real:
        """Return the frequencies [Hz], evenly spaced in the logarithm."""
        return np.geomspace(self.low, self.high, self.samples)
