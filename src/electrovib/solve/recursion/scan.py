"""Numbers of decaying modes at many points at once, from the push that each stretch of time gives them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Numbers


def fold_length(count: int) -> tuple[int, int]:
    """Return the columns and rows of the squarest table that holds ``count`` successive stretches.

    Parameters
    ----------
    count : int
        Number of stretches, at least 1.

    Returns
    -------
    columns, rows : int
        ``columns * rows >= count``.
    """
    columns = int(np.ceil(np.sqrt(count)))
    return columns, -(-count // columns)


def states_before(pushes: Numbers, decays: Numbers, row_decays: Numbers, state: Numbers) -> Numbers:
    """Replace the push of every stretch by the state of the modes at the beginning of that stretch.

    Parameters
    ----------
    pushes : ndarray, (columns, rows, poles)
        What a stretch adds to the state; stretch ``row * columns + column`` stands at ``[column, row]``.
        Overwritten by the states.
    decays : ndarray, broadcast to the shape of ``pushes``
        What a stretch leaves of the state it found [-].
    row_decays : ndarray, broadcast to (rows, poles)
        The same for a whole row of stretches [-].
    state : ndarray, (poles,)
        State before the first stretch.

    Returns
    -------
    ndarray, (poles,)
        State after the last stretch.

    Notes
    -----
    All rows run side by side from rest, then their beginnings are chained, then all rows run side by side
    again. The chain of roundings is as long as one row plus one column, not as the record.
    """
    table = np.ascontiguousarray(
        pushes
    )  # a column in one stretch of memory: loops over rows and poles at once
    column = np.broadcast_to(decays, pushes.shape[3 - max(2, np.ndim(decays)) :])
    decays = np.broadcast_to(np.ascontiguousarray(column), pushes.shape)
    carried = np.zeros(pushes.shape[1:], pushes.dtype)
    for decay, push in zip(decays, table, strict=True):
        carried *= decay
        carried += push
    for found, decay in zip(carried, np.broadcast_to(row_decays, carried.shape), strict=True):
        after = decay * state + found
        found[:] = state
        state = after
    following = np.empty_like(carried)
    for decay, push in zip(decays, table, strict=True):
        np.multiply(carried, decay, out=following)
        following += push
        push[:] = carried
        carried, following = following, carried
    if table is not pushes:
        pushes[:] = table
    return state
