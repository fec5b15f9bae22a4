"""Periodic drives: their harmonics, their means and their integrals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Linear, Part, Tones

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.base import Drive

_NO_MEAN = 1e-12
"""Mean of a drive over its largest value, below which it is rounding."""


def spectrum(drive: Drive, *, harmonics: int) -> tuple[Real, Complex]:
    """Return frequencies [Hz] and complex peak amplitudes [V] whose real parts sum to a periodic drive."""
    found: dict[float, complex] = {}
    for part in drive.parts():
        for frequency, amplitude in zip(*_part_spectrum(part, harmonics), strict=True):
            found[frequency] = found.get(frequency, 0.0) + amplitude
    frequencies = np.array(sorted(found))
    return frequencies, np.array([found[frequency] for frequency in frequencies])


def count_harmonics(drive: Drive) -> int | None:
    """Return the number of frequencies in a drive, with a constant; None where it is infinite, as for edges."""
    parts = drive.parts()
    if drive.period is None or not all(isinstance(part, Tones) or part.is_step for part in parts):
        return None
    return int(np.count_nonzero(spectrum(drive, harmonics=1)[1]))


def _part_spectrum(part: Part, harmonics: int) -> tuple[Real, Complex]:
    if isinstance(part, Tones):
        return part.frequencies, part.amplitudes
    if part.is_step:
        return np.zeros(1), part.after.astype(complex)
    if part.period is not None:
        return _straight_spectrum(part, part.period, harmonics)
    raise InputError("drive: a part of it does not repeat, so it has no harmonics")


def _straight_spectrum(part: Linear, period: float, harmonics: int) -> tuple[Real, Complex]:
    """Return the Fourier series of straight pieces: 1/(j w) for each discontinuity, 1/(j w)^2 for each change of slope."""
    first, last = part.after[:-1], part.before[1:]
    slopes = (last - first) / np.diff(part.times)
    jumps = first - np.roll(last, 1)
    bends = slopes - np.roll(slopes, 1)
    angular = 2 * np.pi * np.arange(1, harmonics + 1) / period
    turns = np.exp(-1j * angular[:, None] * part.times[:-1])
    series = 2 / period * (turns @ jumps / (1j * angular) + turns @ bends / (1j * angular) ** 2)
    return np.append(0.0, angular / (2 * np.pi)), np.append(_mean(part) + 0j, series)


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
    return integral_of(drive.parts(), time)


def integral_of(parts: Sequence[Part], time: Real) -> Real:
    """Return the integral over time of repeated parts without their mean, with a mean of 0 over a period, (n,)."""
    return sum((_integral(part, time) for part in parts), np.zeros(len(time)))


def refuse_unrepeated(drive: Drive) -> None:
    """Refuse the periodic state of a drive that is neither periodic nor constant."""
    steady = all(part.is_step for part in drive.parts())
    if drive.period is None and not steady:
        raise InputError(
            f"time.initial_state = PeriodicState: {type(drive).__name__} does not repeat. Choose a periodic drive, or start"
            " from rest: AtRest"
        )


def drive_mean(drive: Drive) -> float:
    """Return the mean of a periodic drive over a period, 0 where it is rounding [its unit]."""
    return mean_of(drive.parts())


def mean_of(parts: Sequence[Part]) -> float:
    """Return the mean of repeated parts over a period, 0 where it is rounding."""
    mean = sum(_mean(part) for part in parts)
    return mean if abs(mean) > _NO_MEAN * sum(part.bound() for part in parts) else 0.0


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
