"""One layer as poles: the impedance of a material that is a sum of relaxations."""

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
    """A layer ready to be solved.

    Parameters
    ----------
    thickness : float
        m.
    debye : DebyeSum
        Polarisation.
    conductivity : float
        S/m.
    charge : float
        Free charge at time 0 on the face towards the finger [C/m2].
    """

    thickness: float
    debye: DebyeSum
    conductivity: float
    charge: float = 0.0


def merged_terms(debye: DebyeSum) -> tuple[Real, Real]:
    """Return relaxation rates, increasing, and strengths; equal rates added, empty terms dropped."""
    totals: dict[float, float] = {}
    for strength, time in zip(debye.strengths, debye.relaxation_times, strict=True):
        if strength > 0:
            totals[1 / time] = totals.get(1 / time, 0.0) + strength
    rates = np.array(sorted(totals))
    return rates, np.array([totals[rate] for rate in rates])


def slab_impedance(slab: Slab) -> tuple[Real, Real]:
    """Expand impedance times area of a slab as sum residue/(s + rate).

    Parameters
    ----------
    slab : Slab
        One layer.

    Returns
    -------
    rates, residues : ndarray
        1/s, increasing, the first 0 if the slab does not conduct; ohm m2/s.
    """
    rates, shares = _relaxations(slab.debye, slab.conductivity)
    return rates, slab.thickness / eps0 / shares


@functools.lru_cache(maxsize=256)
def _relaxations(debye: DebyeSum, conductivity: float) -> tuple[Real, Real]:
    """Rates of a material's impedance [1/s], and thickness/eps0 over each residue; the same for any thickness."""
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
    """Expand bound displacement per current density of a slab.

    Parameters
    ----------
    slab : Slab
        One layer.
    rates, residues : ndarray, shape (n,)
        From `slab_impedance` [1/s, ohm m2/s].

    Returns
    -------
    ndarray, shape (n,)
        1/s, all >= 0: eps0 eps_pol rate = conductivity at each rate.
    """
    if slab.conductivity > 0:
        return slab.conductivity * residues / (slab.thickness * rates)
    return np.where(rates == 0, 1.0, 0.0)  # without conduction the displacement is the charge
