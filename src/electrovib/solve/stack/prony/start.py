"""Initial terms of a fit, from non-negative least squares on fixed grids of relaxation times."""

from __future__ import annotations

import itertools

import numpy as np

from electrovib.core.arrays import Real
from electrovib.solve.stack.prony.spectrum import Spectrum, Terms, debye_responses, stacked

# scipy's nnls may fail on long, nearly dependent grids; it does not for 59 times and the high term.
DENSE = 59
# Decades by which the end points of the even grid may lie beyond the band.
SLOW_REACH = (0.0, 0.2, 0.4, 0.7, 1.0)
FAST_REACH = (0.0, 0.2, 0.4, 0.7, 1.0)


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
