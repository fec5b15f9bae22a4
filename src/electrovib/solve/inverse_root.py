"""The founding law's factor 1/sqrt(K), K = sum T/eps_pol, as a causal filter with real poles."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from electrovib.solve.modes import merged_terms
from electrovib.solve.secular import secular_roots
from electrovib.solve.transfer import Real, Transfer

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from electrovib.physics.debye_sum import DebyeSum

Counts: TypeAlias = NDArray[np.intp]

TOLERANCE = 1e-11
"""Relative error that the number of nodes on each branch cut aims at."""
MOST_NODES = 200
"""On one cut: enough for a single relaxation that changes the thickness a thousandfold."""
CLEARANCE = 1e-3
"""Relative distance between poles of two factors from which their product keeps 12 digits."""
NARROW = 1e-14
"""Cuts shorter than this, relative, are left out: rounding may have turned them round."""


def inverse_root_thickness(
    slabs: Sequence[tuple[float, DebyeSum]], *, avoid: Real | None = None, tolerance: float = TOLERANCE
) -> Transfer:
    """Expand (sum T/eps_pol(s))^(-1/2) in real poles with positive weights.

    Parameters
    ----------
    slabs : sequence of (float, DebyeSum)
        Thickness [m] and polarisation of each layer.
    avoid : ndarray, optional
        Rates that a factor to come already has; the quadrature keeps clear of them.
    tolerance : float
        Relative error aimed at, 1e-14 to 0.1.

    Returns
    -------
    Transfer
        m^-1/2, without free part.

    Notes
    -----
    K(-x) is negative on one interval for each Debye term, from a zero y to a pole b of K, and
    K^(-1/2)(s) = K_inf^(-1/2) + (1/pi) sum over cuts of integral |K(-x)|^(-1/2)/(s + x) dx. The integrand
    goes as (x - y)^(-1/2) (b - x)^(1/2), the weight of a Gauss rule with cosines as nodes: no fit, all
    weights positive. n nodes leave an error of about rho^(-2 n), rho > 1 the size of the largest ellipse
    around the cut that meets neither the next cut nor s = 0.
    """
    infinite, static, poles, weights = _expand(slabs)
    if not len(poles):
        return Transfer(np.zeros(0), np.zeros(0), infinite**-0.5)
    # in 1/x the equation K(-x) = 0 is again a secular equation with positive weights
    reversed_roots = secular_roots(1 / poles[::-1], (weights / poles**2)[::-1], static)
    zeros = 1 / reversed_roots.values[::-1]
    wide = poles - zeros > NARROW * poles
    cuts = np.stack([zeros[wide], poles[wide]])
    counts = _counts(cuts, tolerance)
    best = (-1.0, np.zeros(0), np.zeros(0))
    for more in range(6):
        rates, strengths = _cuts(cuts, counts + more, lambda x: infinite - _poles_at(x, poles, weights))
        best = max(best, (_clearance(rates, avoid), rates, strengths), key=lambda found: found[0])
        if best[0] > CLEARANCE:
            break
    _, rates, strengths = best
    return Transfer(rates, strengths / rates, infinite**-0.5)


def _expand(slabs: Sequence[tuple[float, DebyeSum]]) -> tuple[float, float, Real, Real]:
    """Write K(s) = K_inf - sum weight/(s + pole), and give K(0) too, which that difference would spoil."""
    infinite, static = 0.0, 0.0
    found: dict[float, float] = {}
    for thickness, debye in slabs:
        relaxations, strengths = merged_terms(debye)
        infinite += thickness / debye.high
        static += thickness / (debye.high + float(np.sum(strengths)))
        if len(relaxations):
            roots = secular_roots(relaxations, strengths * relaxations, debye.high)
            for pole, slope in zip(roots.values.tolist(), roots.slope.tolist(), strict=True):
                found[pole] = found.get(pole, 0.0) + thickness / slope
    poles = np.array(sorted(found))
    return infinite, static, poles, np.array([found[pole] for pole in poles.tolist()])


def _poles_at(x: Real, poles: Real, weights: Real) -> Real:
    """Sum of weight/(pole - x)."""
    total: Real = np.sum(weights / (poles - x[:, None]), axis=1)
    return total


def _counts(cuts: Real, tolerance: float) -> Counts:
    """Nodes that each cut needs, from how near the next singularity is against its length."""
    low, high = cuts
    below = low - np.append(0.0, high[:-1])
    above = np.append(low[1:], np.inf) - high
    free = np.maximum(np.minimum(below, above), NARROW * high)
    far = 1 + 2 * free / (high - low)
    needed = np.log(1 / tolerance) / (2 * np.arccosh(far))
    counts: Counts = np.ceil(np.clip(needed, 2, MOST_NODES)).astype(int)
    return counts


def _cuts(cuts: Real, counts: Counts, thickness: Callable[[Real], Real]) -> tuple[Real, Real]:
    """Quadrature nodes x of all cuts, and their weights; `thickness` gives K(-x), negative there."""
    low, high = np.repeat(cuts, counts, axis=1)
    total = np.repeat(2 * counts + 1, counts)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    places = np.cos(2 * np.pi * (np.arange(len(total)) - first + 1) / total)
    x = (low + high) / 2 + (high - low) / 2 * places
    # the rule takes sqrt((1 - t)/(1 + t)) out of the integrand and puts 1 - t in
    smooth = np.abs(thickness(x)) ** -0.5 * np.sqrt(1 - places**2)
    return x, (high - low) * smooth / total


def _clearance(rates: Real, avoid: Real | None) -> float:
    """Smallest relative distance between two sets of rates."""
    if avoid is None or not len(avoid):
        return np.inf
    apart = np.abs(rates[:, None] - avoid[None, :]) / np.maximum(rates[:, None], avoid[None, :])
    return float(apart.min())
