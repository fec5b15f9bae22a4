"""The bias that the curvature of a model gives the least-squares estimates of its parameters."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.problem import WeightedProblem

BIASED: Final = 0.05
"""Bias over standard deviation above which a parameter does not count as well determined."""


def curvature_bias(
    problem: WeightedProblem, values: Mapping[str, float], names: Sequence[str], covariance: Real
) -> dict[str, float]:
    """Compute the bias over standard deviation of estimates from the curvature of the predictions.

    To second order the bias is the solution b of J b = -d/2 by least squares, with J the derivatives and d
    the sum of the second differences of the predictions along the columns of the Cholesky factor of the
    covariance (Box 1971). It is infinite where the models refuse values one standard deviation away. A
    representative part of the samples suffices.
    """
    deviations = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(deviations, deviations)
    try:
        factor = np.linalg.cholesky(scaled) * deviations[:, None]
        base = problem.prediction(values)
        second = np.zeros(base.size)
        for column in factor.T:
            for side in (1, -1):
                moved = {name: values[name] + side * each for name, each in zip(names, column, strict=True)}
                second += problem.prediction(dict(values) | moved) - base
    except (ElectrovibError, np.linalg.LinAlgError):
        return dict.fromkeys(names, math.inf)
    slopes = problem.derivatives(values, names=names) * deviations
    found, *_ = np.linalg.lstsq(slopes, -0.5 * second * problem.weights)
    return {name: float(each) for name, each in zip(names, found, strict=True)}
