"""Pieces of time with Chebyshev nodes inside."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.polynomial import chebyshev

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


MOST_NODES: Final = 16
"""Chebyshev nodes in a piece, unless there are very many pieces."""


@dataclass(frozen=True)
class Mesh:
    """Pieces of time with Chebyshev nodes inside, so that a discontinuity at an end belongs to neither side.

    Parameters
    ----------
    edges : ndarray, shape (pieces + 1,)
        Ends of the pieces [s], increasing.
    nodes : int
        Number of nodes in each piece.
    """

    edges: Real
    nodes: int = MOST_NODES

    @property
    def lengths(self) -> Real:
        """Duration of each piece [s]."""
        return np.diff(self.edges)

    @property
    def span(self) -> float:
        """Time from the first edge to the last [s]."""
        return float(self.edges[-1] - self.edges[0])

    def times(self) -> Real:
        """Return all edges and nodes [s], increasing: a piece's first edge, its nodes, and last the end."""
        inside = (1 + _points(self.nodes)) / 2
        rows = self.edges[:-1, None] + self.lengths[:, None] * np.append(0.0, inside)
        return np.append(rows.ravel(), self.edges[-1])

    def series(self, values: Real) -> Real:
        """Return the Chebyshev coefficients of a signal in each piece.

        `values` (n,); returns `coefficients` (pieces, nodes).
        """
        inside = values[:-1].reshape(len(self.lengths), self.nodes + 1)[:, 1:]
        coefficients: Real = inside @ _transform(self.nodes).T
        return coefficients

    def halved(self, chosen: NDArray[np.bool_]) -> Mesh:
        """Halve some pieces.

        `chosen` (pieces,).
        """
        middles = (self.edges[:-1] + self.edges[1:])[chosen] / 2
        return Mesh(np.union1d(self.edges, middles), self.nodes)


@functools.cache
def _points(nodes: int) -> Real:
    """Return the Chebyshev points of the first kind, increasing, from -1 to 1 without the ends."""
    return np.asarray(-np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes))


@functools.cache
def _transform(nodes: int) -> Real:
    """Return the matrix from values at the nodes to Chebyshev coefficients."""
    weights = 2 / nodes * chebyshev.chebvander(_points(nodes), nodes - 1).T
    weights[0] /= 2
    return np.asarray(weights)
