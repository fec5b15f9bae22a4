"""Least squares in the logarithms of all parameters, and reweighting that reduces the largest error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from electrovib.core.arrays import Complex, Real
from electrovib.solve.stack.prony.spectrum import Spectrum, Terms, debye_responses, stacked

# Far above any logarithm of a permittivity, well within the range of floating-point numbers.
LARGEST_LOGARITHM = 200.0
# Share of the smallest permittivity in the band below which a term is negligible.
NOTHING = 1e-12
# The permittivity at high frequency stays above this share of it, because a stack of layers divides by it.
HIGH_FLOOR = 1e-6
# Two relaxation times closer than this in the logarithm are equivalent to one, with an error of about its square.
COINCIDENT = 1e-4
# A relative error below this is due to rounding, not to the number of terms.
EXACT = 1e-9
_FAR_OFF = 1e100


@dataclass(frozen=True)
class LogParameters:
    """Map between Debye terms and unbounded numbers: positive and within the limits by construction.

    The vector holds log high, log strengths, and for each time the logistic parameter of its place between the limits.
    """

    spectrum: Spectrum

    def pack(self, terms: Terms) -> Real:
        """Return the vector of terms whose strengths are above 0."""
        first, span = self._range()
        share = np.clip((np.log(terms.times) - first) / span, 1e-4, 1 - 1e-4)
        high = max(terms.high, 1e-3 * self.spectrum.smallest())
        return np.concatenate([[np.log(high)], np.log(terms.strengths), np.log(share / (1 - share))])

    def unpack(self, vector: Real) -> Terms:
        """Return the terms of a vector of logarithms [1], in the order of the vector."""
        count = vector.size // 2
        first, span = self._range()
        sizes = np.exp(np.clip(vector[: count + 1], -LARGEST_LOGARITHM, LARGEST_LOGARITHM))
        return Terms(float(sizes[0]), sizes[1:], np.exp(first + span * _logistic(vector[count + 1 :])))

    def error(self, vector: Real) -> Complex:
        """Return the relative error [1] at the samples, shape (N,)."""
        return self.spectrum.relative_error(self.unpack(vector))

    def jacobian(self, vector: Real) -> Complex:
        """Return the derivative [1] of the relative error, shape (N, 2M + 1)."""
        terms = self.unpack(vector)
        angular = self.spectrum.angular
        responses = debye_responses(angular, terms.times)
        share = _logistic(vector[vector.size // 2 + 1 :])
        slope = self._range()[1] * share * (1 - share)
        by_time = -terms.strengths * responses**2 * (1j * angular[:, np.newaxis] * terms.times) * slope
        columns = [np.full(angular.size, terms.high), responses * terms.strengths, by_time]
        return np.asarray(np.column_stack(columns) / self.spectrum.target[:, np.newaxis])

    def _range(self) -> tuple[float, float]:
        first = np.log(self.spectrum.fastest)
        return float(first), float(np.log(self.spectrum.slowest) - first)


def least_squares(
    spectrum: Spectrum, terms: Terms, *, evaluations: int, weights: Real | None = None
) -> Terms:
    """Fit all parameters by weighted least squares of the relative error."""
    import scipy.optimize

    parameters = LogParameters(spectrum)
    roots = np.sqrt(np.ones(spectrum.angular.size) if weights is None else weights)

    def residuals(vector: Real) -> Real:
        if not np.all(np.isfinite(vector)):  # a step from a singular matrix, which has to be rejected
            return np.full(2 * roots.size, _FAR_OFF)
        return stacked(parameters.error(vector) * roots)

    found = scipy.optimize.least_squares(
        residuals,
        parameters.pack(terms),
        lambda vector: stacked(parameters.jacobian(vector) * roots[:, np.newaxis]),
        method="lm",
        max_nfev=evaluations,
        xtol=1e-12,
        ftol=1e-10,
        gtol=1e-15,
    )
    return parameters.unpack(found.x)


def level_errors(spectrum: Spectrum, terms: Terms, *, rounds: int = 12) -> Terms:
    """Reduce the largest error, at the cost of the mean error, by raising the weights of the worst samples."""
    weights = np.ones(spectrum.angular.size)
    best, smallest = terms, np.inf
    for step in range(rounds + 1):
        error = np.abs(spectrum.relative_error(terms))
        largest = float(error.max())
        if largest < smallest:
            best, smallest = terms, largest
        if largest < EXACT or step == rounds:
            break
        # The small constant keeps the weight of samples whose error crosses zero above 0.
        weights = weights * (error / largest + 1e-3)
        weights /= weights.mean()
        terms = least_squares(spectrum, terms, evaluations=6, weights=weights)
    return best


def tidied(spectrum: Spectrum, terms: Terms) -> Terms:
    """Sort terms by time, omit those that are negligible in the band, and merge those that coincide."""
    added = terms.strengths * np.abs(debye_responses(spectrum.angular[:1], terms.times))[0]
    used = np.flatnonzero(added > NOTHING * spectrum.smallest())
    order = used[np.argsort(terms.times[used])]
    times, strengths = terms.times[order], terms.strengths[order]
    first = np.flatnonzero(np.diff(np.log(times), prepend=-np.inf) > COINCIDENT)
    if first.size:
        together = np.add.reduceat(strengths, first)
        times, strengths = np.add.reduceat(strengths * times, first) / together, together
    high = max(terms.high, HIGH_FLOOR * spectrum.smallest())
    return Terms(high, strengths, np.minimum(times, spectrum.slowest))


def _logistic(values: Real) -> Real:
    return np.asarray(0.5 * (1 + np.tanh(0.5 * values)))
