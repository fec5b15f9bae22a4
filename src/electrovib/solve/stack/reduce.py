"""Reduction of materials to Debye terms where they are no finite sum of them, with the error of the reduction."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.tabulated import FEWEST
from electrovib.solve.stack.prony.start import DENSE

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.material import Material
    from electrovib.solve.stack.prony import PronyFit

LOWEST, HIGHEST = 1.0, 1e6
"""Smallest band of a reduction [Hz]."""
PER_DECADE = 3
"""Relaxations for each decade of the band: an error of some 1e-5 for laws that are not sums of Debye terms."""
FEWEST_TERMS = 14
STEP = 2
"""Ends of a band lie at whole 1/STEP decades, so that runs that differ little share their reductions."""


@dataclass(frozen=True)
class Reduction:
    """Bound permittivity of a material as Debye terms.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error : float
        Largest |reduced/declared - 1| of the bound permittivity in the band [1]; 0 where no reduction was needed. For a
        measured table relative to its rows, with their noise.
    """

    debye: DebyeSum
    largest_error: float


def reduction_band(*, low: float, high: float) -> tuple[float, float]:
    """Return a band widened to at least `LOWEST` to `HIGHEST`, and outwards to half decades."""
    lowest, highest = math.log10(min(low, LOWEST)), math.log10(max(high, HIGHEST))
    slack = 1e-9  # the logarithm of a whole decade may miss it by rounding
    first, last = math.floor(STEP * lowest + slack) / STEP, math.ceil(STEP * highest - slack) / STEP
    return float(10.0**first), float(10.0**last)


def reduce_material(
    material: Material, *, low: float = LOWEST, high: float = HIGHEST, terms: int | None = None
) -> Reduction:
    """Return the Debye terms of a material."""
    exact = material.debye()
    if exact is not None:
        return Reduction(exact, 0.0)
    return _reduced(material, *reduction_band(low=low, high=high), terms)


@functools.lru_cache(maxsize=256)
def _reduced(material: Material, low: float, high: float, terms: int | None) -> Reduction:
    rows = material.table()
    fit = (
        _fit_law(material, low, high, terms or _enough(low, high))
        if rows is None
        else _fit_rows(material, rows, low, high, terms or FEWEST_TERMS)
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


def _fit_rows(
    material: Material, rows: tuple[Real, Complex], low: float, high: float, terms: int
) -> PronyFit:
    from electrovib.solve.stack.prony import fit_debye_table

    frequency, polarisation = rows
    near = (frequency >= low) & (frequency <= high)
    wanted = near if np.count_nonzero(near) >= FEWEST else np.ones_like(near)
    return fit_debye_table(
        frequency[wanted], polarisation[wanted], terms=terms, slowest=material.slowest_relaxation
    )
