"""Impedance of one layer as a sum of poles, for a material that is a sum of relaxations."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.solve.stack.secular import secular_roots

if TYPE_CHECKING:
    from electrovib.physics.debye_sum import DebyeSum


@dataclass(frozen=True)
class Slab:
    """A layer as Debye terms and a conductivity.

    Parameters
    ----------
    thickness : float
        Thickness [m].
    debye : DebyeSum
        Bound permittivity.
    conductivity : float
        Conductivity [S/m].
    charge : float
        Free charge at time 0 on the face towards the finger [C/m2].
    """

    thickness: float
    debye: DebyeSum
    conductivity: float
    charge: float = 0.0


def merged_terms(debye: DebyeSum) -> tuple[Real, Real]:
    """Return increasing relaxation rates [1/s] and strengths [1]; equal rates are merged, terms of strength 0 omitted."""
    totals: dict[float, float] = {}
    for strength, time in zip(debye.strengths, debye.relaxation_times, strict=True):
        if strength > 0:
            totals[1 / time] = totals.get(1 / time, 0.0) + strength
    rates = np.array(sorted(totals))
    return rates, np.array([totals[rate] for rate in rates])


def slab_impedance(slab: Slab) -> tuple[Real, Real]:
    """Return the impedance times area of a slab as sum residue/(s + rate)."""
    rates, shares = _relaxations(slab.debye, slab.conductivity)
    return rates, slab.thickness / eps0 / shares


@functools.lru_cache(maxsize=256)
def _relaxations(debye: DebyeSum, conductivity: float) -> tuple[Real, Real]:
    """Return the rates of a material's impedance [1/s], and thickness/eps0 over each residue, for any thickness."""
    relaxations, strengths = merged_terms(debye)
    nodes, weights = relaxations, strengths * relaxations
    if conductivity > 0:
        nodes = np.concatenate([[0.0], nodes])
        weights = np.concatenate([[conductivity / eps0], weights])
    rates, shares = np.zeros(0), np.zeros(0)
    if len(nodes):
        roots = secular_roots(nodes, weights, constant=debye.high)
        rates, shares = roots.values, roots.values * roots.slope
    if conductivity == 0:
        static = debye.high + float(np.sum(strengths))
        rates, shares = np.append(0.0, rates), np.append(static, shares)
    for array in (rates, shares):
        array.flags.writeable = False
    return rates, shares


def bound_residues(slab: Slab, rates: Real, residues: Real) -> Real:
    """Return the residues of the bound displacement per current density of a slab.

    `rates`, `residues` (n,); returns `residues` (n,).
    """
    if slab.conductivity > 0:
        return slab.conductivity * residues / (slab.thickness * rates)
    return np.where(rates == 0, 1.0, 0.0)  # without conduction the displacement is the charge
