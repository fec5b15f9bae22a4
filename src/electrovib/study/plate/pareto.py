"""Pareto set: the candidates of which no other one is better in one objective and at least as good in all others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def pareto_set(costs: ArrayLike) -> NDArray[np.bool_]:
    """Find the points that no other point dominates, with `costs` (n, objectives) that are each to be minimised.

    A point is dominated by one that is at most as large in every objective and smaller in one; equal points
    are efficient together, a point with NaN is not. In lexicographic order a point can be dominated by an
    earlier one only, and domination is transitive, so each point is compared with the efficient points before
    it.
    """
    values = np.asarray(costs, dtype=float)
    found = np.zeros(len(values), dtype=bool)
    known = np.flatnonzero(~np.any(np.isnan(values), axis=1))
    order = known[np.lexsort(values[known].T[::-1])]
    front = np.empty((len(order), values.shape[1]))
    count = 0
    for place in order.tolist():
        point, before = values[place], front[:count]
        if np.any(np.all(before <= point, axis=1) & np.any(before < point, axis=1)):
            continue
        front[count] = point
        count += 1
        found[place] = True
    return found
