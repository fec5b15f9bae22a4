"""Modes under straight pieces of drive, and the exact weights of one piece."""

from __future__ import annotations

from bisect import bisect_left
from math import factorial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.arrays import Numbers, Real

_SERIES = [1.0 / factorial(order) for order in range(2, 19)]
"""1/2!, 1/3!, ...: the first term left out is below 1e-17 of the sum for every |z| < 1."""
_REACH = [(0.5e-17 * factorial(count + 2)) ** (1 / count) for count in range(1, len(_SERIES))]
"""Largest |z| for which the first 1, 2, ... terms are enough likewise."""
SLOW: Final = 1 / 32
"""Rate times usual step up to which the state of a mode is advanced in an uneven record; of faster modes it is the lag."""


class Modes(NamedTuple):
    """Modes and their shares in each output.

    Parameters
    ----------
    poles : ndarray, (poles,)
        Rates [1/s]: negative, or complex with a negative real part.
    gains : ndarray, (outputs, poles)
        Share of every mode in every output [-], doubled for a mode that represents a pair. The output is the real part
        of the sum.
    direct : ndarray, (outputs,)
        Share of the drive itself in every output [-].
    lag : ndarray of bool, (outputs,)
        Whether an output takes the lag of every mode behind the drive in the place of the mode.
    """

    poles: Numbers
    gains: Numbers
    direct: Real
    lag: NDArray[np.bool_]


class StraightDrive(NamedTuple):
    """A drive of straight pieces.

    Parameters
    ----------
    starts, ends : ndarray, (pieces,)
        Drive just after the beginning and just before the end of each piece.
    steps : ndarray, (pieces,) or ()
        Durations [s]; one number when all are equal.
    """

    starts: Real
    ends: Real
    steps: Real

    def jumps(self) -> Real | None:
        """Return the drop of the drive at the beginning of each piece, or None for a continuous drive."""
        before, after = self.ends[:-1], self.starts[1:]
        same_memory = before.ctypes.data == after.ctypes.data  # both are contiguous and equally long
        if same_memory or np.array_equal(before, after):
            return None
        return np.concatenate(([0.0], before - after))


def gather(*given: ArrayLike, lag: ArrayLike = False) -> tuple[Modes, StraightDrive, Numbers]:
    """Convert the arguments of `march` into contiguous arrays.

    Returns `state` (poles,).
    """
    poles, gains, direct, starts, ends, steps, initial_state = given
    kind = np.complex128 if np.iscomplexobj(poles) else np.float64
    shares = np.ascontiguousarray(direct, np.float64)
    modes = Modes(
        np.ascontiguousarray(poles, kind),
        np.ascontiguousarray(gains, kind),
        shares,
        np.broadcast_to(np.asarray(lag, bool), shares.shape),
    )
    sides = [np.ascontiguousarray(each, np.float64) for each in (starts, ends)]
    drive = StraightDrive(sides[0], sides[1], np.asarray(steps, np.float64))
    state: Numbers = np.array(initial_state, kind)
    if kind is np.complex128:
        modes = modes._replace(gains=modes.gains * np.where(modes.poles.imag == 0.0, 1.0, 2.0))
    if drive.steps.ndim and drive.steps.min() == drive.steps.max():
        drive = drive._replace(steps=drive.steps[0])
    return modes, drive, state


def hold_weights(z: ArrayLike) -> tuple[Numbers, Numbers, Numbers]:
    """Compute the weights of the old state and of both ends of a straight piece of drive, for a real or a complex mode.

    For ``x' = p (x - v)``, ``z = p h`` and ``u = -z`` the step is ``x(h) = decay x(0) + first v(0+) + last v(h-)`` with
    ``decay = exp(-u)``, ``first = (1 - exp(-u))/u - exp(-u)`` and ``last = 1 - (1 - exp(-u))/u``. Both differences cancel
    for small ``u``; there ``first = exp(-u) s`` and ``last = exp(-u) (u + (u - 1) s)`` with ``s = u/2! + u^2/3! + ...``, which
    keep every digit. The relative error is about 1e-15 for every real ``z`` between -1e300 and -1e-300 (``decay`` itself becomes
    subnormal below -708); of an oscillating mode with ``|z| > 1`` it is that of the larger of the two terms of ``first``,
    which itself passes through zero near u = 2.1 + 7.5j (and further out). A positive ``z`` is a growing mode and gives
    meaningless weights.
    """
    exponent = np.asarray(z, np.complex128 if np.iscomplexobj(z) else np.float64)
    decay, is_small = np.asarray(np.exp(exponent)), np.abs(exponent) < 1.0
    small = np.where(is_small, -exponent, 0.0)
    count = bisect_left(_REACH, float(np.max(np.abs(small), initial=0.0))) + 1
    series = np.full_like(small, _SERIES[count - 1])
    for term in _SERIES[:count][-2::-1]:
        series *= small
        series += term
    series *= small
    first = np.asarray(decay * series)
    last = np.asarray(decay * (small + (small - 1) * series))
    if not np.all(is_small):
        large = exponent[~is_small]
        mean = np.expm1(large) / large
        first[~is_small], last[~is_small] = mean - decay[~is_small], 1.0 - mean
    return decay, first, last
