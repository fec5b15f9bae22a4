"""Real contact of rough elastic skin after Persson's theory."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def contact_fraction(pressure: ArrayLike, *, modulus: float, slope: float) -> NDArray[np.float64]:
    """Return the share of the nominal area in real contact when a rough elastic body is pressed on a plate.

    Parameters
    ----------
    pressure : float or array_like
        Nominal pressure [Pa], 0 or more: load plus attraction.
    modulus : float
        Effective modulus E/(1 - nu^2) [Pa], above 0.
    slope : float
        Root mean square slope of the roughness, above 0.

    Returns
    -------
    share : float or ndarray
        Real over nominal contact area [1], from 0 to 1.

    Notes
    -----
    erf(sqrt(2) p/(E* h')) from Persson's contact mechanics, cited from memory, unverified. Its limits are checked:
    1.596 p/(E* h') for small pressures, 1 for large ones.
    """
    from scipy.special import erf

    share: NDArray[np.float64] = erf(math.sqrt(2) * np.asarray(pressure, dtype=float) / (modulus * slope))
    return share


def contact_growth(*, pressure: float, modulus: float, slope: float) -> float:
    """Return the derivative of `contact_fraction` with pressure [1/Pa]: sqrt(8/pi)/(E* h') exp(-2 (p/(E* h'))^2)."""
    reduced = pressure / (modulus * slope)
    return math.sqrt(8 / math.pi) / (modulus * slope) * math.exp(-2 * reduced**2)
