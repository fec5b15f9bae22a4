"""Exact recursion of relaxing and oscillating modes driven by one piecewise linear voltage or force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.recursion.blocks import EvenMarch, even_states
from electrovib.solve.recursion.hold import gather
from electrovib.solve.recursion.hold import hold_weights as hold_weights
from electrovib.solve.recursion.uneven import UnevenMarch, uneven_states

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
    one = March(poles, gains, direct, starts, ends, steps, initial_state, lag=lag)
    return one.through(slice(0, one.pieces)), one.state


class March:
    """The recursion of `march`, one part of the drive after the other; `state` (poles,) is that at the end of the last part."""

    def __init__(self, *given: ArrayLike, lag: ArrayLike = False) -> None:
        modes, drive, self.state = gather(*given, lag=lag)
        self.outputs, self.pieces = modes.direct.size, drive.starts.size
        self._march = (UnevenMarch if drive.steps.ndim else EvenMarch)(modes, drive, self.state)

    def through(self, part: slice) -> Real:
        """Return the outputs at the beginnings of the next pieces, and after the last of all at its end, (outputs, n)."""
        output = np.empty((self.outputs, part.stop - part.start + (part.stop == self.pieces)))
        self.state = self._march.through(part, output)
        return output


def states_at(
    poles: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    places: Indices,
    *,
    record: int = 0,
) -> Numbers:
    """Return the states of relaxing modes at some points of a piecewise linear drive.

    `places` (n,) in rising order; returns `states` (poles, n). `record` is the number of pieces of the record of which these
    are a part.
    """
    none = np.zeros((0, np.size(poles)))
    modes, drive, state = gather(poles, none, np.zeros(0), starts, ends, steps, initial_state)
    if drive.steps.ndim:
        return uneven_states(modes.poles, drive, state, places, record)
    return even_states(modes, drive, state, places)
