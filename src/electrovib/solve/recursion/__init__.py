"""Exact recursion of relaxing and oscillating modes driven by one piecewise linear voltage or force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.recursion.blocks import even_states, march_even
from electrovib.solve.recursion.hold import gather
from electrovib.solve.recursion.hold import hold_weights as hold_weights
from electrovib.solve.recursion.uneven import march_uneven, uneven_states

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Numbers, Real


def march(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    *,
    lag: ArrayLike = False,
) -> tuple[Real, Numbers]:
    """Compute the response of relaxing or oscillating modes to a piecewise linear drive, exact for any step.

    `poles` (poles,), `gains` (outputs, poles) [-], `direct` (outputs,) [-], `starts`, `ends` (pieces,) [V],
    `steps` (pieces,) or () [s], `initial_state` (poles,); returns `output` (outputs, pieces + 1), `final_state` (poles,).

    ``x_k' = p_k (x_k - v)``, ``y = direct v + sum_k gain_k x_k``, that is ``H(s) = direct + sum_k gain_k (-p_k)/(s - p_k)``;
    where `lag` (outputs,) is true, ``x_k - v`` takes the place of ``x_k``. With complex poles the sum is ``Re sum_k w_k gain_k
    x_k``, ``w_k`` 1 for a real pole and 2 for a pair. A value of the
    drive that is not finite also invalidates outputs before it, within its block. An even grid is computed by matrix products
    over blocks of samples, an uneven one by a scan over rows of pieces.
    """
    modes, drive, state = gather(poles, gains, direct, starts, ends, steps, initial_state, lag=lag)
    output = np.empty((modes.direct.size, drive.starts.size + 1))
    return output, (march_uneven if drive.steps.ndim else march_even)(modes, drive, state, output)


def states_at(
    poles: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    places: Indices,
) -> Numbers:
    """Return the states of relaxing modes at some points of a piecewise linear drive.

    `places` (n,) in rising order; returns `states` (poles, n).
    """
    none = np.zeros((0, np.size(poles)))
    modes, drive, state = gather(poles, none, np.zeros(0), starts, ends, steps, initial_state)
    return (uneven_states if drive.steps.ndim else even_states)(modes, drive, state, places)
