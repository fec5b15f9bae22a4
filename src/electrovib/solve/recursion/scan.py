"""States of decaying modes at many points at once, from the increment of each interval of time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Numbers


def fold_length(count: int) -> tuple[int, int]:
    """Return the columns and rows of the most nearly square table for ``count`` successive intervals."""
    columns = int(np.ceil(np.sqrt(count)))
    return columns, -(-count // columns)


def states_before(pushes: Numbers, decays: Numbers, row_decays: Numbers, state: Numbers) -> Numbers:
    """Replace the increment of every interval by the state of the modes at the beginning of that interval.

    `pushes` (columns, rows, poles) [column, row], `row_decays` (rows, poles) [-], `state` (poles,); returns
    `final_state` (poles,).

    All rows are computed in parallel from rest, then their beginnings are chained, then all rows are computed in
    parallel again. Rounding accumulates over one row plus one column, not over the whole record.
    """
    table = np.ascontiguousarray(pushes)  # a column is contiguous: loops over rows and poles at once
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
