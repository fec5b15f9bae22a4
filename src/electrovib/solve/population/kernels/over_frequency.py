"""Mean squares of many fingers over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real


def mean_square_over_frequency(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    frequency: ArrayLike,
    *,
    factor: ArrayLike = 1.0,
) -> Real:
    """Compute factor times the squared magnitude of sums of relaxing modes, over 2, for many fingers at frequencies.

    `rates`, `residues` (fingers, modes), `direct`, `factor` (fingers,), `frequency` (n,) [Hz]; returns `mean_square`
    (fingers, n).
    """
    from electrovib.solve.population.kernels import row_loops

    rate, residue, level, angular = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, frequency)
    )
    if rate.ndim != 2 or residue.shape != rate.shape or level.shape != rate.shape[:1] or angular.ndim != 1:
        raise InputError(
            f"rates, residues, direct and frequency have the shapes {rate.shape}, {residue.shape}, {level.shape} and "
            f"{angular.shape}: expected (fingers, modes) twice, (fingers,) and (n,)."
        )
    angular = 2 * np.pi * angular
    half = np.ascontiguousarray(np.broadcast_to(np.asarray(factor, np.float64) / 2, level.shape))
    result = np.empty((len(rate), angular.size))
    row_loops.mean_squares(rate, residue, level, half, angular, result)
    return result
