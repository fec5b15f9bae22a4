"""Exact weights of one straight piece of drive, and the recursion step by step: the reference of the fast methods."""

from __future__ import annotations

from math import factorial
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.solve.recursion.record import gather

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Complex, Numbers, Real
    from electrovib.solve.recursion.record import Modes, StraightDrive

# 1/2!, 1/3!, ...: the first term left out is below 1e-17 of the sum for every |z| < 1
_SERIES = [1.0 / factorial(order) for order in range(2, 19)]
_Weights: TypeAlias = "tuple[Numbers, Numbers, Numbers]"
SLOW: Final = 1 / 32
"""Rate times usual step up to which the state of a mode is advanced in an uneven record; of faster modes it is the lag."""


def hold_weights(z: ArrayLike) -> tuple[Real, Real, Real]:
    """Compute the weights of the old state and of both ends of a straight piece of drive for a relaxing mode.

    A positive ``z`` is a growing mode and gives meaningless weights; ``march`` refuses it.  For ``x' = p (x -
    v)``, ``z = p h`` and ``u = -z`` the step is ``x(h) = decay x(0) + first v(0+) + last v(h-)`` with::
    decay = exp(-u),  first = (1 - exp(-u))/u - exp(-u),  last = 1 - (1 - exp(-u))/u  Both differences cancel
    for small ``u``; there ``first = exp(-u) (u/2! + u^2/3! + ...)`` has positive terms only and ``last = 1 -
    exp(-u) - first``. The relative error is about 1e-15 for every ``z`` between -1e300 and -1e-300 (``decay``
    itself becomes subnormal below -708).
    """
    return weights_of(np.asarray(z, dtype=np.float64))


def hold_weights_complex(z: ArrayLike) -> tuple[Complex, Complex, Complex]:
    """Compute the weights of the old state and of both ends of a straight piece of drive for an oscillating mode.

    The formulas are those of ``hold_weights``. For ``|z| < 1`` the series keeps every digit of ``first`` and
    ``last``. Beyond, ``first = (1 - exp(-u))/u - exp(-u)`` is exact to about 1e-15 of the larger of its two
    terms; the value itself passes through zero near u = 2.1 + 7.5j (and further out).
    """
    return weights_of(np.asarray(z, dtype=np.complex128))


def weights_of(z: Numbers) -> _Weights:
    """Return the weights of real or complex modes, as numbers of the type of the poles [-]."""
    fall, is_small = -z, np.abs(z) < 1.0
    decay, rise = np.exp(z), -np.expm1(z)
    small = np.where(is_small, fall, 0.0)
    series = np.full_like(small, _SERIES[-1])
    for term in _SERIES[-2::-1]:
        series *= small
        series += term
    series *= small
    mean = rise / np.where(is_small, 1.0, fall)
    first = np.where(is_small, decay * series, mean - decay)
    last = np.where(is_small, rise - first, 1.0 - mean)
    return decay, first, last


def march_loop(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    *,
    lag: ArrayLike = False,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Compute the response of relaxing modes to a piecewise linear drive, one piece after the other.

    Returns `output` (outputs, pieces + 1), `final_state` (poles,).

    Since ``decay = 1 - first - last``, a step is ``x + first (v_start - x) + last (v_end - x)``: a mode much slower than
    the step keeps the digits that are lost when a decay near 1 is rounded. The lag of a mode is advanced separately,
    ``decay (x - v) - (1 - last) (v_end - v_start)``, less the discontinuity of the drive.
    """
    return _follow(*gather(poles, gains, direct, starts, ends, steps, initial_state, lag=lag))


def march_pairs_loop(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Compute the response of oscillating modes to a piecewise linear drive, one piece after the other.

    Returns `output` (outputs, pieces + 1), `final_state` (poles,).
    """
    return _follow(*gather(poles, gains, direct, starts, ends, steps, initial_state, pairs=True))


def _follow(modes: Modes, drive: StraightDrive, state: Numbers) -> tuple[Real, Numbers]:
    pieces = drive.starts.size
    durations = np.broadcast_to(drive.steps, (pieces,))
    output = np.empty((modes.direct.size, pieces + 1))
    lag = state - drive.starts[0]
    for piece, (start, end, duration) in enumerate(zip(drive.starts, drive.ends, durations, strict=True)):
        if piece == 0 or duration != durations[piece - 1]:
            decay, first, last = weights_of(modes.poles * duration)
        output[:, piece] = _put_out(modes, start, state, lag)
        state = state + first * (start - state) + last * (end - state)
        lag = decay * lag - (1.0 - last) * (end - start)
        if piece + 1 < pieces:
            lag = lag - (drive.starts[piece + 1] - end)
    output[:, pieces] = _put_out(modes, drive.ends[-1], state, lag)
    return output, state


def _put_out(modes: Modes, level: float, state: Numbers, lag: Numbers) -> Real:
    """Return the outputs at one point."""
    modal = np.where(modes.lag, (modes.gains @ lag).real, (modes.gains @ state).real)
    return np.asarray(modes.direct * level + modal)
