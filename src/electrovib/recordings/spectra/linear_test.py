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
    """Compute the deviation of a measured impedance from the Kramers-Kronig relations.

    Parameters
    ----------
    frequency : array_like, shape (n,)
        Hz, above 0, distinct.
    impedance : array_like of complex, shape (n,)
        ohm, not 0.

    Returns
    -------
    residual : float
        Root mean square of the relative misfit of the admittance, dimensionless: about the noise for an impedance of linear,
        causal parts with a resistive-capacitive spectrum.

    Raises
    ------
    InputError
        For data that are not finite, or too few to judge.

    Notes
    -----
    The admittance over j w is treated as a permittivity and tested as `kramers_kronig_residual` describes. Inductive parts
    count as a misfit.
    """
    grid, data = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.shape != data.shape or grid.ndim != 1 or not np.isfinite(data).all() or (data == 0).any():
        raise InputError(
            "frequency, impedance: expected two rows of the same length, impedances finite and not 0"
        )
    admittance = 1 / data
    return kramers_kronig_residual(grid, admittance.imag / (2 * math.pi * grid * eps0), admittance.real)


def consistency(frequency: Real, permittivity: Complex) -> float:
    """Compute the deviation of a permittivity from the Kramers-Kronig relations.

    Parameters
    ----------
    frequency : ndarray, shape (n,)
        Hz.
    permittivity : ndarray of complex, shape (n,)
        Relative permittivity, conduction included.

    Returns
    -------
    residual : float
        As from `kramers_kronig_residual`; NaN for rows that are too few or at repeated frequencies.
    """
    loss = -permittivity.imag * 2 * math.pi * frequency * eps0
    try:
        return kramers_kronig_residual(frequency, permittivity.real, loss)
    except InputError:
        return math.nan
