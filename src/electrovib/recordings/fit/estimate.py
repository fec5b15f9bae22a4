"""The result of a least-squares fit: values, covariance, criteria, and combinations that the data do not determine."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real

LEAST_DETERMINED: Final = 1e-13
"""Smallest over largest singular value of the scaled derivatives that is above their rounding."""


def aicc(deviance: float, *, counted: int, data: int) -> float:
    """Compute Akaike's criterion with the correction for few data; infinite where `data` is at most `counted` + 1.

    `deviance` is minus twice the logarithm of the largest likelihood; `counted` parameters include the
    noises.
    """
    left = data - counted - 1
    return deviance + 2 * counted + 2 * counted * (counted + 1) / left if left > 0 else math.inf


def bic(deviance: float, *, counted: int, data: int) -> float:
    """Compute the criterion of Schwarz from the deviance, the number of estimated parameters and that of the data."""
    return deviance + counted * math.log(data)


@dataclass(frozen=True, kw_only=True)
class LeastSquaresEstimate:
    """Parameters at the least sum of squares.

    - `covariance`: in the order of `values`, in their units; None where the data do not determine them, with
      the reason in `why_no_covariance`.
    - `sum_of_squares`: dimensionless where the noise is known.
    - `noise_is_known`: whether the covariance follows from a stated noise; else from the scatter of the
      `count` residuals.
    - `on_bound`: parameters that ended on a bound, and on which.
    - `converged`: whether the search ended by itself; `stalled` whether it was ended because further steps
      along a combination that the data do not determine had no effect.
    """

    values: Mapping[str, float]
    covariance: Real | None
    why_no_covariance: str
    sum_of_squares: float
    count: int
    noise_is_known: bool
    on_bound: Mapping[str, str]
    evaluations: int
    converged: bool
    stalled: bool = False

    @property
    def degrees_of_freedom(self) -> int:
        """Residuals less parameters."""
        return self.count - len(self.values)

    @property
    def variance(self) -> float:
        """Sum of squares over the degrees of freedom, the variance of a residual; NaN without any left."""
        return self.sum_of_squares / self.degrees_of_freedom if self.degrees_of_freedom > 0 else math.nan

    @property
    def standard_deviations(self) -> dict[str, float]:
        """Of each parameter, in its unit; NaN where there is none."""
        count = len(self.values)
        found = np.full(count, np.nan) if self.covariance is None else np.sqrt(np.diag(self.covariance))
        return {name: float(each) for name, each in zip(self.values, found, strict=True)}

    @property
    def correlation(self) -> Real:
        """Correlation of the parameters, shape (parameters, parameters); NaN where there is none."""
        if self.covariance is None:
            return np.full((len(self.values), len(self.values)), np.nan)
        scale = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(scale, scale))

    @property
    def _deviance(self) -> float:
        """Minus twice the logarithm of the largest likelihood, up to a constant of the data."""
        if self.noise_is_known:
            return self.sum_of_squares
        return self.count * math.log(max(self.sum_of_squares / self.count, math.ulp(0.0)))

    @property
    def _counted(self) -> int:  # the noise among them where it is not known
        return len(self.values) + (not self.noise_is_known)

    @property
    def aicc(self) -> float:
        """Akaike's criterion with the correction for few data; infinite with as many parameters as data."""
        return aicc(self._deviance, counted=self._counted, data=self.count)

    @property
    def bic(self) -> float:
        """Criterion of Schwarz."""
        return bic(self._deviance, counted=self._counted, data=self.count)

    def quantile(self, level: float) -> float:
        """Return half the width of an interval of this probability [1] over the standard deviation, by Student's t."""
        from scipy.stats import norm, t

        upper = 0.5 + level / 2
        return float(
            norm.ppf(upper) if self.noise_is_known else t.ppf(upper, max(self.degrees_of_freedom, 1))
        )

    def interval(self, name: str, *, level: float = 0.95) -> tuple[float, float]:
        """Interval of one parameter from its standard deviation and Student's t; NaN where there is no standard deviation."""
        half = self.quantile(level) * self.standard_deviations[name]
        return self.values[name] - half, self.values[name] + half


def estimate_at(
    values: Mapping[str, float],
    *,
    residual: Real,
    derivatives: Real,
    noise_is_known: bool,
    on_bound: Mapping[str, str],
    evaluations: int,
    converged: bool,
    stalled: bool = False,
) -> LeastSquaresEstimate:
    """Judge the parameters at which a search has ended; those on a bound have variance 0."""
    inside = [at for at, name in enumerate(values) if name not in on_bound]
    squares = float(residual @ residual)
    left = residual.size - len(values)
    variance = 1.0 if noise_is_known else (squares / left if left > 0 else math.nan)
    covariance: Real | None = np.zeros((len(values), len(values)))
    why = ""
    if inside:
        inner, undetermined = _inverse(derivatives[:, inside], tuple(np.array(list(values))[inside]))
        if undetermined:
            covariance, why = None, undetermined
        elif left <= 0 and not noise_is_known:
            covariance, why = None, "as many parameters as data leave no scatter to judge by: state the noise"
        else:
            assert covariance is not None
            covariance[np.ix_(inside, inside)] = inner * variance
    return LeastSquaresEstimate(
        values=dict(values),
        covariance=covariance,
        why_no_covariance=why,
        sum_of_squares=squares,
        count=residual.size,
        noise_is_known=noise_is_known,
        on_bound=dict(on_bound),
        evaluations=evaluations,
        converged=converged,
        stalled=stalled,
    )


def _inverse(derivatives: Real, names: tuple[str, ...]) -> tuple[Real, str]:
    """Invert the normal matrix by singular values of the scaled derivatives; name the combination that is not determined."""
    scale = np.linalg.norm(derivatives, axis=0)
    if flat := [name for name, each in zip(names, scale, strict=True) if each == 0 or not np.isfinite(each)]:
        return derivatives[:0], f"the data do not depend on {', '.join(flat)}"
    _, singular, rows = np.linalg.svd(derivatives / scale, full_matrices=False)
    if singular[-1] < LEAST_DETERMINED * singular[0]:
        share = np.abs(rows[-1])
        part = [name for name, each in zip(names, share, strict=True) if each > 0.1 * share.max()]
        return derivatives[:0], f"the data determine only combinations of {' and '.join(part)}"
    unscaled = rows.T / singular / scale[:, None]
    return np.asarray(unscaled @ unscaled.T), ""
