"""The founding law's factor 1/sqrt(K), K = sum T/eps_pol, as a causal filter with real poles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.modes import merged_terms
from electrovib.solve.secular import secular_roots
from electrovib.solve.transfer import Real, Transfer

NODES_PER_CUT = 8


def inverse_root_thickness(
    slabs: Sequence[tuple[float, DebyeSum]], *, avoid: Real | None = None, nodes: int = NODES_PER_CUT
) -> Transfer:
    """Expand (sum T/eps_pol(s))^(-1/2) in real poles with positive weights.

    Parameters
    ----------
    slabs : sequence of (float, DebyeSum)
        Thickness [m] and polarisation of each layer.
    avoid : ndarray, optional
        Rates that a factor to come already has; the quadrature keeps clear of them.
    nodes : int
        Quadrature nodes on each branch cut.

    Returns
    -------
    Transfer
        m^-1/2, without free part.

    Notes
    -----
    K(-x) is negative on one interval for each Debye term, from a zero y to a pole b of K, and
    K^(-1/2)(s) = K_inf^(-1/2) + (1/pi) sum over cuts of integral |K(-x)|^(-1/2)/(s + x) dx. The integrand
    goes as (x - y)^(-1/2) (b - x)^(1/2), whose Gauss rule is a cosine: no fit, all weights positive.
    """
    infinite, poles, weights = _expand(slabs)
    if not len(poles):
        return Transfer(np.zeros(0), np.zeros(0), infinite**-0.5)
    static = infinite - float(np.sum(weights / poles))
    # in 1/x the equation K(-x) = 0 is again a secular equation with positive weights
    reversed_roots = secular_roots(1 / poles[::-1], (weights / poles**2)[::-1], static)
    zeros = 1 / reversed_roots.values[::-1]
    for count in (nodes, nodes + 1, nodes + 2):
        rates, strengths = _cuts(zeros, poles, weights, infinite, count)
        if avoid is None or not len(avoid) or _clearance(rates, avoid) > 1e-3:
            break
    return Transfer(rates, strengths / rates, infinite**-0.5)


def _expand(slabs: Sequence[tuple[float, DebyeSum]]) -> tuple[float, Real, Real]:
    """Write K(s) = K_inf - sum weight/(s + pole)."""
    infinite, found = 0.0, {}
    for thickness, debye in slabs:
        infinite += thickness / debye.high
        relaxations, strengths = merged_terms(debye)
        if len(relaxations):
            roots = secular_roots(relaxations, strengths * relaxations, debye.high)
            for pole, slope in zip(roots.values, roots.slope, strict=True):
                found[pole] = found.get(pole, 0.0) + thickness / slope
    poles = np.array(sorted(found))
    return infinite, poles, np.array([found[pole] for pole in poles])


def _cuts(zeros: Real, poles: Real, weights: Real, infinite: float, count: int) -> tuple[Real, Real]:
    angles = (2 * np.arange(1, count + 1) - 1) * np.pi / (2 * count + 1)
    places, gauss = np.cos(angles), (1 - np.cos(angles)) * 2 * np.pi / (2 * count + 1)
    half = (poles - zeros) / 2
    x = (poles + zeros)[:, None] / 2 + half[:, None] * places
    thickness = infinite - np.sum(weights / (poles - x[..., None]), axis=-1)  # K(-x), negative here
    shape = np.sqrt((1 - places) / (1 + places))  # the weight of the Gauss rule
    smooth = np.abs(thickness) ** -0.5 / shape
    return x.ravel(), (half[:, None] * gauss * smooth / np.pi).ravel()


def _clearance(rates: Real, avoid: Real) -> float:
    """Smallest relative distance between two sets of rates."""
    apart = np.abs(rates[:, None] - avoid[None, :]) / np.maximum(rates[:, None], avoid[None, :])
    return float(apart.min())
