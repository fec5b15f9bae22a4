"""Materials without a finite state, reduced to Debye terms; what that costs is measured and told."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.tabulated import FEWEST, Tabulated

if TYPE_CHECKING:
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.material import Material
    from electrovib.solve.prony import PronyFit

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
        Largest |reduced/declared - 1| of the polarisation in the band; 0 when nothing had to be reduced. Of a
        measured table: against its rows, their noise included.
    """

    debye: DebyeSum
    largest_error: float


@functools.lru_cache(maxsize=256)
def reduce_material(
    material: Material, *, low: float = LOWEST, high: float = HIGHEST, terms: int = 14
) -> Reduction:
    """Find the Debye terms of a material.

    Parameters
    ----------
    material : Material
        With any dispersion; its conductivity stays apart.
    low, high : float
        Band [Hz], widened to 1 Hz to 1 MHz at least. Of a measured table only the rows in it are followed.
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
    low, high = min(low, LOWEST), max(high, HIGHEST)
    fit = (
        _fit_rows(material, low, high, terms)
        if isinstance(material, Tabulated)
        else _fit_law(material, low, high, terms)
    )
    return Reduction(fit.debye, fit.largest_error)


def _fit_law(material: Material, low: float, high: float, terms: int) -> PronyFit:
    from electrovib.solve.prony import fit_debye

    return fit_debye(
        lambda frequency: np.asarray(material.polarisation(frequency)),
        low=low,
        high=high,
        terms=terms,
        slowest=material.slowest_relaxation,
    )


def _fit_rows(material: Tabulated, low: float, high: float, terms: int) -> PronyFit:
    from electrovib.solve.prony import fit_debye_table

    frequency, polarisation = material.table()
    near = (frequency >= low) & (frequency <= high)
    wanted = near if np.count_nonzero(near) >= FEWEST else np.ones_like(near)
    return fit_debye_table(
        frequency[wanted], polarisation[wanted], terms=terms, slowest=material.slowest_relaxation
    )
