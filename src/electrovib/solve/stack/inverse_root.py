"""The factor 1/sqrt(K) of the law of Vezzoli et al. 2014, K = sum T/eps_pol, as a causal filter with real poles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.arrays import Real
from electrovib.solve.stack.modes import relaxations
from electrovib.solve.stack.secular import secular_roots
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.physics.debye_sum import DebyeSum

TOLERANCE = 1e-11
"""Relative error for which the number of nodes on each branch cut is chosen."""
MOST_NODES = 40
"""Nodes on one cut with even angles; a cut that nearly touches the next one has graded angles instead."""
CLEARANCE = 1e-2
"""Distance between poles of two factors, over the residue of this one, with which a product keeps 13 digits."""
NARROW = 1e-11
"""Relative length below which a cut has one node: next to a strong cut it contributes up to 1e-9."""
SHORTEST = 1e-15
"""Relative length below which a cut is rounding."""
ALIKE = 1e-6
"""Relative distance below which rates count as equal."""


def inverse_root_thickness(
    slabs: Sequence[tuple[float, DebyeSum]], *, avoid: Real | None = None, tolerance: float = TOLERANCE
) -> Transfer:
    """Expand (sum T/eps_pol(s))^(-1/2) in real poles with positive weights.

    K(-x) is negative on one interval for each Debye term, from a zero y to a pole b of K, and K^(-1/2)(s) =
    K_inf^(-1/2) + (1/pi) sum over cuts of integral |K(-x)|^(-1/2)/(s + x) dx. With x = y (b/y)^(sin^2 angle)
    the integrand is smooth and even in the angle at both ends, so that even angles are a Gauss rule: no fit,
    all weights positive.
    """
    infinite, static, poles, weights = _expand(slabs)
    if not len(poles):
        return Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=infinite**-0.5)
    # in 1/x the equation K(-x) = 0 is again a secular equation with positive weights
    reversed_roots = secular_roots(1 / poles[::-1], (weights / poles**2)[::-1], constant=static)
    cuts = [cut for cut in _cuts(1 / reversed_roots.values[::-1], poles) if cut.length > SHORTEST]
    best = (-1.0, np.zeros(0), np.zeros(0))
    for more in range(6):
        nodes = [cut.nodes(tolerance, more) for cut in cuts]
        rates, strengths = np.concatenate(nodes, axis=1) if nodes else np.zeros((2, 0))
        best = max(best, (_clearance(rates, strengths, avoid), rates, strengths), key=lambda found: found[0])
        if best[0] > CLEARANCE:
            break
    _, rates, strengths = best
    return Transfer(rates=rates, gains=strengths / rates * infinite**-0.5, direct=infinite**-0.5)


def _expand(slabs: Sequence[tuple[float, DebyeSum]]) -> tuple[float, float, Real, Real]:
    """Return the terms of K(s) = K_inf - sum weight/(s + pole), and K(0), which that difference would lose digits of."""
    infinite, static = 0.0, 0.0
    poles, weights = [np.zeros(0)], [np.zeros(0)]
    for thickness, debye in slabs:
        rates, shares = relaxations(
            debye, 0.0
        )  # the first rate is 0: a material that does not conduct holds charge
        infinite, static = infinite + thickness / debye.high, static + thickness / shares[0]
        poles.append(rates[1:])
        weights.append(thickness * rates[1:] / shares[1:])
    return infinite, static, *_merged(np.concatenate(poles), np.concatenate(weights))


def _merged(rates: Real, weights: Real) -> tuple[Real, Real]:
    """Merge rates that almost agree at their weighted mean, with an error of the order of the distance squared."""
    order = np.argsort(rates)
    rates, weights = rates[order], weights[order]
    starts = np.flatnonzero(np.diff(rates, prepend=-np.inf) > ALIKE * rates)
    if len(starts) == len(rates):
        return rates, weights
    together = np.add.reduceat(weights, starts)
    return np.add.reduceat(rates * weights, starts) / together, together


@dataclass(frozen=True, eq=False, kw_only=True)
class _Cut:
    """Branch cut: an interval on which K(-x) is negative.

    Parameters
    ----------
    low, length : float
        Begin of the interval [1/s], and the logarithm of its end over its begin.
    below, above : float
        Logarithms of the distances to the next cuts, infinite where there is none.
    zeros, poles : ndarray
        Ends of all other cuts.
    """

    low: float
    length: float
    below: float
    above: float
    zeros: Real
    poles: Real

    def nodes(self, tolerance: float, more: int) -> Real:
        """Return quadrature nodes x and weights of |K_inf/K(-x)|^(1/2) dx/pi, shape (2, nodes)."""
        if self.length < NARROW:
            return self._middle()
        angles, steps = self._angles(np.log(1 / tolerance), more)
        share = np.sin(angles) ** 2
        x = self.low * np.exp(self.length * share)
        from_low = self.low * np.expm1(self.length * share)
        to_high = x * np.expm1(self.length * np.cos(angles) ** 2)
        others = (x[:, None] - self.poles) / (
            x[:, None] - self.zeros
        )  # K is a product over its poles and zeros
        inverse_root = np.sqrt(to_high / from_low * np.prod(others, axis=1))
        return np.array([x, inverse_root * x * self.length * np.sin(2 * angles) * steps / np.pi])

    def _middle(self) -> Real:
        """Return one node, whose weight is the integral with all other factors constant."""
        x = self.low * np.exp(self.length / 2)
        others = np.abs(np.prod((x - self.poles) / (x - self.zeros)))
        return np.array([[x], [np.sqrt(others) * self.low * np.expm1(self.length) / 2]])

    def _angles(self, digits: float, more: int) -> tuple[Real, Real]:
        """Return angles from 0 to pi/2 and their steps, as many as an error of exp(-digits) needs."""
        free = max(min(self.below, self.above), NARROW)
        # region of the complex plane in which the integrand is analytic: next cut, logarithm of imaginary frequencies
        ellipse = min(np.arccosh(1 + 2 * free / self.length), np.arcsinh(np.pi / self.length))
        count = max(2, int(np.ceil(digits / (2 * ellipse)))) + more
        if count > MOST_NODES:
            return self._graded_angles(digits, more)
        steps: Real = np.full(count, np.pi / (2 * count + 1))
        angles: Real = np.pi / 2 - steps * np.arange(1, count + 1)
        return angles, steps

    def _graded_angles(self, digits: float, more: int) -> tuple[Real, Real]:
        """Return Gauss points on panels that grow from both ends with the distance from a singularity."""
        widest = min(np.pi / 8, np.pi / (2 * self.length))
        ends = [
            _panels(np.sqrt(max(free, NARROW) / self.length), widest) for free in (self.below, self.above)
        ]
        edges = np.concatenate([ends[0], np.pi / 2 - ends[1][-2::-1]])
        points, weights = np.polynomial.legendre.leggauss(int(np.ceil(digits / 1.7)) + more)
        half = np.diff(edges) / 2
        angles: Real = (edges[:-1] + half)[:, None] + half[:, None] * points
        steps: Real = half[:, None] * weights
        return angles.ravel(), steps.ravel()


def _panels(first: float, widest: float) -> Real:
    """Return edges from 0 to pi/4, with a first panel of a given width, then each twice as wide as all before it."""
    edges = [0.0, min(first, widest)]
    while edges[-1] < np.pi / 4:
        edges.append(edges[-1] + min(2 * edges[-1], widest))
    edges[-1] = np.pi / 4
    return np.array(edges)


def _cuts(zeros: Real, poles: Real) -> list[_Cut]:
    lengths = np.log1p((poles - zeros) / zeros)
    gaps = np.concatenate([[np.inf], np.log(zeros[1:] / poles[:-1]), [np.inf]])
    found = []
    for own, low in enumerate(zeros.tolist()):
        others = np.arange(len(poles)) != own
        length, below, above = float(lengths[own]), float(gaps[own]), float(gaps[own + 1])
        found.append(
            _Cut(low=low, length=length, below=below, above=above, zeros=zeros[others], poles=poles[others])
        )
    return found


def _clearance(rates: Real, strengths: Real, avoid: Real | None) -> float:
    """Return the smallest distance between two sets of rates, over the strength of the first."""
    if avoid is None or not len(avoid) or not len(rates):
        return np.inf
    return float(np.min(np.abs(rates[:, None] - avoid[None, :]) / strengths[:, None]))
