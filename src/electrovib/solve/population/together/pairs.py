"""Distances of the roots of many fingers from the nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


def slopes_and_inverses(nodes: Real, weights: Real, begins: Real, offsets: Real) -> tuple[Real, Real]:
    """Return sum weight/(root - node)^2 and 1/(root - node), of roots that are given by their distance from a node.

    `nodes`, `weights` (nodes, fingers), `begins`, `offsets` (roots, fingers); returns `slope` (roots,
    fingers) [unit of the weights times s2], `inverses` (roots, nodes, fingers) [s].
    """
    (roots, fingers), count = begins.shape, len(nodes)
    inverses, slope = np.empty((roots, count, fingers)), np.empty((roots, fingers))
    for root in range(roots):
        apart = (begins[root] - nodes) + offsets[root]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            np.divide(1.0, apart, out=inverses[root])
            shares = weights * inverses[root] * inverses[root]
        np.add.reduce(shares, axis=0, out=slope[root])
    return slope, inverses
