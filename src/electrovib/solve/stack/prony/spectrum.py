"""The spectrum to be reduced, and the Debye terms of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Complex, Real


class Terms(NamedTuple):
    """Debye terms as arrays, sorted from fast to slow."""

    high: float
    strengths: Real
    times: Real


@dataclass(frozen=True, kw_only=True)
class Spectrum:
    """Samples of a bound permittivity, and the range allowed for relaxation times.

    Parameters
    ----------
    angular : ndarray, shape (N,)
        Angular frequencies, rising [rad/s].
    target : ndarray of complex, shape (N,)
        Relative permittivity without conduction [1].
    fastest, slowest : float
        Limits of the relaxation times, 0 < fastest < slowest [s].
    """

    angular: Real
    target: Complex
    fastest: float
    slowest: float

    def grid_limits(self) -> tuple[float, float]:
        """Return the range of initial relaxation times: one decade beyond the band, within the limits [s]."""
        first, last = 0.1 / self.angular[-1], 10 / self.angular[0]
        # Just inside the limits, at which the map of polish.py has a slope of 0.
        return max(float(first), 1.01 * self.fastest), min(float(last), self.slowest / 1.01)

    def smallest(self) -> float:
        """Return the smallest modulus of the permittivity in the band."""
        return float(np.abs(self.target).min())

    def relative_error(self, terms: Terms) -> Complex:
        """Return fit/target - 1 at the samples, shape (N,)."""
        response = terms.high + debye_responses(self.angular, terms.times) @ terms.strengths
        return np.asarray(response / self.target - 1)


def debye_responses(angular: Real, times: Real) -> Complex:
    """Return 1/(1 + j w tau).

    `angular`, `times` (N,) [rad/s]; returns `responses` (N, M).
    """
    return np.asarray(1 / (1 + 1j * angular[:, np.newaxis] * times))


def stacked(values: Complex) -> Real:
    """Return real parts followed by imaginary parts [same unit], shape (2N, ...)."""
    return np.concatenate([values.real, values.imag])
