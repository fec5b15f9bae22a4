"""Sobol indices of independent inputs, with bootstrap intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.scenario.space import Space

LEVEL: Final = 0.95
"""Probability of the intervals."""
_RESAMPLES: Final = 999
_BLOCK: Final = 100
"""Resamples that are computed together; it bounds the memory."""
_SMALLEST: Final = 2.0**-53


@dataclass(frozen=True, kw_only=True)
class Indices:
    """Sobol indices of all inputs, ends (2, inputs) of 95 % intervals, and the function at 2 n independent draws."""

    first: Real
    total: Real
    first_interval: Real
    total_interval: Real
    sample: Real


def sobol(space: Space, function: Callable[[Mapping[str, Real]], Real], *, n: int, seed: int) -> Indices:
    """Compute the Sobol indices of a function of the parameters of a space, in the order of ``space.inputs``.

    The function takes arrays (m,) by path and returns values (m,); with n base draws, a power of 2, it is
    evaluated n (inputs + 2) times. Parameters that depend on each other are one input. The estimators are
    those of Saltelli et al. 2010, as in `scipy.stats.sobol_indices` (which fails for a single input), on
    scrambled Sobol points; inputs with relations are random draws, because a draw that breaks a relation is
    repeated. The intervals are percentiles of a bootstrap over the draws.
    """
    check_power(n)
    first, second = _draws(space, n, seed)
    mixtures = (
        first | {path: second[path] for path in streams if path in second}
        for streams in space.inputs.values()
    )
    columns = [first, second, *mixtures]
    joined = {path: np.concatenate([each[path] for each in columns]) for path in first}
    values = np.asarray(function(joined)).reshape(len(columns), n)
    _check_values(values, joined)
    a, b, mixed = values[0], values[1], values[2:]
    terms = _terms(a, b, mixed)
    first_order, total_order = _estimates(np.full((1, n), 1 / n), terms)[0]
    low, high = _bootstrap(terms, np.random.default_rng(seed))
    return Indices(
        first=first_order,
        total=total_order,
        first_interval=np.stack([low[0], high[0]]),
        total_interval=np.stack([low[1], high[1]]),
        sample=np.concatenate([a, b]),
    )


def check_power(n: int) -> None:
    """Refuse a number of draws that is no power of 2."""
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 2 or n & (n - 1):
        near = 2 ** max(1, round(float(np.log2(max(float(n), 2.0))))) if isinstance(n, (int, float)) else 4096
        raise InputError(f"n = {n!r}: expected a power of 2, for instance {near}")


def _check_values(values: Real, at: Mapping[str, Real]) -> None:
    flat = values.ravel()
    wrong = ~np.isfinite(flat)
    if wrong.any():
        where = int(np.argmax(wrong))
        point = ", ".join(f"{path} = {each[where]:.4g}" for path, each in at.items())
        raise InputError(
            f"the quantity is not a finite number for a share of {wrong.mean():.2g} of the draws, for instance at {point} (SI)."
            " Truncate the distributions, or choose another quantity"
        )
    if np.ptp(values[:2]) == 0:
        raise InputError(
            "the quantity has the same value for every draw: it does not depend on these parameters"
        )


def _draws(space: Space, n: int, seed: int) -> tuple[dict[str, Real], dict[str, Real]]:
    """Return the values of the parameters in two independent samples of n draws."""
    from scipy.stats import qmc

    related = {path for pair in space.relations for path in pair}
    repeated = [streams for streams in space.inputs.values() if related & set(streams)]
    drawn = {path for streams in repeated for path in streams if path in space.paths}
    streams = [each for each in space.streams if not any(each in other for other in repeated)]
    found: tuple[dict[str, Real], dict[str, Real]] = ({}, {})
    if streams:
        points = qmc.Sobol(2 * len(streams), seed=np.random.default_rng(seed)).random(n)
        points = np.clip(points, _SMALLEST, 1 - _SMALLEST)
        for half, columns in zip(found, np.split(points, 2, axis=1), strict=True):
            shares = dict(zip(streams, np.ascontiguousarray(columns.T), strict=True))
            half.update(space.values(shares))
    if drawn:
        both = space.draw(seed, 0, 2 * n)
        for half, part in zip(found, (slice(0, n), slice(n, 2 * n)), strict=True):
            half.update({path: both[path][part] for path in drawn})
    return found


def _terms(a: Real, b: Real, mixed: Real) -> Real:
    """Return the quantities whose means over the draws give all indices, shape (n, 2 + 2 inputs)."""
    middle = 0.5 * (a.mean() + b.mean())
    a, b, mixed = a - middle, b - middle, mixed - middle
    return np.concatenate([[a + b, a * a + b * b], b * (mixed - a), 0.5 * (a - mixed) ** 2]).T


def _estimates(weights: Real, terms: Real) -> Real:
    """Return first-order and total indices for each row of weights of the draws, shape (rows, 2, inputs)."""
    means = weights @ terms
    variance = means[:, 1] / 2 - (means[:, 0] / 2) ** 2
    found: Real = (means[:, 2:] / variance[:, None]).reshape(len(weights), 2, -1)
    return found


def _bootstrap(terms: Real, generator: np.random.Generator) -> tuple[Real, Real]:
    """Return the ends of percentile intervals of first-order and total indices, each of shape (2, inputs).

    The bootstrap of scipy forms all jackknife samples of its corrected intervals at once, which takes n**2 numbers.
    """
    count, found = len(terms), []
    for start in range(0, _RESAMPLES, _BLOCK):
        size = min(_BLOCK, _RESAMPLES - start)
        weights = generator.multinomial(count, np.full(count, 1 / count), size=size) / count
        found.append(_estimates(weights, terms))
    tail = (1 - LEVEL) / 2
    low, high = np.quantile(np.concatenate(found), [tail, 1 - tail], axis=0)
    return np.asarray(low), np.asarray(high)
