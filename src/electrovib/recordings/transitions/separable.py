"""Least squares of a model that is linear in its amplitudes, with the correlation of the noise, and the choice of a form."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from electrovib.recordings.correlated import autocovariance, covariance
from electrovib.recordings.fit.least_squares import (
    FreeParameter,
    LeastSquaresEstimate,
    estimate_at,
    least_squares,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from electrovib.core.arrays import Real

_STEP: Final = 1e-5
"""Step of a derivative, relative to a logarithmic parameter, or to the range of another one."""
_CONVERGED: Final = 1e-10
_MOST: Final = 300
_FEWEST: Final = 50
"""Samples of noise from which its correlation is determined."""


@dataclass(frozen=True)
class Whitening:
    """A filter that makes noise of a second-order autoregression independent.

    `coefficients` are a1, a2 of e_k = y_k + a1 y_(k-1) + a2 y_(k-2); zeros leave independent noise as it is.
    """

    coefficients: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, noise: Real) -> Whitening:
        """Determine the filter from noise without signal; fewer than 50 samples give one without effect."""
        if len(noise) < _FEWEST:
            return cls()
        lags = autocovariance(noise - np.mean(noise), fitted=1)[:3]
        if not lags[0] > 0:
            return cls()
        matrix = np.array([[lags[0], lags[1]], [lags[1], lags[0]]])
        found = np.linalg.lstsq(matrix, -lags[1:3], rcond=None)[0]
        return cls((float(found[0]), float(found[1])))

    def __call__(self, values: Real) -> Real:
        """Apply the filter along the first axis, shape (n, ...) to (n - 2, ...)."""
        first, second = self.coefficients
        return np.asarray(values[2:] + first * values[1:-1] + second * values[:-2])


@dataclass(frozen=True, kw_only=True)
class Separable:
    """A model y = sum of amplitudes times columns that depend on nonlinear parameters.

    `columns` maps these parameters to shape (n, k); `names` are those of the k amplitudes; `ranges` is the
    step scale of a parameter that is not logarithmic.
    """

    columns: Callable[[Mapping[str, float]], Real]
    data: Real
    free: Mapping[str, FreeParameter]
    names: Sequence[str]
    ranges: Mapping[str, float]

    def sum_of_squares(self, values: Mapping[str, float]) -> float:
        """Return the least sum of squares over the amplitudes, in the square of the unit of the data."""
        phi = self.columns(values)
        left = phi @ np.linalg.lstsq(phi, self.data, rcond=None)[0] - self.data
        return float(left @ left)

    def solve(
        self, starts: Sequence[Mapping[str, float]], *, whitening: Whitening | None = None
    ) -> LeastSquaresEstimate:
        """Search the nonlinear parameters from several starts, and return the best estimate of all parameters."""
        white = whitening or Whitening()
        data = white(self.data)

        def solved(values: Mapping[str, float]) -> tuple[Real, Real, Real]:
            phi = white(self.columns(values))
            amplitudes = np.asarray(np.linalg.lstsq(phi, data, rcond=None)[0], dtype=float)
            return phi, amplitudes, phi @ amplitudes - data

        def residual(values: Mapping[str, float]) -> Real:
            return solved(values)[2]

        def sloped(values: Mapping[str, float]) -> Real:
            phi, amplitudes, _ = solved(values)
            slopes = self._slopes(values, amplitudes, white)
            basis = np.linalg.qr(phi)[0]
            return np.asarray(slopes - basis @ (basis.T @ slopes))

        best: LeastSquaresEstimate | None = None
        for start in starts:
            free = {name: each.starting_at(start[name]) for name, each in self.free.items()}
            if not free:
                break
            found = least_squares(
                residual,
                free,
                derivatives=sloped,
                noise_is_known=False,
                converged=_CONVERGED,
                most_evaluations=_MOST,
            )
            if best is None or found.sum_of_squares < best.sum_of_squares:
                best = found
        values = dict(best.values) if best is not None else {}
        phi, amplitudes, left = solved(values)
        slopes = np.column_stack([self._slopes(values, amplitudes, white), phi])
        found = estimate_at(
            values | dict(zip(self.names, map(float, amplitudes), strict=True)),
            residual=left,
            derivatives=slopes,
            noise_is_known=False,
            on_bound={} if best is None else best.on_bound,
            evaluations=1 if best is None else best.evaluations,
            converged=best is None or best.converged,
        )
        return dataclasses.replace(found, covariance=_with_correlation(found, slopes, left))

    def inflation(self, estimate: LeastSquaresEstimate, name: str, whitening: Whitening) -> float:
        """Return by how much the correlation that the residuals have left increases the variance of a parameter, at least 1."""
        phi = whitening(self.columns(estimate.values))
        amplitudes = np.array([estimate.values[each] for each in self.names])
        left = phi @ amplitudes - whitening(self.data)
        slopes = np.column_stack([self._slopes(estimate.values, amplitudes, whitening), phi])
        kept = [at for at, each in enumerate((*self.free, *self.names)) if each not in estimate.on_bound]
        alike = autocovariance(left, fitted=len(kept))
        place = [
            at
            for at, each in enumerate((*self.free, *self.names))
            if each not in estimate.on_bound and each == name
        ]
        if not place:
            return 1.0
        own = kept.index(place[0])
        whole, alone = (
            covariance(jacobian=slopes[:, kept], autocovariance=of)[own, own] for of in (alike, alike[:1])
        )
        return max(float(whole / alone), 1.0) if math.isfinite(whole) and alone > 0 else 1.0

    def predicted(self, values: Mapping[str, float]) -> Real:
        """Return the model, shape (n,), at all parameters."""
        return np.asarray(self.columns(values) @ [values[name] for name in self.names])

    def _slopes(self, values: Mapping[str, float], amplitudes: Real, white: Whitening) -> Real:
        """Return the derivatives of the filtered model after the nonlinear parameters, shape (n - 2, parameters)."""
        found = []
        for name, each in self.free.items():
            step = _STEP * (values[name] if each.logarithmic else self.ranges[name])
            more, less = (
                self.columns({**values, name: values[name] + sign * step}) @ amplitudes for sign in (1, -1)
            )
            found.append((more - less) / (2 * step))
        if not found:
            return np.zeros((len(self.data) - 2, 0))
        return white(np.column_stack(found))


def _with_correlation(found: LeastSquaresEstimate, slopes: Real, left: Real) -> Real | None:
    """Return the covariance for residuals that are correlated, by the noise or because the model is not exact."""
    if found.covariance is None:
        return None
    inside = [at for at, name in enumerate(found.values) if name not in found.on_bound]
    alike = covariance(jacobian=slopes[:, inside], autocovariance=autocovariance(left, fitted=len(inside)))
    if not np.isfinite(alike).all():
        return found.covariance
    whole = np.zeros_like(found.covariance)
    whole[np.ix_(inside, inside)] = alike
    return whole


Name = TypeVar("Name")

SUPPORTED: Final = 2.0
"""Difference of the criterion up to which a form has substantial support (Burnham and Anderson 2002)."""


def chosen_form(criterion: Mapping[Name, float]) -> Name:
    """Choose the first form, from the simplest on, whose criterion is at most 2 above the lowest."""
    lowest = min(criterion.values())
    return next(
        name for name, value in criterion.items() if value <= lowest + SUPPORTED or not math.isfinite(lowest)
    )


def above_lowest(criterion: Mapping[str, float]) -> dict[str, float]:
    """Return the differences of a criterion from the lowest, dimensionless."""
    lowest = min(criterion.values())
    return {name: value - lowest if math.isfinite(lowest) else 0.0 for name, value in criterion.items()}
