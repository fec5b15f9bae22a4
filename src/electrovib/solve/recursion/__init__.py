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

    `poles` (poles,), `gains` (outputs, poles) [-], `direct` (outputs,) [-], `starts`, `ends` (pieces,) [V],
    `steps` (pieces,) [s], `initial_state` (poles,); returns `output` (outputs, pieces // keep + 1) [-1],
    `final_state` (poles,).

    ``x_k' = p_k (x_k - v)``, ``y = direct v + sum_k gain_k x_k``, that is ``H(s) = direct + sum_k gain_k
    (-p_k)/(s - p_k)``. The result equals that of ``march_loop`` up to rounding. A value of the drive that is
    not finite also invalidates outputs before it, within its block.  An even grid is computed by matrix
    products over blocks of samples, an uneven one by a scan over rows of pieces.
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

    Returns `outputs` (pieces + 1,).
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

    `places` (n,); returns `states` (poles, n).
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

    `poles` (poles,), `gains` (outputs, poles) [-], `initial_state` (poles,); returns `output` (outputs,
    pieces // keep + 1), `final_state` (poles,).

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
