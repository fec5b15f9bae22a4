"""Roots of the secular equations of many fingers, with their distances from the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.together.pairs import slopes_and_inverses
from electrovib.solve.stack.secular import secular_offsets

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

_TOGETHER = 512  # fingers of one call
NEAREST = 1e-30
"""Smallest distance of two nodes [1/s]."""


@dataclass(frozen=True, eq=False)
class ManyRootsOf:
    """Roots between and above the nodes of each finger.

    Parameters
    ----------
    values, slope : ndarray, shape (roots, fingers)
        Roots [1/s], and minus the derivative of the sum of poles there.
    inverses : ndarray, shape (roots, nodes, fingers)
        One over the distance of each root from each node [s].
    """

    values: Real
    slope: Real
    inverses: Real


def roots_of(
    nodes: Real, weights: Real, constant: Any, regular: NDArray[np.bool_]
) -> tuple[ManyRootsOf, NDArray[np.bool_]]:
    """Solve sum weight/(x - node) = constant for many fingers.

    `nodes`, `weights` (nodes, fingers), `constant` (fingers,), `regular` (fingers,); returns `apart`
    (fingers,).
    """
    count, fingers = nodes.shape
    order = np.argsort(nodes, axis=0, kind="stable")
    ordered = np.take_along_axis(nodes, order, axis=0)
    level = np.broadcast_to(np.asarray(constant, dtype=float), fingers)
    above = isinstance(constant, np.ndarray) or constant > 0
    apart = np.all(ordered[1:] - ordered[:-1] >= NEAREST, axis=0) if count > 1 else np.ones(fingers, bool)
    if above:
        apart = apart & (level > 0)
    usable = apart & regular
    heavy = np.take_along_axis(weights, order, axis=0)
    if not np.all(usable):
        ordered = np.where(usable, ordered, np.arange(count, dtype=float)[:, None])
        heavy, level = np.where(usable, heavy, 1.0), np.where(usable, level, 1.0 if above else 0.0)
    offsets, origins = np.empty(nodes.shape), np.empty(nodes.shape, np.intp)

    for begin in range(0, fingers, _TOGETHER):
        some = slice(begin, begin + _TOGETHER)
        offsets[:, some], origins[:, some] = secular_offsets(ordered[:, some], heavy[:, some], level[some])
    roots = count if above else count - 1
    offsets = offsets[:roots]
    begins = np.take_along_axis(ordered, origins[:roots], axis=0)
    slope, inverses = slopes_and_inverses(nodes, weights, begins, offsets)
    return ManyRootsOf(begins + offsets, slope, inverses), apart
