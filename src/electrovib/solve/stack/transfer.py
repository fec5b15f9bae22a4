"""Transfer function from the drive to a linear quantity, with real poles, and its integral over time as a mode."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex, Real

if TYPE_CHECKING:
    pass

INTEGRATING: Final = 1e-30
"""Rate that represents an integrator [1/s]: its decay in 1e5 s is far below the rounding of 53 bits."""
_NOTHING = 1e-13
"""Response at zero frequency over the largest mode, below which it is the rounding of the sum of modes."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Transfer:
    """H(s) = slope s + direct + sum gain rate/(s + rate), and a free part sum free exp(-rate t).

    Parameters
    ----------
    rates : ndarray, shape (n,)
        Minus the poles, >= 0 [1/s]; a rate of 0 is trapped charge, which the drive does not excite.
    gains : ndarray, shape (n,)
        Contribution of each mode to the response at zero frequency.
    direct : float
        Response at infinite frequency.
    slope : float
        Response to the rate of change of the drive.
    free : ndarray, shape (n,), optional
        Amplitudes at time 0 of the response to initial charge.
    static : float, optional
        Response at zero frequency, where the sum of `direct` and `gains` would lose it by cancellation, as for a current.

    Notes
    -----
    With `static` the transfer function is static + slope s - sum gain s/(s + rate), which loses no digits at low
    frequency.
    Without a free part it is a filter; two transfer functions can be multiplied when at most one has a free part or a
    slope, and they have no rate in common.
    """

    rates: Real
    gains: Real
    direct: float = 0.0
    slope: float = 0.0
    free: Real = field(default_factory=lambda: np.zeros(0))
    static: float | None = None

    def __post_init__(self) -> None:
        """Replace an absent free part by zeros."""
        if len(self.free) != len(self.rates):
            object.__setattr__(self, "free", np.zeros(len(self.rates)))

    def at(self, frequency: ArrayLike) -> Complex:
        """Evaluate the forced part at frequencies [Hz], any shape."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)
        level = self.direct if self.static is None else self.static
        driven = self.gains != 0
        rates, gains = self.rates[driven], self.gains[driven]
        parts = (rates if self.static is None else -s[..., None]) / (s[..., None] + rates)
        summed = np.sum(parts * gains, axis=-1)  # a matrix product would start threads, which take longer
        return np.asarray(level + self.slope * s + summed, dtype=complex)

    def free_at(self, frequency: ArrayLike) -> Complex:
        """Evaluate the Laplace transform of the free part at j w, frequencies [Hz] above 0, any shape."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)
        return np.asarray(1 / (s[..., None] + self.rates) @ self.free, dtype=complex)

    def at_rest(self) -> float:
        """Return the response at zero frequency."""
        return float(self.direct + self.gains.sum()) if self.static is None else self.static

    def __add__(self, other: Transfer) -> Transfer:
        """Return the sum; transfer functions of one stack keep their common modes."""
        if self.rates is other.rates or np.array_equal(self.rates, other.rates):
            gains, free, rates = self.gains + other.gains, self.free + other.free, self.rates
        else:
            rates = np.concatenate([self.rates, other.rates])
            gains = np.concatenate([self.gains, other.gains])
            free = np.concatenate([self.free, other.free])
        apart = self.static is None and other.static is None
        static = None if apart else self.at_rest() + other.at_rest()
        return Transfer(
            rates=rates,
            gains=gains,
            direct=self.direct + other.direct,
            slope=self.slope + other.slope,
            free=free,
            static=static,
        )

    def __sub__(self, other: Transfer) -> Transfer:
        """Return the difference."""
        return self + other * -1.0

    def __mul__(self, other: Transfer | float) -> Transfer:
        """Return the product with a factor, or with another transfer function."""
        if isinstance(other, Transfer):
            return _product(self, other)
        factor = float(other)
        return Transfer(
            rates=self.rates,
            gains=self.gains * factor,
            direct=self.direct * factor,
            slope=self.slope * factor,
            free=self.free * factor,
            static=None if self.static is None else self.static * factor,
        )

    __rmul__ = __mul__


def _product(filter_: Transfer, signal: Transfer) -> Transfer:
    """Return the product by partial fractions: each residue of one times the value of the other at that pole."""
    if filter_.slope or np.any(filter_.free):
        filter_, signal = signal, filter_
    if filter_.slope or signal.slope or np.any(filter_.free):
        raise ValueError("only one factor may have a free part, and none a slope")
    if not len(filter_.rates):
        return signal * filter_.direct
    known = filter_.static is not None or signal.static is not None
    apart = filter_.rates[:, None] - signal.rates[None, :]  # filter rate minus signal rate
    of_filter = filter_.direct + np.sum((filter_.gains * filter_.rates)[:, None] / apart, axis=0)
    of_signal = signal.direct - np.sum((signal.gains * signal.rates)[None, :] / apart, axis=1)
    free_here = signal.free * of_filter
    weights = filter_.gains * filter_.rates
    free_there = -weights * np.sum(signal.free[None, :] / apart, axis=1)
    return Transfer(
        rates=np.concatenate([signal.rates, filter_.rates]),
        gains=np.concatenate([signal.gains * of_filter, filter_.gains * of_signal]),
        direct=filter_.direct * signal.direct,
        slope=0.0,
        free=np.concatenate([free_here, free_there]),
        static=filter_.at_rest() * signal.at_rest() if known else None,
    )


def integrated(rate: Transfer, *, start: float = 0.0) -> Transfer:
    """Return the integral over time of a linear quantity, for instance the charge delivered by a current.

    H = static + slope s - sum gain s/(s + rate) gives H/s = static/s + slope - sum gain/(s + rate).
    """
    rates, safe = rate.rates, np.where(rate.rates > 0, rate.rates, 1.0)
    static = resting(rate)
    gains, free = -rate.gains / safe, -rate.free / safe
    constant = start - float(np.sum(free))
    if static:
        rates, gains = np.append(rates, INTEGRATING), np.append(gains, static / INTEGRATING)
        free = np.append(free, 0.0)
    if constant:
        rates, gains = np.append(rates, 0.0), np.append(gains, 0.0)
        free = np.append(free, constant)
    return Transfer(rates=rates, gains=gains, direct=rate.slope, slope=0.0, free=free)


def resting(transfer: Transfer) -> float:
    """Return the response at zero frequency, 0 where it is only the rounding of the sum of modes."""
    if transfer.static is not None:
        return transfer.static
    level = transfer.at_rest()
    largest = max(abs(transfer.direct), float(np.max(np.abs(transfer.gains), initial=0.0)))
    return level if abs(level) > _NOTHING * largest else 0.0


def without_integrators(transfer: Transfer) -> Transfer:
    """Return the transfer function without the modes that integrate the drive."""
    return replace(transfer, gains=np.where(transfer.rates == INTEGRATING, 0.0, transfer.gains))


def integral_weight(transfer: Transfer) -> float:
    """Return the factor of the drive's integral over time in a quantity [its unit per unit of the drive and s]."""
    return float(np.sum((transfer.gains * transfer.rates)[transfer.rates == INTEGRATING]))
