"""The recursion step by step: the reference with which the fast methods are compared."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.recursion.hold import weights_of
from electrovib.solve.recursion.record import gather

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Numbers, Real
    from electrovib.solve.recursion.record import Modes, StraightDrive


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
