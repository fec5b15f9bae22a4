"""Transfer functions of many fingers over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels.choice import compiled

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Complex, Real

_ROWS: Final = 50  # fingers in memory together: their arrays fit in the second-level cache


def transfer_over_frequency(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    frequency: ArrayLike,
    *,
    out: Complex | None = None,
    threads: int | None = None,
) -> Complex:
    """Evaluate sums of relaxing modes of many fingers at frequencies.

    `rates`, `residues`, `direct` (fingers, modes), `frequency` (n,) [Hz], `out` (fingers, n); returns
    `transfer` (fingers, n).
    """
    rate, residue, level, angular = _gather(rates, residues, direct, frequency)
    result = _memory(out, (len(rate), angular.size), np.complex128)
    if (kernel := compiled()) is not None:
        kernel.transfer(rate, residue, level, angular, result, threads)
        return result
    for part in _parts(len(rate)):
        real, imaginary = _sums(rate[part], residue[part], level[part], angular)
        result[part].real, result[part].imag = real, imaginary
    return result


def mean_square_over_frequency(
    rates: ArrayLike,
    residues: ArrayLike,
    direct: ArrayLike,
    frequency: ArrayLike,
    *,
    factor: ArrayLike = 1.0,
    out: Real | None = None,
    threads: int | None = None,
) -> Real:
    """Compute factor times the squared magnitude of sums of relaxing modes, over 2, for many fingers at frequencies.

    `factor` (fingers,), `out` (fingers, n); returns `mean_square` (fingers, n).
    """
    rate, residue, level, angular = _gather(rates, residues, direct, frequency)
    half = np.ascontiguousarray(np.broadcast_to(np.asarray(factor, np.float64) / 2, level.shape))
    result = _memory(out, (len(rate), angular.size), np.float64)
    if (kernel := compiled()) is not None:
        kernel.mean_square(rate, residue, level, angular, half, result, threads)
        return result
    for part in _parts(len(rate)):
        real, imaginary = _sums(rate[part], residue[part], level[part], angular)
        result[part] = half[part, np.newaxis] * (real * real + imaginary * imaginary)
    return result


def cole_cole_over_frequency(
    high: ArrayLike,
    strengths: ArrayLike,
    times: ArrayLike,
    broadening: ArrayLike,
    loss: ArrayLike,
    frequency: ArrayLike,
    *,
    out: Complex | None = None,
    threads: int | None = None,
) -> Complex:
    """Evaluate the permittivities of Cole-Cole materials of many fingers at frequencies.

    `high` (fingers,) [-], `strengths`, `times`, `broadening` (fingers, terms) [-], `loss` (fingers,),
    `frequency` (n,) [Hz], `out` (fingers, n); returns `permittivity` (fingers, n) [-].
    """
    names = high, strengths, times, broadening, loss
    level, strength, time, alpha, leak = (np.ascontiguousarray(each, np.float64) for each in names)
    angular = 2 * np.pi * np.ascontiguousarray(frequency, np.float64)
    if strength.ndim != 2 or not strength.shape == time.shape == alpha.shape:
        shapes = f"{strength.shape}, {time.shape} and {alpha.shape}"
        raise InputError(
            f"strengths, times and broadening have the shapes {shapes}: expected (fingers, terms) each."
        )
    if not level.shape == leak.shape == strength.shape[:1] or angular.ndim != 1:
        raise InputError("high, loss or frequency has the wrong shape: expected (fingers,) twice, and (n,).")
    if not ((time > 0).all() and (angular > 0).all()):
        raise InputError("times or frequency has a value of 0 or below: expected positive numbers.")
    result = _memory(out, (len(level), angular.size), np.complex128)
    if (kernel := compiled()) is not None:
        kernel.cole_cole(level, strength, time, alpha, leak, angular, result, threads)
        return result
    for part in _parts(len(level)):
        _cole_cole(level[part], strength[part], time[part], alpha[part], leak[part], angular, result[part])
    return result


def _cole_cole(
    level: Real, strength: Real, time: Real, alpha: Real, leak: Real, angular: Real, result: Complex
) -> None:
    """Write the permittivities of some fingers, in real arithmetic."""
    real, imaginary = np.zeros((2, len(level), angular.size))
    real += level[:, np.newaxis]
    imaginary -= leak[:, np.newaxis] / angular
    logarithm = np.log(angular)
    for term in range(strength.shape[1]):
        power = 1 - alpha[:, term, np.newaxis]
        size = np.exp(power * (logarithm + np.log(time[:, term, np.newaxis])))
        along, across = 1 + size * np.cos(np.pi / 2 * power), size * np.sin(np.pi / 2 * power)
        share = strength[:, term, np.newaxis] / (along * along + across * across)
        real += share * along
        imaginary -= share * across
    result.real, result.imag = real, imaginary


def _sums(rate: Real, residue: Real, level: Real, angular: Real) -> tuple[Real, Real]:
    """Return real and imaginary part of the transfer functions of some fingers, in real arithmetic."""
    square = angular * angular
    real, imaginary = np.zeros((2, len(rate), angular.size))
    for mode in range(rate.shape[1]):
        of_rate = rate[:, mode, np.newaxis]
        share = residue[:, mode, np.newaxis] / (of_rate * of_rate + square)
        real += of_rate * share
        imaginary += share
    return real + level[:, np.newaxis], -angular * imaginary


def _memory(out: NDArray[Any] | None, shape: tuple[int, int], dtype: Any) -> NDArray[Any]:
    """Return the memory given for a result, or new memory; refuse memory of another shape or type."""
    if out is None:
        return np.empty(shape, dtype)
    if out.shape != shape or out.dtype != dtype or not out.flags.c_contiguous:
        raise InputError(
            f"out has shape {out.shape} and type {out.dtype}: expected {shape}, {np.dtype(dtype)} and contiguous."
        )
    return out


def _parts(count: int) -> list[slice]:
    return [slice(begin, begin + _ROWS) for begin in range(0, count, _ROWS)]


def _gather(
    rates: ArrayLike, residues: ArrayLike, direct: ArrayLike, frequency: ArrayLike
) -> tuple[Real, Real, Real, Real]:
    """Return contiguous arrays, with angular frequencies [1/s]."""
    rate, residue, level, angular = (
        np.ascontiguousarray(each, np.float64) for each in (rates, residues, direct, frequency)
    )
    if rate.ndim != 2 or residue.shape != rate.shape or level.shape != rate.shape[:1] or angular.ndim != 1:
        raise InputError(
            f"rates, residues, direct and frequency have the shapes {rate.shape}, {residue.shape}, {level.shape} and "
            f"{angular.shape}: expected (fingers, modes) twice, (fingers,) and (n,)."
        )
    return rate, residue, level, 2 * np.pi * angular
