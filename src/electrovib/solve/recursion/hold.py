"""Weights that advance a relaxing or oscillating mode exactly by one straight piece of drive."""

from __future__ import annotations

from math import factorial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

# 1/2!, 1/3!, ...: the first term left out is below 1e-17 of the sum for every |z| < 1
_SERIES = [1.0 / factorial(order) for order in range(2, 19)]
_Weights: TypeAlias = "tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]"


def hold_weights(z: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Compute the weights of the old state and of both ends of a straight piece of drive for a relaxing mode.

    A positive ``z`` is a growing mode and gives meaningless weights; ``march`` refuses it.  For ``x' = p (x -
    v)``, ``z = p h`` and ``u = -z`` the step is ``x(h) = decay x(0) + first v(0+) + last v(h-)`` with::
    decay = exp(-u),  first = (1 - exp(-u))/u - exp(-u),  last = 1 - (1 - exp(-u))/u  Both differences cancel
    for small ``u``; there ``first = exp(-u) (u/2! + u^2/3! + ...)`` has positive terms only and ``last = 1 -
    exp(-u) - first``. The relative error is about 1e-15 for every ``z`` between -1e300 and -1e-300 (``decay``
    itself becomes subnormal below -708).
    """
    fall = -np.asarray(z, dtype=np.float64)
    decay = np.exp(-fall)
    rise = -np.expm1(-fall)
    small = np.minimum(fall, 1.0)
    series = np.full_like(small, _SERIES[-1])
    for term in _SERIES[-2::-1]:
        series *= small
        series += term
    series *= small
    mean = rise / np.maximum(fall, 1.0)
    first = np.where(fall < 1.0, decay * series, mean - decay)
    last = np.where(fall < 1.0, rise - first, 1.0 - mean)
    return decay, first, last


def hold_weights_complex(z: ArrayLike) -> _Weights:
    """Compute the weights of the old state and of both ends of a straight piece of drive for an oscillating mode.

    The formulas are those of ``hold_weights``. For ``|z| < 1`` the series keeps every digit of ``first`` and
    ``last``. Beyond, ``first = (1 - exp(-u))/u - exp(-u)`` is exact to about 1e-15 of the larger of its two
    terms; the value itself passes through zero near u = 2.1 + 7.5j (and further out).
    """
    fall = -np.asarray(z, dtype=np.complex128)
    size = np.abs(fall)
    decay = np.exp(-fall)
    rise = -np.expm1(-fall)
    small = np.where(size < 1.0, fall, 0.0)
    series = np.full_like(small, _SERIES[-1])
    for term in _SERIES[-2::-1]:
        series *= small
        series += term
    series *= small
    mean = rise / np.where(size < 1.0, 1.0, fall)
    first = np.where(size < 1.0, decay * series, mean - decay)
    last = np.where(size < 1.0, rise - first, 1.0 - mean)
    return decay, first, last


def weights_of(z: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return the weights of real or complex modes, as numbers of the type of the poles [-]."""
    return hold_weights_complex(z) if np.iscomplexobj(z) else hold_weights(z)
