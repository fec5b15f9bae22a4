"""Relaxations after a corner at very many times: polynomials on intervals that grow with the time since the corner.

A sum of relaxations changes, at a time t after a corner, within about the time t: between t and 2 t a few polynomials
represent it to rounding, however many relaxations there are and however far apart their rates lie.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real

DEGREE: Final = 10
"""Degree of the polynomials: on these intervals the Chebyshev coefficients of exp(-z) beyond it are below 1e-16."""
STRETCHES: Final = 8
"""Number of equal intervals from each time to twice that time."""
FEW: Final = 4 * DEGREE
"""Largest number of times of an interval at each of which the sum is computed."""
_AT_ONCE: Final = 4096
_HELD: Final = 1 << 16
"""Largest number of modes times output times in memory."""
_FORGOTTEN: Final = 745.0
"""Time constants after which an exponential underflows to 0."""


def graded(evaluate: Callable[[Real], Real], since: Real, fastest: float) -> list[Real]:
    """Compute sums of relaxations at many times by interpolation between a few.

    `since` (n,) [s]; returns `outputs` (n,).
    """
    if len(since) <= STRETCHES * FEW:
        return list(evaluate(since))
    doublings = int(np.ceil(np.log2(max(float(since[-1]) * fastest, 1.0)))) + 1
    growing = 2.0 ** np.arange(doublings)[:, None] * (1 + np.arange(STRETCHES) / STRETCHES)
    marks = np.concatenate([np.arange(1, STRETCHES) / STRETCHES, growing.ravel()]) / fastest
    edges = np.unique(np.concatenate([[0], np.searchsorted(since, marks), [len(since)]]))
    longer = np.diff(edges) > FEW
    nodes, to_coefficients = _rule()
    first, last = since[edges[:-1]][longer], since[edges[1:] - 1][longer]
    middle, half = (first + last) / 2, (last - first) / 2
    scale = np.where(half > 0, half, 1.0)  # times that differ by less than their rounding
    alone = np.repeat(~longer, np.diff(edges))
    at_nodes = evaluate((middle[:, None] + half[:, None] * nodes).ravel())
    found = [np.empty(len(since)) for _ in at_nodes]
    if np.any(alone):
        for row, each in zip(found, evaluate(since[alone]), strict=True):
            row[alone] = each
    coefficients = at_nodes.reshape(len(at_nodes), -1, DEGREE + 1) @ to_coefficients.T
    for place, (begin, end) in enumerate(
        zip(edges[:-1][longer].tolist(), edges[1:][longer].tolist(), strict=True)
    ):
        for at in range(begin, end, _AT_ONCE):
            some = slice(at, min(at + _AT_ONCE, end))
            powers = np.polynomial.chebyshev.chebvander((since[some] - middle[place]) / scale[place], DEGREE)
            for row, each in zip(found, coefficients[:, place] @ powers.T, strict=True):
                row[some] = each
    return found


@functools.cache
def _rule() -> tuple[Real, Real]:
    """Return nodes between -1 and 1, and the matrix from values there to Chebyshev coefficients."""
    nodes = np.polynomial.chebyshev.chebpts1(DEGREE + 1)
    return nodes, np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, DEGREE)))


def fading(weights: Real, rates: Real, since: Real) -> list[Real]:
    """Compute the sum of weight exp(-rate t) over modes.

    `weights` (outputs, modes), `rates` (modes,), `since` (n,) [s]; returns `outputs` (n,).
    """

    def evaluate(moments: Real) -> Real:
        found = np.empty((len(weights), len(moments)))
        length = max(1, _HELD // len(rates))
        for first in range(0, len(moments), length):
            some = moments[first : first + length]
            left = rates * some[0] < _FORGOTTEN
            found[:, first : first + length] = weights[:, left] @ np.exp(-np.outer(rates[left], some))
        return found

    fastest = float(np.max(rates, initial=0.0))
    if not len(since) or not fastest:
        return [np.full(len(since), total) for total in weights.sum(axis=1)]
    return graded(evaluate, since, fastest)
