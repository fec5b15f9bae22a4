"""Real contact of rough elastic skin after Persson's theory."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def contact_fraction(pressure: ArrayLike, *, modulus: float, slope: float) -> NDArray[np.float64]:
    """Return the share of the nominal area in real contact when a rough elastic body is pressed on a plate.

    erf(sqrt(2) p/(E* h')) from Persson's contact mechanics, cited from memory, unverified. Its limits are
    checked: 1.596 p/(E* h') for small pressures, 1 for large ones.
    """
    from scipy.special import erf

    share: NDArray[np.float64] = erf(math.sqrt(2) * np.asarray(pressure, dtype=float) / (modulus * slope))
    return share


def contact_growth(*, pressure: float, modulus: float, slope: float) -> float:
    """Return the derivative of `contact_fraction` with pressure."""
    reduced = pressure / (modulus * slope)
    return math.sqrt(8 / math.pi) / (modulus * slope) * math.exp(-2 * reduced**2)
