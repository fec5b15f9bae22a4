"""Groups whose values differ: the spread between them and their mean, where each group has noise of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real

LEVEL: Final = 0.95
_DRAWS: Final = 2000
_HALVINGS: Final = 45
_ROUNDING: Final = 1e-12
"""Smallest standard error of a group, relative to its value."""


@dataclass(frozen=True, kw_only=True)
class RandomEffects:
    """Values of several groups as a common mean, a deviation of each group, and the noise of each group.

    - `mean`: of the population of groups, weighted by the spread and the noise together, with its 95 %
      interval.
    - `between`: standard deviation between groups beyond their noise, by the estimate of Paule and Mandel,
      with its 95 % interval, whose lower end is 0 where noise alone explains the differences.
    - `chi_squared`: sum of the squared deviations from the mean weighted by the noise alone, over the
      variances; its expectation without spread is the number of groups less 1.
    """

    mean: float
    standard_error: float
    lower: float
    upper: float
    between: float
    between_lower: float
    between_upper: float
    chi_squared: float


def random_effects(
    values: Sequence[float], deviations: Sequence[float], *, freedom: Sequence[float] | None = None
) -> RandomEffects:
    """Estimate the spread between groups, and their mean; without `freedom` the errors `deviations` are known.

    The spread fulfils Q(spread) = groups - 1 with Q = sum (value - mean)^2 / (spread^2 + error^2), Paule and
    Mandel, J. Res. NBS 87 (1982) 377. Q has the distribution of chi squared with groups - 1 degrees of
    freedom, so its quantiles give the interval (Q profile: Viechtbauer, Stat. Med. 26 (2007) 37). An error
    that is itself estimated from few points has a distribution too: the interval is that of the solutions
    over draws of all errors and of Q, and that of the mean over the same draws (generalized intervals: Iyer,
    Wang and Mathew, J. Am. Stat. Assoc. 99 (2004) 1060). The draws are stratified and always the same.
    """
    found, errors = np.asarray(values, dtype=float), np.asarray(deviations, dtype=float)
    variances = np.maximum(errors, _ROUNDING * float(np.abs(found).max()) or _ROUNDING)[None, :] ** 2
    squares, drawn = _draws(variances, freedom)
    spreads = _spread(found, drawn, squares)
    lower, upper = np.sqrt(np.quantile(spreads, [0.5 - LEVEL / 2, 0.5 + LEVEL / 2]))
    between = _spread(found, variances, np.array([found.size - 1.0]))
    mean, error = _mean(found, variances + between[:, None])
    means = _mean(found, drawn + spreads[:, None])
    return RandomEffects(
        mean=float(mean[0]),
        standard_error=float(error[0]),
        lower=_quantile(*means, 0.5 - LEVEL / 2),
        upper=_quantile(*means, 0.5 + LEVEL / 2),
        between=math.sqrt(between[0]),
        between_lower=float(lower),
        between_upper=float(upper),
        chi_squared=float(_squares(found, variances)[0]),
    )


def _draws(variances: Real, freedom: Sequence[float] | None) -> tuple[Real, Real]:
    """Draw the sum of squares of the deviations, and the variance of each group by its own noise."""
    from scipy.special import gammaincinv

    groups, rng = variances.size, np.random.default_rng(0)
    even = (np.arange(_DRAWS) + 0.5) / _DRAWS
    squares = 2 * gammaincinv((groups - 1) / 2, rng.permutation(even))
    if freedom is None:
        return squares, np.repeat(variances, _DRAWS, axis=0)
    half = np.asarray(freedom, dtype=float) / 2
    shares = gammaincinv(half, np.column_stack([rng.permutation(even) for _ in range(groups)])) / half
    return squares, variances / shares


def _mean(values: Real, variances: Real) -> tuple[Real, Real]:
    """Weighted mean and its standard error, for each row of variances."""
    weights = 1 / variances
    total = weights.sum(axis=1)
    return (weights * values).sum(axis=1) / total, 1 / np.sqrt(total)


def _squares(values: Real, variances: Real) -> Real:
    """Sum of the weighted squares about the weighted mean, for each row of variances."""
    centre = _mean(values, variances)[0]
    return np.asarray(((values - centre[:, None]) ** 2 / variances).sum(axis=1))


def _spread(values: Real, variances: Real, wanted: Real) -> Real:
    """Variance between groups with which the sum of squares is the wanted one; 0 where it is smaller without any."""
    low = np.zeros(wanted.size)
    high = float(((values - values.mean()) ** 2).sum()) / wanted  # the sum of squares is smaller there
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        above = _squares(values, variances + middle[:, None]) > wanted
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return np.where(_squares(values, variances) > wanted, (low + high) / 2, 0.0)


def _quantile(means: Real, errors: Real, share: float) -> float:
    from scipy.special import ndtr

    reach = 10 * errors.max()
    low, high = float(means.min() - reach), float(means.max() + reach)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if np.mean(ndtr((middle - means) / errors)) < share:
            low = middle
        else:
            high = middle
    return (low + high) / 2
