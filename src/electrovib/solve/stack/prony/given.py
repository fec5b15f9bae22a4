"""What the caller gives, checked before any fit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.stack.prony.start import DENSE

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from electrovib.core.arrays import Complex, Real

# Points at which the estimate of the noise is itself so uncertain that twice of it is allowed.
FEW = 20


def check_range(*, low: float, high: float, terms: int, slowest: float | None) -> None:
    """Raise if the band, the number of terms or the slowest time is out of range.

    Parameters
    ----------
    low, high : float
        Band, Hz.
    terms : int
        Relaxations.
    slowest : float or None
        Longest relaxation time, s.

    Raises
    ------
    InputError
        If one of them is out of range, with every one that is.
    """
    problems = []
    if not (0 < low < high < np.inf):
        problems.append(f"band {low!r} to {high!r} Hz: needs 0 < low < high.")
    if not 1 <= terms <= DENSE:
        problems.append(f"terms = {terms!r}: 1 to {DENSE} Debye terms are allowed; 14 serve six decades.")
    if not problems and slowest is not None and not 1 / (2 * np.pi * high) < slowest < np.inf:
        problems.append(
            f"slowest = {slowest!r} s: must lie above 1/(2 pi high) = {1 / (2 * np.pi * high):.3g} s."
        )
    if problems:
        raise InputError(problems)


def evaluated(polarisation: Callable[[Real], npt.ArrayLike], frequency: Real) -> Complex:
    """Return the law at the frequencies, refused unless finite with a positive real part.

    Parameters
    ----------
    polarisation : callable
        Frequencies to relative permittivity.
    frequency : ndarray, shape (N,)
        Hz.

    Returns
    -------
    ndarray of complex, shape (N,)
        1.

    Raises
    ------
    InputError
        If the law does not give one finite value with a positive real part for each frequency.
    """
    target = np.asarray(polarisation(frequency), dtype=complex)
    if target.shape != frequency.shape:
        raise InputError(
            f"the bound permittivity has shape {target.shape} for frequencies of shape {frequency.shape}: "
            "give one value for each frequency."
        )
    _refuse_unphysical(frequency, target)
    return target


def table(frequency: npt.ArrayLike, polarisation: npt.ArrayLike) -> tuple[Real, Complex]:
    """Return a table in rising order of frequency, refused unless finite with a positive real part.

    Parameters
    ----------
    frequency, polarisation : array_like, shape (N,)
        Hz; relative permittivity without conduction, 1.

    Returns
    -------
    tuple of ndarray, shape (N,)
        The same, sorted.

    Raises
    ------
    InputError
        If the lists differ in length, have fewer than 3 points, or hold a value that is not finite or not positive.
    """
    hertz = np.asarray(frequency, dtype=float)
    target = np.asarray(polarisation, dtype=complex)
    if hertz.ndim != 1 or hertz.shape != target.shape or hertz.size < 3:
        raise InputError(
            f"frequency has shape {hertz.shape} and polarisation {target.shape}: "
            "give two lists of equal length, at least 3 points."
        )
    if not np.all(np.isfinite(hertz) & (hertz > 0)):
        raise InputError("frequency: all values must be finite and above 0 Hz.")
    order = np.argsort(hertz, kind="stable")
    _refuse_unphysical(hertz[order], target[order])
    return hertz[order], target[order]


def _refuse_unphysical(frequency: Real, target: Complex) -> None:
    for wrong, what in (
        (~np.isfinite(target), "is not finite"),
        (target.real <= 0, "has a real part <= 0, which no sum of Debye terms gives"),
    ):
        if wrong.any():
            at = int(np.argmax(wrong))
            raise InputError(f"polarisation = {target[at]:.4g} at {frequency[at]:.4g} Hz {what}.")


def noise_limit(target: Complex) -> float:
    """Return five standard deviations of the loss tangent [1] of a spectrum, more for few points, from differences."""
    tangent = -target.imag / np.abs(target)
    order = min(3, tangent.size - 1)
    jumps = np.abs(np.diff(tangent, order))
    # The median of many leaves out the few of a steep relaxation; among few the largest is the safe one.
    typical = np.median(jumps) / 0.6745 if jumps.size >= 12 else np.max(jumps)
    # Noise enters an n-th difference with binomial(2n, n) times its variance; 1 mrad is a good instrument.
    deviation = float(typical) / math.sqrt(math.comb(2 * order, order))
    return 1e-3 + 5 * deviation * (1 + FEW / tangent.size)


def refuse_active(frequency: Real, target: Complex, *, allowed: float) -> None:
    """Raise if eps'' < 0 beyond a loss tangent, at one point or in the mean of five.

    Parameters
    ----------
    frequency : ndarray, shape (N,)
        Hz.
    target : ndarray of complex, shape (N,)
        Relative permittivity, 1.
    allowed : float
        Loss tangent that noise may have, 1.

    Raises
    ------
    InputError
        If the loss is negative beyond what is allowed.
    """
    gain = target.imag / np.abs(target)
    width = min(5, gain.size)
    smooth = np.convolve(gain, np.full(width, 1 / width), mode="same")
    excess = np.maximum(gain - allowed, smooth - allowed / np.sqrt(width))
    if (excess > 0).any():
        at = int(np.argmax(excess))
        raise InputError(
            f"polarisation = {target[at]:.4g} near {frequency[at]:.4g} Hz has eps'' < 0: the dielectric "
            "would give energy away. Write it as eps' - j eps'' with eps'' >= 0; check the sign of the loss, "
            "and that not more conduction was taken out than the material has."
        )
