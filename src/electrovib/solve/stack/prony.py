"""Debye terms of a spectrum of the bound permittivity, given as a function or as a table.

Non-negative least squares on fixed grids of relaxation times gives the start, least squares in the logarithms of all
parameters refines it, and reweighting reduces the largest error.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.core.arrays import Complex, Real
from electrovib.core.errors import InputError
from electrovib.physics.debye_sum import DebyeSum

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

SAMPLES_PER_DECADE = 15
# Terms this factor beyond the band act in it as a constant, or as conduction, to less than 1 part in 100.
SLOW_ROOM, FAST_ROOM = 100.0, 1000.0
# Number of points for which twice the estimated noise is allowed, because the estimate itself is uncertain.
FEW_POINTS = 20
# scipy's nnls may fail on long, nearly dependent grids; it does not for 59 times and the high term.
DENSE = 59
# Decades by which the end points of the even grid may lie beyond the band.
SLOW_REACH = (0.0, 0.2, 0.4, 0.7, 1.0)
FAST_REACH = (0.0, 0.2, 0.4, 0.7, 1.0)
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


@dataclass(frozen=True, kw_only=True)
class PronyFit:
    """Debye terms of a spectrum, with their error.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error, rms_error : float
        Largest value and root mean square of the modulus of fit/target - 1 over ``band`` [1].
    band : tuple of float
        Lowest and highest frequency of the target [Hz].
    """

    debye: DebyeSum
    largest_error: float
    rms_error: float
    band: tuple[float, float]


def fit_debye(
    bound_permittivity: Callable[[Real], npt.ArrayLike],
    *,
    low: float,
    high: float,
    terms: int = 14,
    slowest: float | None = None,
) -> PronyFit:
    """Reduce a law of the bound permittivity to Debye terms that are passive by construction.

    Reweighting after C. L. Lawson (thesis, University of California, Los Angeles, 1961) reduces the largest
    relative error. Non-negative terms exist for Cole-Cole and constant-phase laws, and for Havriliak-Negami
    laws with alpha <= 1 and alpha beta <= 1; for a law without them the result is the nearest passive sum, with
    its ``largest_error``. Outside the band the sum is passive but does not describe the material.
    """
    check_range(low=low, high=high, terms=terms, slowest=slowest)
    decades = np.log10(high / low)
    count = max(int(np.ceil(SAMPLES_PER_DECADE * decades)) + 1, 4 * terms + 1)
    frequency = np.geomspace(low, high, count)
    target = evaluated(bound_permittivity, frequency)
    refuse_active(frequency, target, allowed=1e-9)
    spectrum = _spectrum(frequency, target, SLOW_ROOM / (2 * np.pi * low) if slowest is None else slowest)
    found = tidied(spectrum, level_errors(spectrum, _least(spectrum, terms)))
    check = np.geomspace(low, high, 4 * count)
    return _report(found, check, evaluated(bound_permittivity, check))


def fit_debye_table(
    frequency: npt.ArrayLike,
    bound_permittivity: npt.ArrayLike,
    *,
    terms: int = 14,
    slowest: float | None = None,
) -> PronyFit:
    """Reduce a measured spectrum of the bound permittivity to Debye terms that are passive by construction.

    `frequency` (N,) [Hz], `bound_permittivity` (N,).

    Plain least squares of the relative error: reweighting towards the worst point would follow the noise.
    By default no term is slower than 1/(2 pi) of the lowest frequency, because noisy data cannot distinguish such a term
    from conduction; loss of that kind in the table remains as an error at the lowest frequencies (6 % for a
    constant phase of exponent 0.75). Where the conduction is known, a ``slowest`` of ten times the default allows
    the fit to represent that loss by relaxations.
    """
    hertz, target = checked_table(frequency, bound_permittivity)
    low, high = float(hertz[0]), float(hertz[-1])
    check_range(low=low, high=high, terms=terms, slowest=slowest)
    refuse_active(hertz, target, allowed=noise_limit(target))
    spectrum = _spectrum(hertz, target, 1 / (2 * np.pi * low) if slowest is None else slowest)
    found = _least(spectrum, min(terms, hertz.size - 1))
    return _report(found, hertz, target)


def _least(spectrum: Spectrum, terms: int) -> Terms:
    starts = [clustered_start(spectrum, terms), even_start(spectrum, terms)]
    polished = [
        tidied(spectrum, least_squares(spectrum, start, evaluations=80)) if start.times.size else start
        for start in starts
    ]
    errors = [float(np.linalg.norm(spectrum.relative_error(one))) for one in polished]
    good = [one for one, error in zip(polished, errors, strict=True) if error <= max(min(errors), EXACT)]
    return min(good, key=lambda one: one.times.size)


def _spectrum(frequency: Real, target: Complex, slowest: float) -> Spectrum:
    return Spectrum(
        angular=2 * np.pi * frequency,
        target=target,
        fastest=1 / (2 * np.pi * frequency[-1] * FAST_ROOM),
        slowest=slowest,
    )


def _report(terms: Terms, frequency: Real, target: Complex) -> PronyFit:
    debye = DebyeSum(terms.high, tuple(map(float, terms.strengths)), tuple(map(float, terms.times)))
    error = np.abs(debye.permittivity(frequency) / target - 1)
    return PronyFit(
        debye=debye,
        largest_error=float(error.max()),
        rms_error=float(np.sqrt(np.mean(error**2))),
        band=(float(frequency[0]), float(frequency[-1])),
    )


def check_range(*, low: float, high: float, terms: int, slowest: float | None) -> None:
    """Refuse a band, a number of terms or a slowest time out of range."""
    problems = []
    if not (0 < low < high < np.inf):
        problems.append(f"band {low!r} to {high!r} Hz: needs 0 < low < high.")
    if not 1 <= terms <= DENSE:
        problems.append(
            f"terms = {terms!r}: 1 to {DENSE} Debye terms are allowed; 14 suffice for six decades."
        )
    if not problems and slowest is not None and not 1 / (2 * np.pi * high) < slowest < np.inf:
        problems.append(
            f"slowest = {slowest!r} s: must lie above 1/(2 pi high) = {1 / (2 * np.pi * high):.3g} s."
        )
    if problems:
        raise InputError(problems)


def evaluated(bound_permittivity: Callable[[Real], npt.ArrayLike], frequency: Real) -> Complex:
    """Return a law of the bound permittivity at given frequencies, refusing unphysical values.

    `frequency` (N,) [Hz]; returns `target` (N,).
    """
    target = np.asarray(bound_permittivity(frequency), dtype=complex)
    if target.shape != frequency.shape:
        raise InputError(
            f"the bound permittivity has shape {target.shape} for frequencies of shape {frequency.shape}: "
            "expected one value for each frequency."
        )
    _refuse_unphysical(frequency, target)
    return target


def checked_table(frequency: npt.ArrayLike, bound_permittivity: npt.ArrayLike) -> tuple[Real, Complex]:
    """Return frequencies [Hz] and permittivities of a table in rising order, refusing unphysical values."""
    hertz = np.asarray(frequency, dtype=float)
    target = np.asarray(bound_permittivity, dtype=complex)
    if hertz.ndim != 1 or hertz.shape != target.shape or hertz.size < 3:
        raise InputError(
            f"frequency has shape {hertz.shape} and bound permittivity {target.shape}: "
            "expected two lists of equal length, at least 3 points."
        )
    if not np.all(np.isfinite(hertz) & (hertz > 0)):
        raise InputError("frequency: all values must be finite and above 0 Hz.")
    order = np.argsort(hertz, kind="stable")
    _refuse_unphysical(hertz[order], target[order])
    return hertz[order], target[order]


def _refuse_unphysical(frequency: Real, target: Complex) -> None:
    for wrong, what in (
        (~np.isfinite(target), "is not finite"),
        (target.real <= 0, "has a real part <= 0, which no sum of Debye terms has"),
    ):
        if wrong.any():
            at = int(np.argmax(wrong))
            raise InputError(f"bound permittivity = {target[at]:.4g} at {frequency[at]:.4g} Hz {what}.")


def noise_limit(target: Complex) -> float:
    """Return five standard deviations of a spectrum's loss tangent [1] from differences; more for few points."""
    tangent = -target.imag / np.abs(target)
    order = min(3, tangent.size - 1)
    jumps = np.abs(np.diff(tangent, order))
    # The median of many differences excludes those of a steep relaxation; of few the largest is the safe choice.
    typical = np.median(jumps) / 0.6745 if jumps.size >= 12 else np.max(jumps)
    # Noise enters an n-th difference with binomial(2n, n) times its variance; 1 mrad is that of a good instrument.
    deviation = float(typical) / math.sqrt(math.comb(2 * order, order))
    return 1e-3 + 5 * deviation * (1 + FEW_POINTS / tangent.size)


