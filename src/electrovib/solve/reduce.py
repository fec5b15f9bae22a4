"""Materials without a finite state, reduced to Debye terms; what that costs is measured and told."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material import Material

LOWEST, HIGHEST = 1.0, 1e6
"""Band in which a reduction holds at least [Hz]."""


@dataclass(frozen=True)
class Reduction:
    """A material's polarisation as Debye terms.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error : float
        Largest |reduced/declared - 1| of the polarisation in the band; 0 when nothing had to be reduced.
    """

    debye: DebyeSum
    largest_error: float


@functools.lru_cache(maxsize=256)
def reduce_material(material: Material, *, low: float = LOWEST, high: float = HIGHEST, terms: int = 14) -> Reduction:
    """Find the Debye terms of a material.

    Parameters
    ----------
    material : Material
        With any dispersion; its conductivity stays apart.
    low, high : float
        Band [Hz], widened to 1 Hz to 1 MHz at least.
    terms : int
        Relaxations.

    Returns
    -------
    Reduction
        Exact, with error 0, for materials that are Debye sums already.
    """
    exact = material.debye()
    if exact is not None:
        return Reduction(exact, 0.0)
    from electrovib.solve.prony import fit_debye

    fit = fit_debye(
        lambda frequency: np.asarray(material.polarisation(frequency)),
        low=min(low, LOWEST),
        high=max(high, HIGHEST),
        terms=terms,
        slowest=material.slowest_relaxation,
    )
    return Reduction(fit.debye, fit.largest_error)
