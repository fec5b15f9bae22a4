"""Exact recursion of relaxing and oscillating modes driven by one piecewise linear voltage or force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.recursion.blocks import even_states, march_even
from electrovib.solve.recursion.fused import march_chain
from electrovib.solve.recursion.hold import hold_weights, hold_weights_complex
from electrovib.solve.recursion.jittered import jittered_states, march_jittered
from electrovib.solve.recursion.long_records import aligned
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
    """Compute the response of relaxing modes to a piecewise linear drive, exact for any step.

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
        outputs, usually [V]. For a continuous drive ``v`` pass ``v[:-1]`` and ``v[1:]``, views of one array,
        which is then read only once.
    steps : float or array_like, (pieces,)
        Duration of every piece [s], zero or positive. Durations that are all equal count as one number;
        for an even grid pass a number, since differences of time stamps are equal only up to rounding.
    initial_state : array_like, (poles,)
        State at the first point, in the unit of the drive; zeros for rest.
    keep : int
        Outputs are computed at every ``keep``-th point, beginning with the first.
    lag : bool or array_like of bool, (outputs,)
        Whether an output takes ``x - v`` of every mode in the place of ``x``: the lag of a fast mode behind the
        drive, which a current is made of, is then not the difference of two large numbers.

    Returns
    -------
    output : ndarray, (outputs, pieces // keep + 1)
        Outputs at the points between the pieces and at both ends. At a discontinuity of the drive, the value just
        after it; at the last point the drive is ``ends[-1]``.
    final_state : ndarray, (poles,)
        State at the last point, the ``initial_state`` of a subsequent call.

    Raises
    ------
    InputError
        If shapes disagree, a pole is not negative, or a duration is negative or not finite.

    Notes
    -----
    ``x_k' = p_k (x_k - v)``, ``y = direct v + sum_k gain_k x_k``, that is
    ``H(s) = direct + sum_k gain_k (-p_k)/(s - p_k)``. The result equals that of ``march_loop`` up to rounding. A value
    of the drive that is not finite also invalidates outputs before it, within its block.

    An even grid is computed by matrix products over blocks of samples, an uneven one by a scan over rows of pieces.

    References
    ----------
    .. [1] G. E. Blelloch, "Prefix sums and their applications", Carnegie Mellon University,
           CMU-CS-90-190, 1990.
    """
    modes, drive, state = gather(poles, gains, direct, starts, ends, steps, initial_state, keep=keep, lag=lag)
    points = drive.starts.size // keep + 1
    output = aligned(modes.direct.size * points).reshape(-1, points)
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
    """Compute the response of relaxing modes as `march` does, each output in an array of its own.

    Parameters
    ----------
    poles, gains, direct, starts, ends, steps, initial_state, lag : array_like
        As in ``march``.
    passed : list of (int, ndarray), optional
        Receives intermediate points and the states there, where the recursion computes them anyway.

    Returns
    -------
    outputs : list of ndarray, (pieces + 1,)
        One array for each output, which an operating system allocates and frees more readily than one large array.

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
    """Return the states of relaxing modes at some points of a piecewise linear drive.

    Parameters
    ----------
    poles, starts, ends, steps, initial_state : array_like
        As in ``march``.
    places : ndarray of int, (n,)
        Indices of points between the pieces, increasing: 0 is the first, the number of pieces the last.

    Returns
    -------
    states : ndarray, (poles, n)
        States of the modes, in the unit of the drive.

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
    """Compute the response of oscillating modes to a piecewise linear drive, exact for any step.

    Parameters
    ----------
    poles : array_like of complex, (poles,)
        Real poles, and of each conjugate pair the one with the positive imaginary part [1/s]; real parts
        negative.
    gains : array_like of complex, (outputs, poles)
        Share of every mode in every output [-]; the conjugate mode has the conjugate gain and is implied.
    direct, starts, ends, steps, keep : array_like
        As in ``march``.
    initial_state : array_like of complex, (poles,)
        State at the first point, in the unit of the drive; zeros for rest, the drive itself for the steady state.

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
