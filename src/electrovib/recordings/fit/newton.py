"""The step to the minimum of a linearised least-squares problem."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.recordings.fit.estimate import LEAST_DETERMINED

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


def newton_step(derivatives: Real, residual: Real) -> tuple[Real, Real]:
    """Compute the Gauss-Newton step, NaN where it is not determined, and the deviations for residuals of variance 1."""
    scale = np.linalg.norm(derivatives, axis=0)
    count = len(scale)
    if not np.isfinite(scale).all() or not scale.all():
        return np.full(count, np.nan), np.full(count, np.nan)
    orthonormal, triangle = np.linalg.qr(derivatives / scale)
    diagonal = np.abs(np.diag(triangle))
    if diagonal.min() < LEAST_DETERMINED * diagonal.max():
        return np.full(count, np.nan), np.full(count, np.nan)
    inverse = np.linalg.inv(triangle)
    return -inverse @ (orthonormal.T @ residual) / scale, np.linalg.norm(inverse, axis=1) / scale
