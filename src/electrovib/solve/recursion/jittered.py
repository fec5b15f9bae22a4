"""The recursion at unequal time stamps, exact and without a loop over samples."""

from __future__ import annotations

import numpy as np

from electrovib.core.arrays import Numbers, Real
from electrovib.solve.recursion.hold import weights_of
from electrovib.solve.recursion.record import Drive, Modes
from electrovib.solve.recursion.scan import fold_length, states_before

_CHUNK = 64 * 64  # pieces; half and twice the side are slower: calls, then memory


def march_jittered(modes: Modes, drive: Drive, state: Numbers, keep: int) -> tuple[Real, Numbers]:
    """Follow relaxing modes through a drive whose pieces last unequally long.

    Parameters
    ----------
    modes : Modes
        Poles, gains and direct share.
    drive : Drive
        Pieces with one duration each.
    state : ndarray, (poles,)
        State at the first point.
    keep : int
        Every so many points one is put out.

    Returns
    -------
    output : ndarray, (outputs, pieces // keep + 1)
        As in ``march``.
    state : ndarray, (poles,)
        State at the last point.
    """
    pieces = drive.starts.size
    output = np.empty((modes.direct.size, pieces // keep + 1))
    for begin in range(0, pieces, _CHUNK):
        part = slice(begin, min(begin + _CHUNK, pieces))
        before, state = _advance(modes.poles, Drive(*(each[part] for each in drive)), state)
        kept = before[-begin % keep :: keep]
        place = -(-begin // keep)
        output[:, place : place + len(kept)] = (modes.gains @ kept.T).real
    output[:, : -(-pieces // keep)] += modes.direct[:, np.newaxis] * drive.starts[::keep]
    if pieces % keep == 0:
        output[:, -1] = (modes.gains @ state).real + modes.direct * drive.ends[-1]
    return output, state


def _advance(poles: Numbers, drive: Drive, state: Numbers) -> tuple[Numbers, Numbers]:
    """Give the states before every piece of one chunk, (pieces, poles), and after the chunk."""
    pieces = drive.starts.size
    columns, rows = fold_length(pieces)
    starts, ends, steps = (_fold(each, columns, rows) for each in drive)
    decays, first, last = weights_of(steps * poles)
    first *= starts
    last *= ends
    first += last
    final = states_before(first, decays, np.exp(steps.sum(axis=0) * poles), state)
    return first.swapaxes(0, 1).reshape(rows * columns, -1)[:pieces], final


def _fold(samples: Real, columns: int, rows: int) -> Real:
    """Lay samples row by row into (columns, rows, 1); the rest are pieces of no duration."""
    padded = np.zeros(rows * columns)
    padded[: samples.size] = samples
    return padded.reshape(rows, columns).T[:, :, np.newaxis]
