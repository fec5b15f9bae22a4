"""The recursion of modes one piece after the other: the reference of the fast methods."""

import numpy as np

from electrovib.solve.recursion.blocks import gather, hold_weights


def march_loop(poles, gains, direct, starts, ends, steps, initial_state, *, lag=False):
    """Compute what `march` computes, from the exact weights of each piece.

    Since ``decay = 1 - first - last``, a step is ``x + first (v_start - x) + last (v_end - x)``: a mode much slower than
    the step keeps the digits that are lost when a decay near 1 is rounded. The lag of a mode is advanced separately,
    ``decay (x - v) - (1 - last) (v_end - v_start)``, less the discontinuity of the drive.
    """
    modes, drive, state = gather(poles, gains, direct, starts, ends, steps, initial_state, lag=lag)
    pieces = drive.starts.size
    durations = np.broadcast_to(drive.steps, (pieces,))
    output = np.empty((modes.direct.size, pieces + 1))
    behind = state - drive.starts[0]
    for piece, (start, end, duration) in enumerate(zip(drive.starts, drive.ends, durations, strict=True)):
        if piece == 0 or duration != durations[piece - 1]:
            decay, first, last = hold_weights(modes.poles * duration)
        output[:, piece] = _put_out(modes, start, state, behind)
        state = state + first * (start - state) + last * (end - state)
        behind = decay * behind - (1.0 - last) * (end - start)
        if piece + 1 < pieces:
            behind = behind - (drive.starts[piece + 1] - end)
    output[:, pieces] = _put_out(modes, drive.ends[-1], state, behind)
    return output, state


def _put_out(modes, level, state, lag):
    """Return the outputs at one point."""
    modal = np.where(modes.lag, (modes.gains @ lag).real, (modes.gains @ state).real)
    return np.asarray(modes.direct * level + modal)
