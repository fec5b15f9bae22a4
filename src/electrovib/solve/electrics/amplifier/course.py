"""The plate's voltage as a sum of exponentials, and the response of relaxations to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.electrics.straight import chunks

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


_SAME_RATE = 1e-8
"""Relative difference below which two rates count as equal."""


def risen(rates: Real, time: Real) -> Real:
    """Compute the integral of exp(-rate t) from 0 to each time.

    `rates` (m,), `time` (times,) [s]; returns `integral` (m, times) [s].
    """
    return overlap(rates, np.zeros(1), time)[:, 0]


def _apart_from(rates: Real, fading: Real) -> Real:
    """Return rates moved slightly away from equal rates of another set; t exp(-rate t) is then exact to about 1e-8."""
    near = np.abs(rates[:, None] - fading) <= _SAME_RATE * fading
    positive = rates[rates > 0]
    step = np.where(fading > 0, fading, np.min(positive) if len(positive) else 1.0)
    return np.where(np.any(near, axis=0), fading + 2 * _SAME_RATE * step, fading)


def overlap(first: Real, second: Real, time: Real) -> Real:
    """Compute the integral over s from 0 to t of exp(-first (t - s)) exp(-second s), without cancellation.

    `first`, `second` (m,), `time` (times,) [s]; returns `integral` (m, n, times) [s].
    """
    slower = np.minimum(first[:, None], second)[..., None]
    apart = np.abs(first[:, None] - second)[..., None] * time
    share = np.ones_like(apart)
    np.divide(-np.expm1(-apart), apart, out=share, where=apart > 0)
    return np.asarray(time * np.exp(-slower * time) * share)


@dataclass(frozen=True, eq=False)
class Course:
    """Voltage of the plate from some time on: sum of level exp(-rate t) + slope (1 - exp(-rate t))/rate.

    Parameters
    ----------
    rates, levels, slopes : ndarray, shape (n,)
        Rates [1/s], >= 0; levels [V]; slopes [V/s].
    """

    rates: Real
    levels: Real
    slopes: Real

    def voltage(self, time: Real) -> Real:
        """Return the voltage [V] at times since the beginning [s]."""
        falling = np.exp(-np.outer(self.rates, time))
        return np.asarray(self.levels @ falling + self.slopes @ risen(self.rates, time))

    def slope(self, time: Real) -> Real:
        """Return the rate of change [V/s] at times since the beginning [s]."""
        return np.asarray((self.slopes - self.rates * self.levels) @ np.exp(-np.outer(self.rates, time)))

    def answer(self, rates: Real, state: Real, time: Real) -> Real:
        """Compute the states x of x' = rate (v - x) under this voltage v.

        `rates`, `state` (m,) [V], `time` (times,) [s]; returns `states` (m, times) [V].
        """
        found = state[:, None] * np.exp(-np.outer(rates, time))
        for piece in chunks(len(time), len(rates) * len(self.rates) + 1):
            some = time[piece]
            shared = overlap(rates, self.rates, some)
            found[:, piece] += np.einsum("n,mnt->mt", self.levels, shared) * rates[:, None]
            found[:, piece] += self.slopes @ risen(self.rates, some)
            found[:, piece] -= np.einsum("n,mnt->mt", self.slopes, shared)
        return np.asarray(found)
