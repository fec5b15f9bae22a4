"""The linear Kramers-Kronig test of measured impedances and permittivities."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.kramers_kronig import kramers_kronig_residual

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real


def impedance_residual(frequency: ArrayLike, impedance: ArrayLike) -> float:
    """Compute the relative rms deviation of a measured admittance from the Kramers-Kronig relations.

    The admittance over j w is tested as a permittivity by `kramers_kronig_residual`. Inductive parts count as
    a misfit.
    """
    grid, data = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.shape != data.shape or grid.ndim != 1 or not np.isfinite(data).all() or (data == 0).any():
        raise InputError(
            "frequency, impedance: expected two rows of the same length, impedances finite and not 0"
        )
    admittance = 1 / data
    return kramers_kronig_residual(grid, admittance.imag / (2 * math.pi * grid * eps0), admittance.real)


def consistency(frequency: Real, permittivity: Complex) -> float:
    """Compute the deviation of a permittivity from the Kramers-Kronig relations; NaN where the rows do not allow it."""
    loss = -permittivity.imag * 2 * math.pi * frequency * eps0
    try:
        return kramers_kronig_residual(frequency, permittivity.real, loss)
    except InputError:
        return math.nan
