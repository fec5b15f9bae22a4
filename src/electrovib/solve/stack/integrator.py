"""Integrals over time as modes: the charge delivered by a current, from rest and in the periodic state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Tones
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Part

INTEGRATING: Final = 1e-30
"""Rate that represents an integrator [1/s]: its decay in 1e5 s is far below the rounding of 53 bits."""
_NO_MEAN = 1e-12
"""Mean of a drive over its largest value, below which it is rounding."""
_NOTHING = 1e-13
"""Response at zero frequency over the largest mode, below which it is the rounding of the sum of modes."""


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
    gains = np.where(transfer.rates == INTEGRATING, 0.0, transfer.gains)
    return Transfer(
        rates=transfer.rates,
        gains=gains,
        direct=transfer.direct,
        slope=transfer.slope,
        free=transfer.free,
        static=transfer.static,
    )


def integral_weight(transfer: Transfer) -> float:
    """Return the factor of the drive's integral over time in a quantity [its unit per unit of the drive and s]."""
    return float(np.sum((transfer.gains * transfer.rates)[transfer.rates == INTEGRATING]))


def settled_integral(drive: Drive, time: Real) -> Real:
    """Return the integral over time of a periodic drive, with a mean of 0 over a period.

    `time` (n,) [s]; returns `integral` (n,).
    """
    mean = drive_mean(drive)
    if mean:
        what = (
            f"the current has a mean of {format_quantity(mean, 'A')}, which charges non-conducting layers without limit"
            if drive.quantity == "current"
            else f"the drive has a mean of {format_quantity(mean, 'V')} and every layer up to the interface conducts, so that"
            " the charge there grows without limit. Declare a layer with role = 'gap'"
        )
        raise InputError(
            f"time.initial_state = PeriodicState: {what}. Choose a drive with a mean of 0, or start from rest: AtRest"
        )
    total: Real = np.sum([_integral(part, time) for part in drive.parts()], axis=0)
    return total


def refuse_unrepeated(drive: Drive) -> None:
    """Refuse the periodic state of a drive that is neither periodic nor constant."""
    steady = all(isinstance(part, Linear) and part.is_step for part in drive.parts())
    if drive.period is None and not steady:
        raise InputError(
            f"time.initial_state = PeriodicState: {type(drive).__name__} does not repeat. Choose a periodic drive, or start"
            " from rest: AtRest"
        )


def drive_mean(drive: Drive) -> float:
    """Return the mean of a periodic drive over a period, 0 where it is rounding [its unit]."""
    mean = sum(_mean(part) for part in drive.parts())
    return mean if abs(mean) > _NO_MEAN * sum(part.bound() for part in drive.parts()) else 0.0


def _mean(part: Part) -> float:
    if isinstance(part, Tones):
        return float(np.sum(part.amplitudes[part.frequencies == 0].real))
    assert isinstance(part, Linear)
    if part.period is None:
        return float(part.after[0])
    return float(np.sum((part.after[:-1] + part.before[1:]) / 2 * np.diff(part.times))) / part.period


def _integral(part: Part, time: Real) -> Real:
    """Return the integral of a part without its mean, with a mean of 0."""
    if isinstance(part, Tones):
        moving = part.frequencies > 0
        angular = 2 * np.pi * part.frequencies[moving]
        waves = np.exp(1j * np.outer(angular, time)) / (1j * angular[:, None])
        integral: Real = (part.amplitudes[moving] @ waves).real
        return integral
    assert isinstance(part, Linear)
    if part.period is None:
        return np.zeros(len(time))
    return _straight_integral(part, part.period, time)


def _straight_integral(part: Linear, period: float, time: Real) -> Real:
    """Return the integral of straight pieces: parabolas from break to break."""
    first, last = part.after[:-1] - _mean(part), part.before[1:] - _mean(part)
    steps = np.diff(part.times)
    slopes = (last - first) / steps
    begun = np.concatenate([[0.0], np.cumsum((first + last) / 2 * steps)[:-1]])
    mean = float(np.sum(begun * steps + first * steps**2 / 2 + slopes * steps**3 / 6)) / period
    index, elapsed = part.locate(time)
    index = np.minimum(index, len(steps) - 1)
    integral: Real = begun[index] + (first[index] + slopes[index] * elapsed / 2) * elapsed - mean
    return integral
