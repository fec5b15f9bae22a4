"""Distances of the roots of many fingers from the nodes, in numpy or compiled: the same bits."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.kernels.choice import compiled

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


def slopes_and_inverses(nodes: Real, weights: Real, begins: Real, offsets: Real) -> tuple[Real, Real]:
    """Return sum weight/(root - node)^2 and 1/(root - node), of roots that are given by their distance from a node.

    `nodes`, `weights` (nodes, fingers), `begins`, `offsets` (roots, fingers); returns `slope` (roots,
    fingers) [unit of the weights times s2], `inverses` (roots, nodes, fingers) [s].

    Products and sums are formed in the same order by numpy and by the compiled function, without fused operations.
    """
    (roots, fingers), count = begins.shape, len(nodes)
    inverses, slope = np.empty((roots, count, fingers)), np.empty((roots, fingers))
    if compiled() is not None:
        _function()(nodes, weights, begins, offsets, inverses, slope)
        return slope, inverses
    for root in range(roots):
        apart = (begins[root] - nodes) + offsets[root]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            np.divide(1.0, apart, out=inverses[root])
            shares = weights * inverses[root] * inverses[root]
        np.add.reduce(shares, axis=0, out=slope[root])
    return slope, inverses


@functools.cache
def _function() -> Any:
    """Return the compiled function; other threads run meanwhile."""
    from numba import njit

    try:
        return njit(_in_loops, cache=True, error_model="numpy", nogil=True)
    except RuntimeError:  # no folder for the cache
        return njit(_in_loops, error_model="numpy", nogil=True)


def _in_loops(nodes: Real, weights: Real, begins: Real, offsets: Real, inverses: Real, slope: Real) -> None:
    """Write the results of `slopes_and_inverses`, in the part of Python that numba compiles."""
    roots, count, fingers = inverses.shape
    for root in range(roots):
        slope[root] = 0.0
        for node in range(count):
            for finger in range(fingers):
                inverse = 1.0 / ((begins[root, finger] - nodes[node, finger]) + offsets[root, finger])
                inverses[root, node, finger] = inverse
                slope[root, finger] += (weights[node, finger] * inverse) * inverse
