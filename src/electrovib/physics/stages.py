"""The four linear stages of which the models of fingertips, sensors and conditioners consist."""

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
        zeta [1]; 1 is critical damping.
    """

    natural_frequency: float
    damping_ratio: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response [1] at frequencies [Hz]."""
        ratio = np.asarray(frequency, dtype=float) / self.natural_frequency
        return np.asarray(1 / (1 - ratio**2 + 2j * self.damping_ratio * ratio))


@dataclass(frozen=True)
class LowPass:
    """A first-order lag: 1/(1 + s/(2 pi cut_off)).

    Parameters
    ----------
    cut_off : float
        Frequency at which the power has halved [Hz].
    """

    cut_off: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response [1] at frequencies [Hz]."""
        return np.asarray(1 / (1 + 1j * np.asarray(frequency, dtype=float) / self.cut_off))


@dataclass(frozen=True)
class HighPass:
    """A high-pass, whose response to a step decays with one time constant: s T/(1 + s T).

    Parameters
    ----------
    time_constant : float
        T [s].
    """

    time_constant: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response [1] at frequencies [Hz]."""
        turn = 2j * np.pi * np.asarray(frequency, dtype=float) * self.time_constant
        return np.asarray(turn / (1 + turn))


@dataclass(frozen=True)
class CreepResponse:
    """An immediate response followed by creep: 1 + sum share/(1 + s T).

    Parameters
    ----------
    shares : tuple of float
        Final contribution of each creep over the immediate response [1]; negative for a decrease.
    times : tuple of float
        Time constant T of each creep [s].
    """

    shares: tuple[float, ...]
    times: tuple[float, ...]

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response [1] at frequencies [Hz]."""
        turn = 2j * np.pi * np.asarray(frequency, dtype=float)
        total = np.ones(np.shape(turn), complex)
        for share, time in zip(self.shares, self.times, strict=True):
            total = total + share / (1 + turn * time)
        return np.asarray(total)


Stage: TypeAlias = Resonance | LowPass | HighPass | CreepResponse


def response(stages: tuple[Stage, ...], frequency: ArrayLike) -> Complex:
    """Return the response of stages in series."""
    total = np.ones(np.shape(frequency), complex)
    for stage in stages:
        total = total * stage.at(frequency)
    return np.asarray(total)
