"""What relaxes after a corner, at very many times: polynomials on stretches that grow with the time since then.

A sum of relaxations changes, at a time t after a corner, in about the time t: between t and 2 t one polynomial holds
it to rounding, however many relaxations there are and however far apart their rates lie.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real

DEGREE: Final = 10
"""Of the polynomials: on these stretches exp(-z) has no larger Chebyshev coefficients beyond it than 1e-16 for any z."""
STRETCHES: Final = 8
"""Equal ones from each time to twice that time."""
FEW: Final = 4 * DEGREE
"""Times of a stretch up to which each of them is computed."""
_AT_ONCE: Final = 4096
_HELD: Final = 1 << 16
"""Numbers of modes and times held at once."""
_FORGOTTEN: Final = 745.0
"""Time constants after which nothing is left that a number could hold."""


def graded(evaluate: Callable[[Real], Real], since: Real, fastest: float) -> list[Real]:
    """Compute sums of relaxations at many times, from a few.

    Parameters
    ----------
    evaluate : callable
        Outputs of shape (outputs, n) at times since a corner, shape (n,) [s]: sums of exp(-rate t) and of
        polynomials of low degree.
    since : ndarray, shape (n,)
        Increasing, >= 0 [s].
    fastest : float
        Largest of the rates [1/s], > 0.

    Returns
    -------
    list of ndarray, shape (n,)
        One for each output, in the unit of `evaluate`; off by some roundings of the largest value in each stretch.
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
            powers = np.polynomial.chebyshev.chebvander((since[some] - middle[place]) / half[place], DEGREE)
            for row, each in zip(found, coefficients[:, place] @ powers.T, strict=True):
                row[some] = each
    return found


@functools.cache
def _rule() -> tuple[Real, Real]:
    """Nodes between -1 and 1, and Chebyshev's coefficients from the values there."""
    nodes = np.polynomial.chebyshev.chebpts1(DEGREE + 1)
    return nodes, np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, DEGREE)))


def fading(weights: Real, rates: Real, since: Real) -> list[Real]:
    """Sum weight exp(-rate t).

    Parameters
    ----------
    weights : ndarray, shape (outputs, modes)
        At time 0, in any unit.
    rates : ndarray, shape (modes,)
        1/s, >= 0.
    since : ndarray, shape (n,)
        Increasing, >= 0 [s].

    Returns
    -------
    list of ndarray, shape (n,)
        One for each output, in the unit of the weights.
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
