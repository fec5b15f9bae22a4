"""Transfer functions from the drive to a linear quantity, with real poles, and their integral over time as a mode."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex, Real

INTEGRATING: Final = 1e-30
"""Rate that represents an integrator [1/s]: its decay in 1e5 s is far below the rounding of 53 bits."""
_NOTHING = 1e-13
"""Response at zero frequency over the largest mode, below which it is the rounding of the sum of modes."""
Column = Any
"""A number that all cases share, or a column of shape (cases, 1) with one for each."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Transfer:
    """H(s) = slope s + direct + sum gain rate/(s + rate), and a free part sum free exp(-rate t).

    Parameters
    ----------
    rates : ndarray, shape (n,) or (cases, n)
        Minus the poles, >= 0 [1/s]; a rate of 0 is trapped charge, which the drive does not excite.
    gains : ndarray, shape (n,) or (cases, n)
        Contribution of each mode to the response at zero frequency.
    direct : float or ndarray, shape (cases, 1)
        Response at infinite frequency.
    slope : float or ndarray, shape (cases, 1)
        Response to the rate of change of the drive.
    free : ndarray, shape (n,) or (cases, n), optional
        Amplitudes at time 0 of the response to initial charge.
    static : float or ndarray, shape (cases, 1), optional
        Response at zero frequency, where the sum of `direct` and `gains` would lose it by cancellation, as for a current.

    Notes
    -----
    Cases are scenarios that differ in numbers; what they share has no axis of cases.
    With `static` the transfer function is static + slope s - sum gain s/(s + rate), which loses no digits at low
    frequency.
    Without a free part it is a filter; two transfer functions can be multiplied when at most one has a free part or a
    slope, and they have no rate in common.
    """

    __array_ufunc__ = None  # a column times a transfer function is a transfer function

    rates: Real
    gains: Real
    direct: Column = 0.0
    slope: Column = 0.0
    free: Real = field(default_factory=lambda: np.zeros(0))
    static: Column | None = None

    def __post_init__(self) -> None:
        """Replace an absent free part by zeros."""
        if self.free.shape[-1] != self.rates.shape[-1]:
            object.__setattr__(self, "free", np.zeros(self.rates.shape[-1]))

    def at(self, frequency: ArrayLike) -> Complex:
        """Evaluate the forced part at frequencies [Hz], any shape; cases have an axis before it."""
        given = np.asarray(frequency, dtype=float)
        s = 2j * np.pi * given.reshape(-1)
        level = self.direct if self.static is None else self.static
        driven = np.any(self.gains != 0, axis=tuple(range(self.gains.ndim - 1)))
        rates, gains = self.rates[..., None, driven], self.gains[..., None, driven]
        parts = (rates if self.static is None else -s[:, None]) / (s[:, None] + rates)
        summed = np.sum(parts * gains, axis=-1)  # a matrix product would start threads, which take longer
        found = np.asarray(level + self.slope * s + summed, dtype=complex)
        return found.reshape(found.shape[:-1] + given.shape)

    def free_at(self, frequency: ArrayLike) -> Complex:
        """Evaluate the Laplace transform of the free part at j w, frequencies [Hz] above 0, any shape."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)
        return np.asarray(1 / (s[..., None] + self.rates) @ self.free, dtype=complex)

    def at_rest(self) -> Column:
        """Return the response at zero frequency."""
        return self.direct + summed(self.gains) if self.static is None else self.static

    def __add__(self, other: Transfer) -> Transfer:
        """Return the sum; transfer functions of one stack keep their common modes."""
        if self.rates is other.rates or np.array_equal(self.rates, other.rates):
            gains, free, rates = self.gains + other.gains, self.free + other.free, self.rates
        else:
            rates = side_by_side(self.rates, other.rates)
            gains = side_by_side(self.gains, other.gains)
            free = side_by_side(self.free, other.free)
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
        return self + -other

    def __neg__(self) -> Transfer:
        """Return the opposite."""
        return self * -1.0

    def __mul__(self, other: Any) -> Transfer:
        """Return the product with a number or a column, or with another transfer function."""
        if isinstance(other, Transfer):
            return _product(self, other)
        return Transfer(
            rates=self.rates,
            gains=self.gains * other,
            direct=self.direct * other,
            slope=self.slope * other,
            free=self.free * other,
            static=None if self.static is None else self.static * other,
        )

    __rmul__ = __mul__

    def __truediv__(self, divisor: Column) -> Transfer:
        """Return the quotient by a number or a column."""
        return self.__mul__(np.divide(1, divisor))


def summed(rows: Real) -> Column:
    """Return the sum over the last axis: a number, or a column for cases."""
    return float(rows.sum()) if rows.ndim == 1 else rows.sum(axis=-1, keepdims=True)


def row_of(number: Column) -> Real:
    """Return a number as an array with one entry, a column as it is."""
    return np.atleast_1d(np.asarray(number, dtype=float))


def side_by_side(*rows: Real) -> Real:
    """Return arrays side by side along their last axis; what cases share is repeated for each."""
    lead = np.broadcast_shapes(*(each.shape[:-1] for each in rows))
    return np.concatenate([np.broadcast_to(each, (*lead, each.shape[-1])) for each in rows], axis=-1)


def _product(filter_: Transfer, signal: Transfer) -> Transfer:
    """Return the product by partial fractions: each residue of one times the value of the other at that pole."""
    if np.any(filter_.slope) or np.any(filter_.free):
        filter_, signal = signal, filter_
    if np.any(filter_.slope) or np.any(signal.slope) or np.any(filter_.free):
        raise ValueError("only one factor may have a free part, and none a slope")
    if not filter_.rates.shape[-1]:
        return signal.__mul__(filter_.direct)
    known = filter_.static is not None or signal.static is not None
    apart = filter_.rates[..., :, None] - signal.rates[..., None, :]  # filter rate minus signal rate
    weights = filter_.gains * filter_.rates
    of_filter = filter_.direct + np.sum(weights[..., :, None] / apart, axis=-2)
    of_signal = signal.direct - np.sum((signal.gains * signal.rates)[..., None, :] / apart, axis=-1)
    free_here = signal.free * of_filter
    free_there = -weights * np.sum(signal.free[..., None, :] / apart, axis=-1)
    return Transfer(
        rates=side_by_side(signal.rates, filter_.rates),
        gains=side_by_side(signal.gains * of_filter, filter_.gains * of_signal),
        direct=filter_.direct * signal.direct,
        free=side_by_side(free_here, free_there),
        static=filter_.at_rest() * signal.at_rest() if known else None,
    )


def integrated(rate: Transfer, *, start: Column = 0.0) -> Transfer:
    """Return the integral over time of a linear quantity, for instance the charge delivered by a current.

    H = static + slope s - sum gain s/(s + rate) gives H/s = static/s + slope - sum gain/(s + rate).
    """
    rates, safe = rate.rates, np.where(rate.rates > 0, rate.rates, 1.0)
    static = resting(rate)
    gains, free = -rate.gains / safe, -rate.free / safe
    constant = start - summed(free)
    if np.any(static):
        rates, gains = (
            side_by_side(rates, row_of(INTEGRATING)),
            side_by_side(gains, row_of(static / INTEGRATING)),
        )
        free = side_by_side(free, row_of(0.0))
    if np.any(constant):
        rates, gains = side_by_side(rates, row_of(0.0)), side_by_side(gains, row_of(0.0))
        free = side_by_side(free, row_of(constant))
    return Transfer(rates=rates, gains=gains, direct=rate.slope, free=free)


def resting(transfer: Transfer) -> Column:
    """Return the response at zero frequency, 0 where it is only the rounding of the sum of modes."""
    if transfer.static is not None:
        return transfer.static
    level = transfer.at_rest()
    largest = np.maximum(
        abs(transfer.direct), np.max(np.abs(transfer.gains), axis=-1, initial=0.0, keepdims=True)
    )
    found = np.where(np.abs(level) > _NOTHING * largest, level, 0.0)
    return found if np.ndim(level) else float(found[0])


def without_integrators(transfer: Transfer) -> Transfer:
    """Return the transfer function without the modes that integrate the drive."""
    return replace(transfer, gains=np.where(transfer.rates == INTEGRATING, 0.0, transfer.gains))


def integral_weight(transfer: Transfer) -> Column:
    """Return the factor of the drive's integral over time in a quantity [its unit per unit of the drive and s]."""
    return summed(np.where(transfer.rates == INTEGRATING, transfer.gains * transfer.rates, 0.0))


class NotInArraysError(Exception):
    """A scenario, or what differs between cases, that arrays over cases do not cover; the message is the reason."""
