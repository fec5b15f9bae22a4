"""Sums of decaying exponentials, one for each mode, at many times.

At very many times after a corner a few polynomials replace the exponentials: a sum of relaxations changes, at a time t after
a corner, within about the time t, so that between t and 2 t they represent it to rounding, however far apart the rates lie. At
evenly spaced times the exponentials are products of those at a few times and those within a step of them.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.physics.drive.parts import even_step
from electrovib.solve.recursion.blocks import PRODUCT

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.core.arrays import Real

Rows: TypeAlias = "Sequence[Real] | Real"
"""Outputs over time, one array (n,) or (cases, n) for each."""
MODES_AT_ONCE: Final = 64
"""Modes computed together, so that thousands of them need no matrix of thousands squared."""
GRADED_DEGREE: Final = 10
"""Degree of the polynomials: on these intervals the Chebyshev coefficients of exp(-z) beyond it are below 1e-16."""
STRETCHES: Final = 8
"""Number of equal intervals from each time to twice that time."""
FEW_TIMES: Final = 4 * GRADED_DEGREE
"""Largest number of times of an interval at each of which the sum is computed."""
_AT_ONCE: Final = 4096
_HELD: Final = 1 << 16
"""Largest number of modes times output times in memory."""
_FEWEST_EVEN: Final = 64
"""Number of evenly spaced times from which exponentials are products of those in two tables."""
_ROUNDED: Final = 2e-35
"""Exponential that counts as 0, as it is after 80 time constants."""


def over_modes(gains: Any, rows: Any) -> Any:
    """Return the sum of gain times row over modes, (..., outputs, modes) and (..., modes, n) give (..., outputs, n).

    The last bits of a case do not depend on the others, as those of a matrix product may.
    """
    is_one_case = gains.ndim == 2 and rows.ndim == 2
    return np.asarray(gains @ rows if is_one_case else np.einsum("...om,...mn->...on", gains, rows))


def by_output(found: Real) -> Real:
    """Return outputs (..., outputs, n) with their axis first."""
    return found if found.ndim == 2 else np.moveaxis(found, -2, 0)


def exponentials(rates: Real, since: Any) -> Real:
    """Return exp(-rate s) at times s [s], shape (..., modes, n), 0 where it is below rounding."""
    found: Real = np.exp(-rates[..., None] * since)
    found[found < _ROUNDED] = 0.0  # products of smaller numbers would be subnormal, which takes long
    return found


def graded(evaluate: Callable[[Real], Real], since: Real, fastest: float) -> list[Real]:
    """Compute sums of relaxations at many times by interpolation between a few.

    `evaluate` returns them at any times [s], shape (outputs, times); `since` (n,) [s] are increasing times after a corner, and
    `fastest` is the largest rate [1/s].
    """
    if len(since) <= STRETCHES * FEW_TIMES:
        return list(evaluate(since))
    doublings = int(np.ceil(np.log2(max(float(since[-1]) * fastest, 1.0)))) + 1
    growing = 2.0 ** np.arange(doublings)[:, None] * (1 + np.arange(STRETCHES) / STRETCHES)
    marks = np.concatenate([np.arange(1, STRETCHES) / STRETCHES, growing.ravel()]) / fastest
    edges = np.unique(np.concatenate([[0], np.searchsorted(since, marks), [len(since)]]))
    longer = np.diff(edges) > FEW_TIMES
    nodes, to_coefficients = chebyshev_rule(GRADED_DEGREE)
    first, last = since[edges[:-1]][longer], since[edges[1:] - 1][longer]
    middle, half = (first + last) / 2, (last - first) / 2
    scale = np.where(half > 0, half, 1.0)  # times that differ by less than their rounding
    alone = np.repeat(~longer, np.diff(edges))
    at_nodes = evaluate((middle[:, None] + half[:, None] * nodes).ravel())
    found = [np.empty(len(since)) for _ in at_nodes]
    if np.any(alone):
        for row, each in zip(found, evaluate(since[alone]), strict=True):
            row[alone] = each
    coefficients = at_nodes.reshape(len(at_nodes), -1, GRADED_DEGREE + 1) @ to_coefficients.T
    for place, (begin, end) in enumerate(
        zip(edges[:-1][longer].tolist(), edges[1:][longer].tolist(), strict=True)
    ):
        for at in range(begin, end, _AT_ONCE):
            some = slice(at, min(at + _AT_ONCE, end))
            powers = np.polynomial.chebyshev.chebvander(
                (since[some] - middle[place]) / scale[place], GRADED_DEGREE
            )
            for row, each in zip(found, coefficients[:, place] @ powers.T, strict=True):
                row[some] = each
    return found


@functools.cache
def chebyshev_rule(degree: int) -> tuple[Real, Real]:
    """Return the nodes of the first kind, increasing from -1 to 1, and the matrix from values there to coefficients."""
    nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
    return nodes, np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, degree)))


def fading(weights: Real, rates: Real, since: Real, *, line: Real | None = None, late: float = 0.0) -> Rows:
    """Compute the sum of weight exp(-rate t) over modes and of a straight line, at increasing times, for each output.

    `weights` (outputs, modes) or (cases, outputs, modes), `rates` (modes,) or (cases, modes) [1/s], `line` slope and level
    (..., outputs, 2), `since` (n,) [s], which are differences of times up to `late` [s].
    """
    cases = np.broadcast_shapes(weights.shape[:-2], rates.shape[:-1])
    step = even_step(since, fewest=_FEWEST_EVEN, largest=late)
    if step is not None and weights.shape[-1] <= MODES_AT_ONCE:
        return by_output(_of_two_tables(weights, rates, line, since, step))

    def evaluate(moments: Real) -> Real:
        found = np.zeros((*cases, weights.shape[-2], len(moments)))
        length = max(1, _HELD // max(1, rates.size))
        for first in range(0, len(moments), length):
            some = slice(first, first + length)
            found[..., some] = over_modes(weights, exponentials(rates, moments[some]))
        return found

    fastest = float(np.max(rates, initial=0.0))
    is_graded = fastest > 0 and len(since) and not cases
    rows = graded(evaluate, since, fastest) if is_graded else by_output(evaluate(since))
    if line is None:
        return rows
    lines = by_output(line[..., :1] * since + line[..., 1:])
    return [row + each for row, each in zip(rows, lines, strict=True)]


def _of_two_tables(weights: Real, rates: Real, line: Real | None, since: Real, step: float) -> Real:
    """Return the same at even times: products of what it is at some times and of exponentials within a step of these."""
    inside = step * np.arange(math.isqrt(len(since)))
    begins, late = since[:: len(inside)], exponentials(rates, inside)
    columns = weights[..., None, :] * np.swapaxes(exponentials(rates, begins), -1, -2)[..., None, :, :]
    if line is not None:
        lead = np.broadcast_shapes(line[..., None, :].shape[:-1], columns.shape[:-1])
        reached = line[..., 1:] + line[..., :1] * begins
        straight = np.stack(np.broadcast_arrays(reached, line[..., :1]), axis=-1)
        columns = np.concatenate(
            [np.broadcast_to(each, (*lead, each.shape[-1])) for each in (columns, straight)], axis=-1
        )
        under = np.stack([np.ones(len(inside)), inside])
        late = np.concatenate([late, np.broadcast_to(under, (*late.shape[:-2], *under.shape))], axis=-2)
    found = np.empty((*columns.shape[:-1], len(inside)))
    height = max(1, PRODUCT // max(1, late.shape[-2] * len(inside)))
    for first in range(0, columns.shape[-2], height):
        some = slice(first, first + height)
        np.matmul(columns[..., some, :], late[..., None, :, :], out=found[..., some, :])
    return found.reshape(*found.shape[:-2], -1)[..., : len(since)]
