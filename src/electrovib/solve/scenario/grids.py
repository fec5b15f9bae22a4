"""When and over which frequencies a result is wanted, and what came before."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import Drive
from electrovib.solve.transfer import Real


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

    def times(self, drive: Drive) -> Real:
        """Even times over the duration; the stamps of a measured drive unless either is given."""
        if self.duration is None and self.samples is None and drive.time_stamps is not None:
            return drive.time_stamps
        return np.linspace(0.0, self.duration or drive.duration, self.samples or 2001)


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