def refuse_active(frequency: Real, target: Complex, *, allowed: float) -> None:
    """Refuse a negative loss beyond a loss tangent, at one point or in the mean of five.

    `frequency` (N,) [Hz], `target` (N,).
    """
    gain = target.imag / np.abs(target)
    width = min(5, gain.size)
    smooth = np.convolve(gain, np.full(width, 1 / width), mode="same")
    excess = np.maximum(gain - allowed, smooth - allowed / np.sqrt(width))
    if (excess > 0).any():
        at = int(np.argmax(excess))
        raise InputError(
            f"bound permittivity = {target[at]:.4g} near {frequency[at]:.4g} Hz has eps'' < 0: the dielectric "
            "would be active. Write it as eps' - j eps'' with eps'' >= 0; check the sign of the loss, "
            "and that not more conduction was subtracted than the material has."
        )


def nonnegative_terms(spectrum: Spectrum, times: Real) -> tuple[Terms, float]:
    """Fit non-negative strengths for given relaxation times.

    `times` (M,) [s].
    """
    from scipy.optimize import lsq_linear, nnls

    columns = np.column_stack([np.ones(spectrum.angular.size), debye_responses(spectrum.angular, times)])
    matrix = stacked(columns / spectrum.target[:, np.newaxis])
    sizes = np.linalg.norm(matrix, axis=0)
    matrix = matrix / sizes
    wanted = stacked(np.ones(spectrum.angular.size, dtype=complex))
    try:
        weights, misfit = nnls(matrix, wanted, maxiter=50 * matrix.shape[1])
    except (
        RuntimeError
    ):  # nnls reached its limit of iterations: an interior-point solution is as good a start
        solution = lsq_linear(matrix, wanted, bounds=(0, np.inf))
        weights, misfit = solution.x, float(np.sqrt(2 * solution.cost))
    weights = weights / sizes
    return Terms(float(weights[0]), weights[1:], times), float(misfit)


