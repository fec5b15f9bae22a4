"""Signals as polynomials on pieces of time between corners: means, squares and extremes of the polynomial are exact."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.electrics.straight import chebyshev_rule

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real

MOST_NODES: Final = 16
"""Chebyshev nodes in a piece, unless there are very many pieces."""
_BEST_PIECES: Final = 4
_NEWTON_STEPS: Final = 4
_LAST: Final = 3
"""Coefficients at the end of a series that measure its resolution: even and odd ones among them."""


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
        inside = (1 + chebyshev_rule(self.nodes - 1)[0]) / 2
        rows = self.edges[:-1, None] + self.lengths[:, None] * np.append(0.0, inside)
        return np.append(rows.ravel(), self.edges[-1])

    def series(self, values: Real) -> Real:
        """Return the Chebyshev coefficients of a signal in each piece.

        `values` (..., n); returns `coefficients` (..., pieces, nodes).
        """
        inside = values[..., :-1].reshape(*values.shape[:-1], -1, self.nodes + 1)[..., 1:]
        coefficients: Real = inside @ chebyshev_rule(self.nodes - 1)[1].T
        return coefficients

    def halved(self, chosen: NDArray[np.bool_]) -> Mesh:
        """Halve the pieces that are chosen, one mark for each."""
        middles = (self.edges[:-1] + self.edges[1:])[chosen] / 2
        return Mesh(np.union1d(self.edges, middles), self.nodes)


def tails(series: Real) -> Real:
    """Return the size of the last coefficients, an estimate of the truncation error of the polynomials.

    `series` (..., pieces, nodes); returns `sizes` (..., pieces).
    """
    sizes = np.abs(series)
    few = series.shape[-1] <= 2 * _LAST  # for so few nodes the last but one is not small yet
    return np.asarray(sizes[..., -1] if few else np.max(sizes[..., -_LAST:], axis=-1))


def mean(mesh: Mesh, series: Real) -> float:
    """Return the mean over the pieces.

    `series` (pieces, nodes).
    """
    return float(mesh.lengths @ (series @ _integrals(series.shape[1])) / (2 * mesh.span))


def mean_square(mesh: Mesh, series: Real) -> float:
    """Return the mean of the square over the pieces."""
    squares = np.sum((series @ _products(series.shape[1])) * series, axis=1)
    return float(mesh.lengths @ squares / (2 * mesh.span))


def taken_from(taken: str, mesh: Mesh, series: Real) -> float:
    """Return a quantity from the polynomials of a signal."""
    if taken == "mean":
        return mean(mesh, series)
    if taken == "rms":
        return math.sqrt(max(mean_square(mesh, series), 0.0))
    if taken == "final":
        return last_value(series)
    return of_extremes(taken, *extremes(series))


def taken_of_many(taken: str, meshes: Sequence[Mesh], series: Real) -> list[float]:
    """Return the same quantity from the polynomials of a signal in many cases.

    `series` (cases, pieces, nodes).
    """
    if taken in {"mean", "rms", "final"}:
        return [taken_from(taken, mesh, each) for mesh, each in zip(meshes, series, strict=True)]
    low, high = -_largest(-series), _largest(series)
    return [of_extremes(taken, *ends) for ends in zip(low.tolist(), high.tolist(), strict=True)]


def of_extremes(taken: str, low: float, high: float) -> float:
    """Return a quantity that follows from the smallest and the largest value."""
    return {"peak": max(abs(low), abs(high)), "maximum": high, "minimum": low, "swing": high - low}[taken]


def extremes(series: Real) -> tuple[float, float]:
    """Return the smallest and the largest value over the pieces, with both sides of every discontinuity.

    `series` (pieces, nodes).
    """
    if not np.all(np.isfinite(series)):
        return np.nan, np.nan
    return -float(_largest(-series[None])[0]), float(_largest(series[None])[0])


def _largest(series: Real) -> Real:
    """Return the largest value of each case, from close points and the zero of the derivative in the best pieces."""
    degree = series.shape[-1]
    angles, values = _close_points(degree)
    seen = series @ values.T
    tops = np.max(seen, axis=-1)
    best = np.argsort(tops, axis=-1)[:, -_BEST_PIECES:, None]
    rows = np.take_along_axis(series, best, axis=1)
    angle = angles[np.argmax(np.take_along_axis(seen, best, axis=1), axis=-1)]
    orders = np.arange(degree)
    for _ in range(_NEWTON_STEPS):  # on sum c cos(k angle), whose derivatives are sums of the same kind
        turned = angle[..., None] * orders
        slope = np.sum(rows * orders * np.sin(turned), axis=-1)
        bend = np.sum(rows * orders**2 * np.cos(turned), axis=-1)
        step = np.divide(slope, bend, out=np.zeros_like(slope), where=bend > 0)
        angle = np.clip(angle - np.clip(step, -angles[1], angles[1]), 0.0, np.pi)
    refined = np.sum(rows * _polynomials(angle, degree), axis=-1)
    return np.asarray(np.maximum(np.max(tops, axis=-1), np.max(refined, axis=-1)))


@functools.cache
def _close_points(degree: int) -> tuple[Real, Real]:
    """Return closely spaced angles from 0 to pi, and all polynomials there."""
    angles = np.pi * np.arange(4 * degree + 1) / (4 * degree)
    return angles, _polynomials(angles, degree)


def _polynomials(angles: Real, degree: int) -> Real:
    """Return the Chebyshev polynomials of cos(angle), shape (..., degree)."""
    return np.asarray(np.cos(angles[..., None] * np.arange(degree)))


def last_value(series: Real) -> float:
    """Return the value at the end of the last piece, before a discontinuity at that time.

    `series` (pieces, nodes).
    """
    return float(np.sum(series[-1]))


@functools.cache
def _integrals(nodes: int) -> Real:
    """Return the integral of every Chebyshev polynomial from -1 to 1."""
    orders = np.arange(nodes)
    even = np.where(orders % 2 == 0, orders, 0)
    return np.asarray(np.where(orders % 2 == 0, 2 / (1.0 - even**2), 0.0))


@functools.cache
def _products(nodes: int) -> Real:
    """Return the integral of every product of two Chebyshev polynomials from -1 to 1."""
    whole, orders = _integrals(2 * nodes), np.arange(nodes)
    sums, differences = orders[:, None] + orders, np.abs(orders[:, None] - orders)
    return np.asarray((whole[sums] + whole[differences]) / 2)
