"""Filters of the declared stages of a finger, a sensor or a rig, and their cascades."""

from __future__ import annotations

import math
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.stages import CreepResponse, HighPass, LowPass, Resonance
from electrovib.solve.mechanics.filters.filter import Filter

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from electrovib.physics.stages import Stage

CRITICAL = 1e-6
"""Distance from a damping ratio of 1 within which the response is interpolated between the two sides."""
APART = 1e-5
"""Relative distance of poles of two stages below which partial fractions cannot separate them."""


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
    return reduce(_product, filters, Filter(np.zeros(0, complex), np.zeros(0, complex), 1.0))


def _product(one: Filter, other: Filter) -> Filter:
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