def even_start(spectrum: Spectrum, count: int) -> Terms:
    """Return terms with ``count`` times even in the logarithm, with the best end points of a coarse search."""
    low, high = spectrum.grid_limits()
    best, smallest = None, np.inf
    for slow, fast in itertools.product(SLOW_REACH, FAST_REACH):
        first = max(low, 10.0**-fast / spectrum.angular[-1])
        last = min(high, 10.0**slow / spectrum.angular[0])
        terms, misfit = nonnegative_terms(spectrum, np.geomspace(first, last, count))
        if misfit < smallest:
            best, smallest = terms, misfit
    assert best is not None
    used = best.strengths > 0
    return Terms(best.high, best.strengths[used], best.times[used])


def clustered_start(spectrum: Spectrum, count: int) -> Terms:
    """Return the solution on a dense grid, with neighbours merged until at most ``count`` terms remain.

    A relaxation between two grid times appears in the solution as a pair, which is one term.
    """
    terms, _ = nonnegative_terms(spectrum, np.geomspace(*spectrum.grid_limits(), DENSE))
    used = np.flatnonzero(terms.strengths > 0)
    runs = np.split(used, np.flatnonzero(np.diff(used) > 1) + 1) if used.size else []
    pairs = [pair for run in runs for pair in np.array_split(run, max(1, round(run.size / 2)))]
    logs = np.log(terms.times)
    strengths = [float(terms.strengths[pair].sum()) for pair in pairs]
    places = [float(np.average(logs[pair], weights=terms.strengths[pair])) for pair in pairs]
    while len(places) > count:
        near = int(np.argmin(np.diff(places)))
        total = strengths[near] + strengths[near + 1]
        share = strengths[near] / total
        places[near : near + 2] = [share * places[near] + (1 - share) * places[near + 1]]
        strengths[near : near + 2] = [total]
    return Terms(terms.high, np.asarray(strengths, dtype=float), np.exp(np.asarray(places, dtype=float)))


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


class Terms(NamedTuple):
    """Debye terms as arrays, sorted from fast to slow."""

    high: float
    strengths: Real
    times: Real


@dataclass(frozen=True, kw_only=True)
class Spectrum:
    """Samples of a bound permittivity, and the range allowed for relaxation times.

    Parameters
    ----------
    angular : ndarray, shape (N,)
        Angular frequencies, rising [rad/s].
    target : ndarray of complex, shape (N,)
        Relative permittivity without conduction [1].
    fastest, slowest : float
        Limits of the relaxation times, 0 < fastest < slowest [s].
    """

    angular: Real
    target: Complex
    fastest: float
    slowest: float

    def grid_limits(self) -> tuple[float, float]:
        """Return the range of initial relaxation times: one decade beyond the band, within the limits [s]."""
        first, last = 0.1 / self.angular[-1], 10 / self.angular[0]
        # Just inside the limits, at which the map of polish.py has a slope of 0.
        return max(float(first), 1.01 * self.fastest), min(float(last), self.slowest / 1.01)

    def smallest(self) -> float:
        """Return the smallest modulus of the permittivity in the band."""
        return float(np.abs(self.target).min())

    def relative_error(self, terms: Terms) -> Complex:
        """Return fit/target - 1 at the samples, shape (N,)."""
        response = terms.high + debye_responses(self.angular, terms.times) @ terms.strengths
        return np.asarray(response / self.target - 1)


def debye_responses(angular: Real, times: Real) -> Complex:
    """Return 1/(1 + j w tau) at angular frequencies (N,) [rad/s] for times (M,) [s], shape (N, M)."""
    return np.asarray(1 / (1 + 1j * angular[:, np.newaxis] * times))


def stacked(values: Complex) -> Real:
    """Return real parts followed by imaginary parts [same unit], shape (2N, ...)."""
    return np.concatenate([values.real, values.imag])
