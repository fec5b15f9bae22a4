"""Validation of the inputs of a fit."""

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

# Number of points for which twice the estimated noise is allowed, because the estimate itself is uncertain.
FEW = 20


def check_range(*, low: float, high: float, terms: int, slowest: float | None) -> None:
    """Refuse a band, a number of terms or a slowest time out of range."""
    problems = []
    if not (0 < low < high < np.inf):
        problems.append(f"band {low!r} to {high!r} Hz: needs 0 < low < high.")
    if not 1 <= terms <= DENSE:
        problems.append(
            f"terms = {terms!r}: 1 to {DENSE} Debye terms are allowed; 14 suffice for six decades."
        )
    if not problems and slowest is not None and not 1 / (2 * np.pi * high) < slowest < np.inf:
        problems.append(
            f"slowest = {slowest!r} s: must lie above 1/(2 pi high) = {1 / (2 * np.pi * high):.3g} s."
        )
    if problems:
        raise InputError(problems)


def evaluated(bound_permittivity: Callable[[Real], npt.ArrayLike], frequency: Real) -> Complex:
    """Return a law of the bound permittivity at given frequencies, refusing unphysical values.

    `frequency` (N,) [Hz]; returns `target` (N,).
    """
    target = np.asarray(bound_permittivity(frequency), dtype=complex)
    if target.shape != frequency.shape:
        raise InputError(
            f"the bound permittivity has shape {target.shape} for frequencies of shape {frequency.shape}: "
            "expected one value for each frequency."
        )
    _refuse_unphysical(frequency, target)
    return target


def table(frequency: npt.ArrayLike, bound_permittivity: npt.ArrayLike) -> tuple[Real, Complex]:
    """Return a table in rising order of frequency, refusing unphysical values.

    `frequency`, `bound_permittivity` (N,) [Hz]; returns `frequency`, `bound_permittivity` (N,) [Hz].
    """
    hertz = np.asarray(frequency, dtype=float)
    target = np.asarray(bound_permittivity, dtype=complex)
    if hertz.ndim != 1 or hertz.shape != target.shape or hertz.size < 3:
        raise InputError(
            f"frequency has shape {hertz.shape} and bound permittivity {target.shape}: "
            "expected two lists of equal length, at least 3 points."
        )
    if not np.all(np.isfinite(hertz) & (hertz > 0)):
        raise InputError("frequency: all values must be finite and above 0 Hz.")
    order = np.argsort(hertz, kind="stable")
    _refuse_unphysical(hertz[order], target[order])
    return hertz[order], target[order]


def _refuse_unphysical(frequency: Real, target: Complex) -> None:
    for wrong, what in (
        (~np.isfinite(target), "is not finite"),
        (target.real <= 0, "has a real part <= 0, which no sum of Debye terms has"),
    ):
        if wrong.any():
            at = int(np.argmax(wrong))
            raise InputError(f"bound permittivity = {target[at]:.4g} at {frequency[at]:.4g} Hz {what}.")


def noise_limit(target: Complex) -> float:
    """Return five standard deviations of a spectrum's loss tangent [1] from differences; more for few points."""
    tangent = -target.imag / np.abs(target)
    order = min(3, tangent.size - 1)
    jumps = np.abs(np.diff(tangent, order))
    # The median of many differences excludes those of a steep relaxation; of few the largest is the safe choice.
    typical = np.median(jumps) / 0.6745 if jumps.size >= 12 else np.max(jumps)
    # Noise enters an n-th difference with binomial(2n, n) times its variance; 1 mrad is that of a good instrument.
    deviation = float(typical) / math.sqrt(math.comb(2 * order, order))
    return 1e-3 + 5 * deviation * (1 + FEW / tangent.size)


def refuse_active(frequency: Real, target: Complex, *, allowed: float) -> None:
    """Refuse a negative loss beyond a loss tangent, at one point or in the mean of five.

    `frequency` (N,) [Hz], `target` (N,).
    """
    gain = target.imag / np.abs(target)
    width = min(5, gain.size)
    smooth = np.convolve(gain, np.full(width, 1 / width), mode="same")
    excess = np.maximum(gain - allowed, smooth - allowed / np.sqrt(width))
    if (excess > 0).any():
        at = int(np.argmax(excess))
        raise InputError(
            f"bound permittivity = {target[at]:.4g} near {frequency[at]:.4g} Hz has eps'' < 0: the dielectric "
            "would be active. Write it as eps' - j eps'' with eps'' >= 0; check the sign of the loss, "
            "and that not more conduction was subtracted than the material has."
        )
