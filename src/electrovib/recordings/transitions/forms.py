"""Forms of a relaxation that are fitted to an edge, seen directly or through a resonant sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.relaxation import (
    stretched_exponential,
    stretched_seen_by_sensor,
    time_of_progress,
)
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.recordings.transitions.sensor import INSTANT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real


@dataclass(frozen=True)
class RelaxationForm:
    """One form of a relaxation after a delay: its number of time constants, 0 for an instantaneous change."""

    name: str
    exponentials: int
    stretched: bool = False

    @property
    def time_constants(self) -> tuple[str, ...]:
        """Names of the time constants."""
        if self.exponentials == 1:
            return ("time_constant",)
        return tuple(f"time_constant_{number}" for number in range(1, self.exponentials + 1))

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """Names of the amplitudes of the columns: those of the relaxations, and the level after them."""
        count = max(self.exponentials, 1)
        changes = ("change",) if count == 1 else tuple(f"change_{number}" for number in range(1, count + 1))
        return (*changes, "after")

    def columns(self, time: Real, values: Mapping[str, float], sensor: tuple[float, float] | None) -> Real:
        """Compute what the amplitudes multiply, shape (n, k): relaxations from 1 to 0, and a column of ones."""
        start = values["start"]
        if self.stretched:
            shape = {"time_constant": values["time_constant"], "stretching": values["stretching"]}
            if sensor is None:
                found = [stretched_exponential(time - start, **shape)]
            else:
                found = [
                    stretched_seen_by_sensor(time - start, frequency=sensor[0], quality=sensor[1], **shape)
                ]
        else:
            falls = [values[name] for name in self.time_constants] or [0.0]
            found = [_exponential(time, start, fall, sensor) for fall in falls]
        return np.column_stack([*found, np.ones_like(time)])

    def time_between(self, values: Mapping[str, float], fractions: tuple[float, float]) -> float:
        """Compute the time between two fractions of the change of the force."""
        if not self.exponentials:
            return 0.0
        if self.exponentials == 1:
            shape = {"time_constant": values["time_constant"], "stretching": values.get("stretching", 1.0)}
            return time_of_progress(fractions[1], **shape) - time_of_progress(fractions[0], **shape)
        falls = np.array([values[name] for name in self.time_constants])
        shares = np.array([values[name] for name in self.amplitudes[:-1]])
        shares = shares / shares.sum()
        return _passage(fractions[1], shares, falls) - _passage(fractions[0], shares, falls)


INSTANTANEOUS: Final = RelaxationForm("instantaneous", 0)
EXPONENTIAL: Final = RelaxationForm("exponential", 1)
STRETCHED: Final = RelaxationForm("stretched exponential", 1, stretched=True)


def forms(most: int, *, sensor: bool) -> tuple[RelaxationForm, ...]:
    """List the forms that are compared, by their number of parameters; only a sensor gives an instantaneous change a form."""
    sums = tuple(RelaxationForm(f"{count} exponentials", count) for count in range(2, most + 1))
    return (*((INSTANTANEOUS,) if sensor else ()), EXPONENTIAL, STRETCHED, *sums)


def _exponential(time: Real, start: float, fall: float, sensor: tuple[float, float] | None) -> Real:
    if sensor is None:
        return np.asarray(np.exp(-np.maximum(time - start, 0.0) / fall))
    frequency, quality = sensor
    return release_seen_by_sensor(
        time, start=start, fall_time=max(fall, INSTANT / frequency), frequency=frequency, quality=quality
    )


def _passage(progress: float, shares: Real, falls: Real) -> float:
    """Return the time at which a sum of exponentials has made a fraction of its change; NaN if it has not one such time."""
    from scipy.optimize import brentq

    if (shares < 0).any():
        return math.nan
    longest = float(falls.max()) * -math.log1p(-progress)
    if longest == 0:
        return 0.0
    return float(brentq(lambda at: shares @ np.exp(-at / falls) - (1 - progress), 0.0, longest * (1 + 1e-12)))
