"""Exact recursion of relaxing and ringing modes driven by one voltage or force of straight pieces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.recursion.blocks import even_states, march_even
from electrovib.solve.recursion.fused import march_chain
from electrovib.solve.recursion.hold import hold_weights, hold_weights_complex
from electrovib.solve.recursion.jittered import jittered_states, march_jittered
from electrovib.solve.recursion.loop import march_loop, march_pairs_loop
from electrovib.solve.recursion.record import gather

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Indices

__all__ = [
    "hold_weights",
    "hold_weights_complex",
    "march",
    "march_chain",
    "march_loop",
    "march_pairs",
    "march_pairs_loop",
    "march_rows",
    "states_at",
]


def march(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    *,
    keep: int = 1,
    lag: ArrayLike = False,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Follow relaxing modes through a drive of straight pieces, exactly at any step.

    Parameters
    ----------
    poles : array_like, (poles,)
        Rates [1/s], negative. May be empty.
    gains : array_like, (outputs, poles)
        Share of every mode in every output [-].
    direct : array_like, (outputs,)
        Share of the drive itself in every output [-].
    starts, ends : array_like, (pieces,)
        Drive just after the beginning and just before the end of each piece, finite, in the unit of the
        outputs, usually [V]. For a drive ``v`` without jumps pass ``v[:-1]`` and ``v[1:]``, views of one
        array: it is then read once.
    steps : float or array_like, (pieces,)
        Duration of every piece [s], zero or positive. Durations that are all equal count as one number;
        for an even grid pass a number, since differences of time stamps are equal only up to rounding.
    initial_state : array_like, (poles,)
        State at the first point, in the unit of the drive; zeros for rest.
    keep : int
        Every so many points one is put out, beginning with the first; what lies between is not computed.
    lag : bool or array_like of bool, (outputs,)
        Whether an output takes ``x - v`` of every mode in the place of ``x``: what a fast mode lags behind the
        drive, as a current does, is then no difference of two large numbers.

    Returns
    -------
    output : ndarray, (outputs, pieces // keep + 1)
        Outputs at the points between the pieces and at both ends. Where the drive jumps, the value just
        after the jump; at the last point the drive is ``ends[-1]``.
    final_state : ndarray, (poles,)
        State at the last point, the ``initial_state`` of whatever comes next.

    Raises
    ------
    InputError
        If shapes disagree, a pole is not negative, or a duration is negative or not finite.

    Notes
    -----
    ``x_k' = p_k (x_k - v)``, ``y = direct v + sum_k gain_k x_k``, that is
    ``H(s) = direct + sum_k gain_k (-p_k)/(s - p_k)``. Same result as ``march_loop`` up to rounding. A value
    of the drive that is not finite spoils outputs before it too, within its block.

    An even grid goes through matrix products over blocks of samples, an uneven one through a scan over
    rows of pieces.

    References
    ----------
    .. [1] G. E. Blelloch, "Prefix sums and their applications", Carnegie Mellon University,
           CMU-CS-90-190, 1990.
    """
    modes, drive, state = gather(poles, gains, direct, starts, ends, steps, initial_state, keep=keep, lag=lag)
    output = np.empty((modes.direct.size, drive.starts.size // keep + 1))
    return output, (march_jittered if drive.steps.ndim else march_even)(
        modes, drive, state, keep, list(output)
    )


def march_rows(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    *,
    lag: ArrayLike = False,
    passed: list[tuple[int, NDArray[np.float64]]] | None = None,
) -> list[NDArray[np.float64]]:
    """Follow relaxing modes as `march` does, each output in an array of its own.

    Parameters
    ----------
    poles, gains, direct, starts, ends, steps, initial_state, lag : array_like
        As in ``march``.
    passed : list of (int, ndarray), optional
        Takes points on the way and the states there, where the march has them at hand.

    Returns
    -------
    list of ndarray, (pieces + 1,)
        One for each output: memory that a system gives, and takes back, more readily than one large array.

    Raises
    ------
    InputError
        As in ``march``.
    """
    modes, drive, state = gather(poles, gains, direct, starts, ends, steps, initial_state, lag=lag)
    output = [np.empty(drive.starts.size + 1) for _ in modes.direct]
    if drive.steps.ndim:
        march_jittered(modes, drive, state, 1, output, passed)
    else:
        march_even(modes, drive, state, 1, output)
    return output


def states_at(
    poles: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    places: Indices,
) -> NDArray[np.float64]:
    """Return the states of relaxing modes at some points of a drive of straight pieces, and at no other.

    Parameters
    ----------
    poles, starts, ends, steps, initial_state : array_like
        As in ``march``.
    places : ndarray of int, (n,)
        Which points between the pieces, increasing: 0 is the first, the number of pieces the last.

    Returns
    -------
    ndarray, (poles, n)
        In the unit of the drive.

    Raises
    ------
    InputError
        As in ``march``.
    """
    count = np.size(poles)
    modes, drive, state = gather(poles, np.zeros((0, count)), np.zeros(0), starts, ends, steps, initial_state)
    found: NDArray[np.float64] = (jittered_states if drive.steps.ndim else even_states)(
        modes, drive, state, places
    )
    return found


def march_pairs(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    *,
    keep: int = 1,
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Follow ringing modes through a drive of straight pieces, exactly at any step.

    Parameters
    ----------
    poles : array_like of complex, (poles,)
        Real ones, and of each conjugate pair the one with the positive imaginary part [1/s]; real parts
        negative.
    gains : array_like of complex, (outputs, poles)
        Share of every mode in every output [-]; the conjugate mode has the conjugate gain and is not given.
    direct, starts, ends, steps, keep : array_like
        As in ``march``.
    initial_state : array_like of complex, (poles,)
        State at the first point, in the unit of the drive; zeros for rest, the drive itself for steadiness.

    Returns
    -------
    output : ndarray, (outputs, pieces // keep + 1)
        As in ``march``.
    final_state : ndarray of complex, (poles,)
        State at the last point.

    Raises
    ------
    InputError
        As in ``march``; or if a pole has a negative imaginary part.

    Notes
    -----
    ``x_k' = p_k (x_k - v)``, ``y = direct v + Re sum_k w_k gain_k x_k`` with ``w_k`` 1 for a real pole and 2
    for a pair. The block products are those of ``march``, over the real and imaginary parts of the modes.
    """
    modes, drive, state = gather(
        poles, gains, direct, starts, ends, steps, initial_state, keep=keep, pairs=True
    )
    output = np.empty((modes.direct.size, drive.starts.size // keep + 1))
    return output, (march_jittered if drive.steps.ndim else march_even)(
        modes, drive, state, keep, list(output)
    )
