"""Linear filters of mechanics and sensors, with real poles and conjugate pairs: their stages, cascades and outputs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex, Real
from electrovib.core.errors import InputError
from electrovib.physics.stages import CreepResponse, HighPass, LowPass, Resonance
from electrovib.solve.recursion import march

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.physics.stages import Stage

CRITICAL = 1e-6
"""Distance from a damping ratio of 1 within which the response is interpolated between the two sides."""
APART = 1e-5
"""Relative distance of poles of two stages below which partial fractions cannot separate them."""


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

    def state(self, level: float) -> Complex:
        """Return the state of the modes that have settled to a constant input, (n,)."""
        return np.full(len(self.poles), level, complex)

    def _weights(self) -> Real:
        return np.where(self.poles.imag == 0, 1.0, 2.0)


def second_order(*, natural_frequency: float, damping_ratio: float) -> Filter:
    """Return the resonance of a mass on a spring and a damper: w0^2/(s^2 + 2 zeta w0 s + w0^2).

    At zeta = 1 both poles coincide at -w0, and the response is no sum of modes. It is smooth in zeta there,
    so within CRITICAL of 1 it is interpolated between 1 - CRITICAL and 1 + CRITICAL: error below 0.6
    CRITICAL^2 = 6e-13 of the response, plus rounding times the gains, which reach 350: 1e-13.
    """
    if not (natural_frequency > 0 and damping_ratio > 0):
        raise InputError(
            f"natural_frequency = {natural_frequency}, damping_ratio = {damping_ratio}: both must be positive."
        )
    off = (damping_ratio - 1) / CRITICAL
    if abs(off) >= 1:
        return _two_modes(natural_frequency, damping_ratio)
    below, above = (_two_modes(natural_frequency, 1 + side * CRITICAL) for side in (-1, 1))
    return (1 - off) / 2 * below + (1 + off) / 2 * above


def _two_modes(natural_frequency: float, damping_ratio: float) -> Filter:
    """Return a resonance with two distinct poles."""
    angular = 2 * math.pi * natural_frequency
    spread = math.sqrt(abs(damping_ratio - 1) * (1 + damping_ratio))
    if damping_ratio < 1:
        pole = complex(-damping_ratio, spread)
        return Filter(np.array([angular * pole]), np.array([0.5j / (spread * pole)]))
    fast = damping_ratio + spread
    gains = np.array([fast, -1 / fast]) / (2 * spread)
    return Filter(np.array([-angular / fast, -angular * fast], complex), gains.astype(complex))


def first_order(cut_off: float) -> Filter:
    """Return the first-order lag 1/(1 + s/(2 pi cut_off)), cut-off frequency in [Hz]."""
    return Filter(np.array([-2 * math.pi * cut_off], complex), np.ones(1, complex))


def high_pass(time_constant: float) -> Filter:
    """Return the first-order high-pass s T/(1 + s T) with the time constant T [s]."""
    return Filter(np.array([-1 / time_constant], complex), -np.ones(1, complex), 1.0)


def relaxing(shares: ArrayLike, times: ArrayLike) -> Filter:
    """Return the response of an instantaneous part and creep: 1 + sum share/(1 + s T).

    `shares` (n,), `times` (n,) [s].
    """
    poles = np.asarray(-1 / np.asarray(times, float), complex)
    return Filter(poles, np.asarray(shares, complex), 1.0)


def cascade(*filters: Filter) -> Filter:
    """Return the cascade of filters, by partial fractions."""
    return reduce(_product, filters, Filter.through())


def _product(one: Filter, other: Filter) -> Filter:
    if not len(one.poles):
        return other if one.direct == 1 else one.direct * other
    near = np.minimum(
        np.abs(one.poles[:, None] - other.poles), np.abs(one.poles[:, None] - np.conj(other.poles))
    )
    for row, column in np.argwhere(near < APART * np.abs(one.poles)[:, None])[:1]:
        raise InputError(
            f"cascade: two stages have poles at {one.poles[row]:.6g} and {other.poles[column]:.6g} per second,"
            " too close to be separated. Change a cut-off or a damping ratio by 0.1 % of its value."
        )
    gains = np.concatenate([one.gains * other.value(one.poles), other.gains * one.value(other.poles)])
    poles = np.concatenate([one.poles, other.poles])
    return Filter(poles, np.where(poles.imag == 0, gains.real, gains), one.direct * other.direct)


def of_stages(stages: Iterable[Stage]) -> Filter:
    """Return the filter of a declared chain of stages."""
    return cascade(*(_of_stage(stage) for stage in stages))


def _of_stage(stage: Stage) -> Filter:
    match stage:
        case Resonance():
            return second_order(natural_frequency=stage.natural_frequency, damping_ratio=stage.damping_ratio)
        case LowPass():
            return first_order(stage.cut_off)
        case HighPass():
            return high_pass(stage.time_constant)
        case CreepResponse():
            return relaxing(stage.shares, stage.times)


def march_through(filter_: Filter, starts: Real, ends: Real, *, steps: float | Real, state: Complex) -> Real:
    """Return the exact output of a filter for straight pieces with discontinuities between them.

    `starts`, `ends` (pieces,), `steps` (pieces,) [s], `state` (poles,); returns `output` (pieces + 1,).
    """
    gains = filter_.gains[np.newaxis]
    outputs, _ = march(filter_.poles, gains, [filter_.direct], starts, ends, steps, state)
    output: Real = outputs[0]
    return output


def finite(samples: ArrayLike) -> Real:
    """Return samples as an array, refusing an empty one and values that are not finite.

    `samples` (n,); returns `values` (n,).
    """
    values = np.asarray(samples, dtype=float)
    bad = np.flatnonzero(~np.isfinite(values))
    if values.ndim != 1 or not values.size or bad.size:
        where = f"sample {bad[0]} is {values.ravel()[bad[0]]}" if bad.size else f"shape {values.shape}"
        raise InputError(f"samples: {where}; expected one row of finite numbers, at least one.")
    return values
