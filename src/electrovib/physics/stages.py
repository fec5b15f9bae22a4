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

    `natural_frequency` is w0/(2 pi), without damping [Hz]; `damping_ratio` is zeta, 1 for critical damping.
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
    """A first-order lag: 1/(1 + s/(2 pi cut_off)), `cut_off` the frequency [Hz] at which the power has halved."""

    cut_off: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response [1] at frequencies [Hz]."""
        return np.asarray(1 / (1 + 1j * np.asarray(frequency, dtype=float) / self.cut_off))


@dataclass(frozen=True)
class HighPass:
    """A high-pass, whose response to a step decays with one time constant T [s]: s T/(1 + s T)."""

    time_constant: float

    @_NAN_PASSES
    def at(self, frequency: ArrayLike) -> Complex:
        """Return the response [1] at frequencies [Hz]."""
        turn = 2j * np.pi * np.asarray(frequency, dtype=float) * self.time_constant
        return np.asarray(turn / (1 + turn))


@dataclass(frozen=True)
class CreepResponse:
    """An immediate response followed by creep: 1 + sum share/(1 + s T).

    `shares` are the final contribution of each creep over the immediate response, negative for a decrease;
    `times` its time constants T [s].
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
    """Return the response of stages in series, the product of theirs, at frequencies [Hz]."""
    total = np.ones(np.shape(frequency), complex)
    for stage in stages:
        total = total * stage.at(frequency)
    return np.asarray(total)
