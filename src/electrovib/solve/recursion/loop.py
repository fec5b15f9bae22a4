"""The recursion written out step by step: the reference that the fast ways are judged by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.recursion.hold import hold_weights
from electrovib.solve.recursion.record import gather

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def march_loop(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Follow relaxing modes through a drive of straight pieces, one piece after the other.

    Parameters
    ----------
    poles, gains, direct, starts, ends, steps, initial_state : array_like
        As in ``march``.

    Returns
    -------
    output : ndarray, (outputs, pieces + 1)
        As in ``march``.
    final_state : ndarray, (poles,)
        As in ``march``.

    Raises
    ------
    InputError
        As in ``march``.

    Notes
    -----
    Since ``decay = 1 - first - last``, a step is ``x + first (v_start - x) + last (v_end - x)``: a mode
    much slower than the step keeps the digits that are lost when its decay is rounded next to 1.
    """
    modes, drive, state = gather(poles, gains, direct, starts, ends, steps, initial_state)
    pieces = drive.starts.size
    durations = np.broadcast_to(drive.steps, (pieces,))
    output = np.empty((modes.direct.size, pieces + 1))
    for piece, (start, end, duration) in enumerate(zip(drive.starts, drive.ends, durations, strict=True)):
        if piece == 0 or duration != durations[piece - 1]:
            _, first, last = hold_weights(modes.poles * duration)
        output[:, piece] = modes.direct * start + modes.gains @ state
        state = state + first * (start - state) + last * (end - state)
    output[:, pieces] = modes.direct * drive.ends[-1] + modes.gains @ state
    return output, state
