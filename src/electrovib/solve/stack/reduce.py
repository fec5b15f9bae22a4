"""Materials without a finite state, reduced to Debye terms; what that costs is measured and told."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.tabulated import FEWEST, Tabulated
from electrovib.solve.stack.prony.start import DENSE

if TYPE_CHECKING:
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.material import Material
    from electrovib.solve.stack.prony import PronyFit

LOWEST, HIGHEST = 1.0, 1e6
"""Band in which a reduction holds at least [Hz]."""
PER_DECADE = 3
"""Relaxations for each decade of the band: an error of some 1e-5 for laws that are no sums themselves."""
FEWEST_TERMS = 14
STEP = 2
"""Ends of a band lie at whole 1/STEP decades: runs that differ little share their reductions."""


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


def reduction_band(*, low: float, high: float) -> tuple[float, float]:
    """Widen a band to `LOWEST` to `HIGHEST` at least, and outwards to whole half decades.

    Parameters
    ----------
    low, high : float
        Needed [Hz].

    Returns
    -------
    tuple of float
        Hz.
    """
    lowest, highest = math.log10(min(low, LOWEST)), math.log10(max(high, HIGHEST))
    slack = 1e-9  # the logarithm of a whole decade may miss it by rounding
    first, last = math.floor(STEP * lowest + slack) / STEP, math.ceil(STEP * highest - slack) / STEP
    return float(10.0**first), float(10.0**last)


def reduce_material(
    material: Material, *, low: float = LOWEST, high: float = HIGHEST, terms: int | None = None
) -> Reduction:
    """Find the Debye terms of a material.

    Parameters
    ----------
    material : Material
        With any dispersion; its conductivity stays apart.
    low, high : float
        Band [Hz], widened by `reduction_band`. Of a measured table only the rows in it are followed.
    terms : int, optional
        Relaxations; by default `PER_DECADE` for each decade, 14 for a measured table.

    Returns
    -------
    Reduction
        Exact, with error 0, for materials that are Debye sums already.
    """
    exact = material.debye()
    if exact is not None:
        return Reduction(exact, 0.0)
    return _reduced(material, *reduction_band(low=low, high=high), terms)


@functools.lru_cache(maxsize=256)
def _reduced(material: Material, low: float, high: float, terms: int | None) -> Reduction:
    fit = (
        _fit_rows(material, low, high, terms or FEWEST_TERMS)
        if isinstance(material, Tabulated)
        else _fit_law(material, low, high, terms or _enough(low, high))
    )
    return Reduction(fit.debye, fit.largest_error)


def _enough(low: float, high: float) -> int:
    return min(DENSE, math.ceil(PER_DECADE * math.log10(high / low)) + 2)


def _fit_law(material: Material, low: float, high: float, terms: int) -> PronyFit:
    from electrovib.solve.stack.prony import fit_debye

    return fit_debye(
        lambda frequency: np.asarray(material.bound_permittivity(frequency)),
        low=low,
        high=high,
        terms=terms,
        slowest=material.slowest_relaxation,
    )


def _fit_rows(material: Tabulated, low: float, high: float, terms: int) -> PronyFit:
    from electrovib.solve.stack.prony import fit_debye_table

    frequency, polarisation = material.table()
    near = (frequency >= low) & (frequency <= high)
    wanted = near if np.count_nonzero(near) >= FEWEST else np.ones_like(near)
    return fit_debye_table(
        frequency[wanted], polarisation[wanted], terms=terms, slowest=material.slowest_relaxation
    )
