"""Linear filter: real poles, conjugate pairs and their gains."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex, Real
from electrovib.core.errors import InputError


@dataclass(frozen=True, eq=False)
class Filter:
    """H(s) = direct + sum gain (-p)/(s - p), with the conjugate of every term whose pole is complex.

    Parameters
    ----------
    poles : ndarray of complex, shape (n,)
        Real poles, and of each pair the one with the positive imaginary part [1/s]; real parts negative.
    gains : ndarray of complex, shape (n,)
        Contribution of each mode to the response at zero frequency; real for a real pole.
    direct : float
        Response at infinite frequency.
    """

    poles: Complex
    gains: Complex
    direct: float = 0.0

    def __post_init__(self) -> None:
        """Refuse poles and gains that the recursion cannot represent."""
        poles, gains = (np.atleast_1d(np.asarray(each, complex)) for each in (self.poles, self.gains))
        if poles.shape != gains.shape or poles.ndim != 1:
            raise InputError(
                f"filter.gains has shape {gains.shape}, expected {poles.shape}: one for each pole."
            )
        if not np.all((poles.real < 0) & (poles.imag >= 0) & np.isfinite(poles) & np.isfinite(gains)):
            raise InputError(
                f"filter.poles = {poles}: real parts must be negative; of a pair give only the pole with the positive"
                " imaginary part."
            )
        if np.any((poles.imag == 0) & (gains.imag != 0)):
            raise InputError(f"filter.gains = {gains}: the gain of a real pole must be real.")
        object.__setattr__(self, "poles", poles)
        object.__setattr__(self, "gains", gains)

    @classmethod
    def through(cls) -> Filter:
        """Return the identity."""
        return cls(np.zeros(0, complex), np.zeros(0, complex), 1.0)

    def value(self, s: ArrayLike) -> Complex:
        """Return the transfer function at any complex s [1/s] that is not a pole."""
        where = np.asarray(s, complex)
        total = np.full(where.shape, self.direct, complex)
        for pole, gain in zip(self.poles, self.gains, strict=True):
            total = total - gain * pole / (where - pole)
            if pole.imag:
                total = total - np.conj(gain * pole) / (where - np.conj(pole))
        return total

    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response at frequencies [Hz], any shape."""
        return self.value(2j * np.pi * np.asarray(frequency, dtype=float))

    def at_rest(self) -> float:
        """Return the response at zero frequency, output per input."""
        return float(self.direct + np.sum(self._weights() * self.gains).real)

    def rate(self) -> Filter:
        """Return the filter of the rate of change of the output, in the unit of the gains per second."""
        if self.direct != 0.0:
            raise InputError(
                f"filter.direct = {self.direct:g}: it must be 0, because the rate of a discontinuous output is not defined."
            )
        gains = self.gains * self.poles
        return Filter(self.poles, gains, -float(np.sum(self._weights() * gains).real))

    def __mul__(self, factor: float) -> Filter:
        """Return the filter with its gains multiplied by a factor."""
        return Filter(self.poles, self.gains * factor, self.direct * factor)

    __rmul__ = __mul__

    def __add__(self, other: Filter) -> Filter:
        """Return the sum of two filters of one input."""
        poles = np.concatenate([self.poles, other.poles])
        return Filter(poles, np.concatenate([self.gains, other.gains]), self.direct + other.direct)

    def state(self, level: float, *, held: float = math.inf) -> Complex:
        """Return the state of the modes after a constant input.

        Returns `state` (n,).
        """
        if math.isinf(held):
            return np.full(len(self.poles), level, complex)
        return np.asarray(-level * np.expm1(self.poles * held))

    def _weights(self) -> Real:
        return np.where(self.poles.imag == 0, 1.0, 2.0)
