"""Starting terms from non-negative least squares on fixed grids of relaxation times."""

from __future__ import annotations

import itertools

import numpy as np

from electrovib.core.arrays import Real
from electrovib.solve.stack.prony.spectrum import Spectrum, Terms, debye_responses, stacked

# scipy's nnls may give up on long nearly dependent grids: 59 times and the high term stay clear of it.
DENSE = 59
# How far, in decades, the end points of the even grid may lie beyond the band.
SLOW_REACH = (0.0, 0.2, 0.4, 0.7, 1.0)
FAST_REACH = (0.0, 0.2, 0.4, 0.7, 1.0)


def nonnegative_terms(spectrum: Spectrum, times: Real) -> tuple[Terms, float]:
    """Fit non-negative strengths for given relaxation times.

    Parameters
    ----------
    spectrum : Spectrum
        What to fit, with equal relative weight at every sample.
    times : ndarray
        Relaxation times, s, shape (M,), rising.

    Returns
    -------
    Terms
        All M terms; many strengths are zero.
    float
        Root of the summed squares of the relative error.
    """
    from scipy.optimize import lsq_linear, nnls

    columns = np.column_stack([np.ones(spectrum.angular.size), debye_responses(spectrum.angular, times)])
    matrix = stacked(columns / spectrum.target[:, np.newaxis])
    sizes = np.linalg.norm(matrix, axis=0)
    matrix = matrix / sizes
    wanted = stacked(np.ones(spectrum.angular.size, dtype=complex))
    try:
        weights, misfit = nnls(matrix, wanted, maxiter=50 * matrix.shape[1])
    except RuntimeError:  # nnls met its own limit: an interior-point answer starts the polish as well
        solution = lsq_linear(matrix, wanted, bounds=(0, np.inf))
        weights, misfit = solution.x, float(np.sqrt(2 * solution.cost))
    weights = weights / sizes
    return Terms(float(weights[0]), weights[1:], times), float(misfit)


def even_start(spectrum: Spectrum, count: int) -> Terms:
    """Place ``count`` times evenly in the logarithm, with the best end points of a coarse search."""
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
    """Solve on a dense grid and draw neighbours together until at most ``count`` terms are left.

    A relaxation that falls between two grid times comes out of the solver as a pair: the pair is one term.
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
