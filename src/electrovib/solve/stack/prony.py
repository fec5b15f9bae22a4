"""Debye terms of a spectrum of the bound permittivity, given as a function or as a table.

Non-negative least squares on fixed grids of relaxation times gives the start, separable least squares move the times, and
reweighting reduces the largest error. In numpy alone: scipy.optimize takes ten times as long to import as a fit to compute.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.core.arrays import Complex, Real
from electrovib.core.errors import InputError
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.recursion.blocks import PRODUCT

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt
    from numpy.typing import NDArray

SAMPLES_PER_DECADE = 15
# Terms this factor beyond the band act in it as a constant, or as conduction, to less than 1 part in 100.
SLOW_ROOM, FAST_ROOM = 100.0, 1000.0
# Number of points for which twice the estimated noise is allowed, because the estimate itself is uncertain.
FEW_POINTS = 20
# Number of times of the grid on which the relaxations of a spectrum are looked for; no sum has more terms.
DENSE = 59
# Factor by which the even grid of times extends beyond the band on both sides.
REACH = 2.5
# Steps of a refinement, the share of the squared error that each has to save, and rounds of levelling, of one step each.
STEPS, GAIN, ROUNDS = 60, 1e-3, 17
# Damping of a first step, and its inverse the largest; the times are nearly dependent, and move little under a stronger one.
DAMPING = 1e-6
# Longest move of a time in one step, as a difference of logistic parameters.
LONGEST = 2.0
# Added to the diagonal of normal equations of columns of norm 1, which may be dependent to rounding.
RIDGE = 1e-14
# Derivative that counts as none, and variables that enter a non-negative solution at most.
SLACK, ENTRIES = 1e-12, 200
# Share of the smallest permittivity in the band below which a term is negligible.
NOTHING = 1e-10
# Share of all strengths on the dense grid below which one is rounding.
NEGLIGIBLE = 1e-10
# The permittivity at high frequency stays above this share of it, because a stack of layers divides by it.
HIGH_FLOOR = 1e-6
# Two relaxation times closer than this in the logarithm are equivalent to one, with an error of about its square.
COINCIDENT = 1e-4
# A relative error below this is due to rounding, not to the number of terms.
EXACT = 1e-9


@dataclass(frozen=True)
class Reduction:
    """Bound permittivity of a material as Debye terms.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error : float
        Largest |reduced/declared - 1| of the bound permittivity in the band [1]; 0 where no reduction was needed. For a
        measured table relative to its rows, with their noise.
    """

    debye: DebyeSum
    largest_error: float


def fit_debye(
    bound_permittivity: Callable[[Real], npt.ArrayLike],
    *,
    low: float,
    high: float,
    terms: int = 14,
    slowest: float | None = None,
) -> Reduction:
    """Reduce a law of the bound permittivity to Debye terms that are passive by construction.

    Reweighting after C. L. Lawson (thesis, University of California, Los Angeles, 1961) reduces the largest relative error.
    Non-negative terms exist for Cole-Cole and constant-phase laws, and for Havriliak-Negami laws with alpha <= 1 and
    alpha beta <= 1; for others the result is the nearest passive sum. Outside the band it does not describe the material.
    """
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
) -> Reduction:
    """Reduce a measured spectrum of the bound permittivity to Debye terms that are passive by construction.

    `frequency` (N,) [Hz], rising, `bound_permittivity` (N,).

    Plain least squares of the relative error: reweighting towards the worst point would follow the noise. By default no
    term is slower than 1/(2 pi) of the lowest frequency, because noisy data cannot distinguish such a term from conduction;
    loss of that kind remains as an error at the lowest frequencies (6 % for a constant phase of exponent 0.75). Where the
    conduction is known, a ``slowest`` of ten times the default allows relaxations to represent it.
    """
    hertz, target = np.asarray(frequency, float), np.asarray(bound_permittivity, complex)
    _refuse_unphysical(hertz, target)
    refuse_active(hertz, target, allowed=noise_limit(target))
    spectrum = _spectrum(hertz, target, 1 / (2 * np.pi * hertz[0]) if slowest is None else slowest)
    found = _least(spectrum, min(terms, hertz.size - 1))
    return _report(found, hertz, target)


def _least(spectrum: Spectrum, terms: int) -> Terms:
    starts = [clustered_times(spectrum, terms), even_times(spectrum, terms)]
    moved = [tidied(spectrum, refined(spectrum, start, steps=STEPS)).times for start in starts]
    polished = [tidied(spectrum, fitted(spectrum, times).terms) for times in moved]
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


def _report(terms: Terms, frequency: Real, target: Complex) -> Reduction:
    debye = DebyeSum(terms.high, tuple(map(float, terms.strengths)), tuple(map(float, terms.times)))
    error = np.abs(debye.permittivity(frequency) / target - 1)
    return Reduction(debye, float(error.max()))


def evaluated(bound_permittivity: Callable[[Real], npt.ArrayLike], frequency: Real) -> Complex:
    """Return a law of the bound permittivity at given frequencies, refusing unphysical values.

    `frequency` (N,) [Hz]; returns `target` (N,).
    """
    target = np.asarray(bound_permittivity(frequency), dtype=complex)
    _refuse_unphysical(frequency, target)
    return target


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


def even_times(spectrum: Spectrum, count: int) -> Real:
    """Return ``count`` times even in the logarithm, a little beyond the band on both sides [s]."""
    low, high = spectrum.grid_limits()
    first, last = max(low, 1 / (REACH * spectrum.angular[-1])), min(high, REACH / spectrum.angular[0])
    return np.asarray(np.geomspace(first, last, count))


def clustered_times(spectrum: Spectrum, count: int) -> Real:
    """Return the times on a dense grid in pairs, as which one between two times appears, merged until ``count`` remain [s]."""
    terms = fitted(spectrum, np.geomspace(*spectrum.grid_limits(), DENSE)).terms
    used = np.flatnonzero(terms.strengths > NEGLIGIBLE * terms.strengths.sum())
    runs = np.split(used, np.flatnonzero(np.diff(used) > 1) + 1) if used.size else []
    pairs = [pair for run in runs for pair in np.array_split(run, max(1, round(run.size / 2)))]
    strengths = [float(terms.strengths[pair].sum()) for pair in pairs]
    logs = [float(np.average(np.log(terms.times[pair]), weights=terms.strengths[pair])) for pair in pairs]
    while len(logs) > count:
        near = int(np.argmin(np.diff(logs)))
        both = slice(near, near + 2)
        logs[both] = [float(np.average(logs[both], weights=strengths[both]))]
        strengths[both] = [sum(strengths[both])]
    return np.asarray(np.exp(logs), dtype=float)


class Fit(NamedTuple):
    """Terms with the best non-negative strengths at their times.

    `columns` (N, M + 1) are the responses over the target, `error` (2 N,) is weighted, `size` its sum of squares.
    """

    terms: Terms
    columns: Complex
    error: Real
    size: float


def fitted(spectrum: Spectrum, times: Real) -> Fit:
    """Return the non-negative strengths with the least weighted squares of the relative error at given times."""
    responses = debye_responses(spectrum.angular, times)
    columns = np.column_stack([np.ones(len(responses)), responses]) / spectrum.target[:, np.newaxis]
    rows, wanted = stacked(columns * spectrum.roots), stacked(spectrum.roots[:, 0].astype(complex))
    sizes = np.linalg.norm(rows, axis=0)
    rows = rows / sizes
    found = nonnegative(products(rows), rows.T @ wanted)
    error = rows @ found - wanted
    found = found / sizes
    return Fit(Terms(float(found[0]), found[1:], times), columns, error, float(error @ error))


def nonnegative(gram: Real, aim: Real) -> Real:
    """Return the x >= 0 with the least x gram x/2 - aim x, for a diagonal of ones.

    After C. L. Lawson and R. J. Hanson (Solving Least Squares Problems, 1974, chapter 23), from all variables, which are often
    the solution: those that fall below 0 leave, and then the one enters along which the function falls fastest.
    """
    gram = gram + RIDGE * np.eye(aim.size)
    used, found = np.ones(aim.size, bool), np.zeros(aim.size)
    for _ in range(ENTRIES):
        wanted = _solution(gram, aim, used)
        while np.any(falling := used & (wanted <= 0)):
            shares = np.full(aim.size, np.inf)
            shares[falling] = found[falling] / (found[falling] - wanted[falling] + np.finfo(float).tiny)
            found = found + np.min(shares) * (wanted - found)
            used &= shares > np.min(shares)
            found[~used] = 0.0
            wanted = _solution(gram, aim, used)
        found, slopes = wanted, np.where(used, 0.0, aim - gram @ wanted)
        enters = int(np.argmax(slopes))
        if slopes[enters] < SLACK:
            break
        used[enters] = True
    return found


def _solution(gram: Real, aim: Real, used: NDArray[np.bool_]) -> Real:
    found = np.zeros(aim.size)
    found[used] = np.linalg.solve(gram[np.ix_(used, used)], aim[used])
    return found


def refined(spectrum: Spectrum, times: Real, *, steps: int) -> Terms:
    """Move times by damped Gauss-Newton steps, and return the terms with the best strengths at any times.

    Separable least squares (G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413-432): a step solves for strengths
    and times together and keeps the times, which a logistic map holds within the limits of the spectrum.
    """
    places, damping = spectrum.places(times), DAMPING
    fit = fitted(spectrum, spectrum.times(places))
    for _ in range(steps if places.size else 0):
        slopes, previous = _slopes(spectrum, fit), fit.size
        gram, gradient = products(slopes), slopes.T @ fit.error
        while damping < 1 / DAMPING:
            shares = np.where(np.arange(len(gram)) < len(gram) - places.size, RIDGE, damping)
            damped = gram + np.diag(np.diag(gram) * shares + np.finfo(float).tiny)
            step = np.linalg.solve(damped, -gradient)[-places.size :]
            trial = places + np.clip(step, -LONGEST, LONGEST)
            found = fitted(spectrum, spectrum.times(trial))
            if found.size < fit.size:
                places, fit, damping = trial, found, damping / 10
                break
            damping = max(10 * damping, DAMPING)
        if not fit.size < (1 - GAIN) * previous:
            break
    return fit.terms


def _slopes(spectrum: Spectrum, fit: Fit) -> Real:
    """Return the derivatives of the weighted error by log high, log strengths and the places, (2 N, 2 M + 1)."""
    terms, relative = fit.terms, fit.columns[:, 1:]
    turn = 1j * spectrum.angular[:, np.newaxis] * terms.times
    by_place = -relative * (turn / (1 + turn)) * terms.strengths * spectrum.slopes(terms.times)
    by_size = fit.columns * np.append(terms.high, terms.strengths)
    return stacked(np.asarray(np.concatenate([by_size, by_place], axis=1) * spectrum.roots, dtype=complex))


def products(rows: Real) -> Real:
    """Return rows^T rows, of parts of the rows that stay on one thread: more threads wait for each other on a busy machine."""
    height = max(1, PRODUCT // rows.shape[1] ** 2)
    parts = [rows[begin : begin + height] for begin in range(0, len(rows), height)]
    return np.asarray(sum(part.T @ part for part in parts))


def level_errors(spectrum: Spectrum, terms: Terms) -> Terms:
    """Reduce the largest error, at the cost of the mean error, by raising the weights of the worst samples."""
    weights, best, smallest = np.ones(spectrum.angular.size), terms, np.inf
    for _ in range(ROUNDS):
        error = np.abs(spectrum.relative_error(terms))
        largest = float(error.max())
        if largest < smallest:
            best, smallest = terms, largest
        if largest < EXACT:
            break
        # The small constant keeps the weight of samples whose error crosses zero above 0.
        weights = weights * (error / largest + 1e-3)
        weights /= weights.mean()
        terms = refined(replace(spectrum, weights=weights), terms.times, steps=1)
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
    weights : ndarray, shape (N,), or float
        Weights of the squared relative errors [1].
    """

    angular: Real
    target: Complex
    fastest: float
    slowest: float
    weights: Real | float = 1.0

    @property
    def roots(self) -> Real:
        """Return the square roots of the weights, shape (N, 1)."""
        return np.asarray(np.sqrt(np.broadcast_to(self.weights, self.angular.shape)))[:, np.newaxis]

    def grid_limits(self) -> tuple[float, float]:
        """Return the range of initial relaxation times: one decade beyond the band, within the limits [s]."""
        first, last = 0.1 / self.angular[-1], 10 / self.angular[0]
        # Just inside the limits, at which the logistic map has a slope of 0.
        return max(float(first), 1.01 * self.fastest), min(float(last), self.slowest / 1.01)

    def times(self, places: Real) -> Real:
        """Return the times of any numbers: a logistic map to the logarithms between the limits [s]."""
        first, span = self._range()
        return np.asarray(np.exp(first + span * (0.5 + 0.5 * np.tanh(0.5 * places))))

    def places(self, times: Real) -> Real:
        """Return the numbers of times: the inverse of `times`, a little inside the limits."""
        first, span = self._range()
        share = np.clip((np.log(times) - first) / span, 1e-4, 1 - 1e-4)
        return np.asarray(np.log(share / (1 - share)))

    def slopes(self, times: Real) -> Real:
        """Return d log(time)/d place at given times."""
        first, span = self._range()
        share = (np.log(times) - first) / span
        return np.asarray(span * share * (1 - share))

    def _range(self) -> tuple[float, float]:
        return math.log(self.fastest), math.log(self.slowest / self.fastest)

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
