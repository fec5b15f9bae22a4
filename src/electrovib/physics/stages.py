"""The four linear stages of which fingertips, sensors and conditioners are made: what a solver knows to follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex

_NAN_PASSES = np.errstate(invalid="ignore")


@dataclass(frozen=True)
class Resonance:
    """A mass on a spring and a damper: w0^2/(s^2 + 2 zeta w0 s + w0^2).

    Parameters
    ----------
    natural_frequency : float
        w0/(2 pi), without damping [Hz].
    damping_ratio : float
        zeta; 1 is critical [-].
    """

    natural_frequency: float
    damping_ratio: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Response [-] at frequencies [Hz]."""
        ratio = np.asarray(frequency, dtype=float) / self.natural_frequency
        return np.asarray(1 / (1 - ratio**2 + 2j * self.damping_ratio * ratio))


@dataclass(frozen=True)
class LowPass:
    """A first-order lag: 1/(1 + s/(2 pi cut_off)).

    Parameters
    ----------
    cut_off : float
        Where the power has halved [Hz].
    """

    cut_off: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Response [-] at frequencies [Hz]."""
        return np.asarray(1 / (1 + 1j * np.asarray(frequency, dtype=float) / self.cut_off))


@dataclass(frozen=True)
class HighPass:
    """What leaks away with one time constant: s T/(1 + s T).

    Parameters
    ----------
    time_constant : float
        T [s].
    """

    time_constant: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Response [-] at frequencies [Hz]."""
        turn = 2j * np.pi * np.asarray(frequency, dtype=float) * self.time_constant
        return np.asarray(turn / (1 + turn))


@dataclass(frozen=True)
class CreepResponse:
    """What follows at once and then creeps on: 1 + sum share/(1 + s T).

    Parameters
    ----------
    shares : tuple of float
        What each creep adds in the end, of what followed at once [-]; negative where it gives way.
    times : tuple of float
        T of each [s].
    """

    shares: tuple[float, ...]
    times: tuple[float, ...]

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Response [-] at frequencies [Hz]."""
        turn = 2j * np.pi * np.asarray(frequency, dtype=float)
        total = np.ones(np.shape(turn), complex)
        for share, time in zip(self.shares, self.times, strict=True):
            total = total + share / (1 + turn * time)
        return np.asarray(total)


Stage: TypeAlias = Resonance | LowPass | HighPass | CreepResponse


def response(stages: tuple[Stage, ...], frequency: ArrayLike) -> Complex:
    """Response of stages one after the other.

    Parameters
    ----------
    stages : tuple of Stage
        In any order.
    frequency : array_like
        Hz.

    Returns
    -------
    ndarray of complex, shape of `frequency`
        Product of their responses [-].
    """
    total = np.ones(np.shape(frequency), complex)
    for stage in stages:
        total = total * stage.at(frequency)
    return np.asarray(total)
