"""Output times and frequencies of a result, and the state before time 0."""

from __future__ import annotations

from typing import Annotated, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.arrays import Real
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.extremes import enough

FORMULA_SAMPLES: Final = 2001
"""Smallest number of output times by default; the duration over 2000 is their largest distance."""
MOST_BY_DEFAULT: Final = 10 * (FORMULA_SAMPLES - 1) + 1
"""Number of output times up to which more are taken by default where fewer do not show the drive."""
ROUNDING: Final = 8 * float(np.finfo(float).eps)
"""Relative difference up to which two times count as one."""
SAME_END: Final = 1e-9
"""Relative difference up to which a duration is the length of a record; its stamps are rounded before the first is taken off."""


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

    @property
    def settled(self) -> bool:
        """Whether the response is that of the periodic state, not from rest."""
        return isinstance(self.initial_state, PeriodicState)

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
        if self.samples is not None:
            return self.samples
        if drive.time_stamps is not None:
            return len(drive.time_stamps) + 2 * FORMULA_SAMPLES
        end = self.duration or drive.duration
        count = enough(drive, 0.0, end, fewest=FORMULA_SAMPLES, most=MOST_BY_DEFAULT)
        return count if count <= MOST_BY_DEFAULT else FORMULA_SAMPLES

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
            measured drive and the end, with the time between two of them divided evenly where the stamps are fewer or farther
            apart than 2001 times; else 2001 evenly spaced times, or up to ten times as many where those do not show the drive.
        """
        end = self.duration or drive.duration
        if self.samples is not None or drive.time_stamps is None:
            return np.linspace(0.0, end, self.count(drive))
        stamps = _apart(drive.time_stamps)
        if end == stamps[-1] and _are_close(stamps):
            return stamps
        inside = stamps[: int(np.searchsorted(stamps, end * (1 + ROUNDING), side="right"))]
        return _divided(inside if end <= inside[-1] * (1 + SAME_END) else np.append(inside, end))


def _are_close(stamps: Real) -> bool:
    """Return whether a record shows the response between its stamps as they are."""
    longest = float(np.max(np.diff(stamps)))
    return longest * (FORMULA_SAMPLES - 1) <= float(stamps[-1] - stamps[0]) * (1 + ROUNDING)


def _divided(times: Real) -> Real:
    """Divide the time between the stamps of a record evenly, so that the response between them is shown; not below rounding."""
    gaps, most = np.diff(times), FORMULA_SAMPLES - 1
    even = np.ceil(gaps * most / (times[-1] - times[0]) * (1 - ROUNDING))
    finest = np.maximum(gaps // (ROUNDING * times[-1]), 1)
    parts = np.minimum(np.maximum(even, most // len(gaps)), finest).astype(int)
    inside = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(np.repeat(times[:-1], parts) + inside * np.repeat(gaps / parts, parts), times[-1])


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
