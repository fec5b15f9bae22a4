"""Debye terms of a spectrum of the bound permittivity, given as a function or as a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.arrays import Complex, Real
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.prony.given import check_range, evaluated, noise_limit, refuse_active, table
from electrovib.solve.stack.prony.polish import EXACT, least_squares, level_errors, tidied
from electrovib.solve.stack.prony.spectrum import Spectrum, Terms
from electrovib.solve.stack.prony.start import clustered_start, even_start

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

PER_DECADE = 15
# Terms this factor beyond the band act in it as a constant, or as conduction, to less than 1 part in 100.
SLOW_ROOM, FAST_ROOM = 100.0, 1000.0


@dataclass(frozen=True, kw_only=True)
class PronyFit:
    """Debye terms of a spectrum, with their error.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error, rms_error : float
        Largest value and root mean square of the modulus of fit/target - 1 over ``band`` [1].
    band : tuple of float
        Lowest and highest frequency of the target [Hz].
    """

    debye: DebyeSum
    largest_error: float
    rms_error: float
    band: tuple[float, float]


def fit_debye(
    bound_permittivity: Callable[[Real], npt.ArrayLike],
    *,
    low: float,
    high: float,
    terms: int = 14,
    slowest: float | None = None,
) -> PronyFit:
    """Reduce a law of the bound permittivity to Debye terms that are passive by construction.

    Non-negative least squares on a grid of relaxation times gives the start, least squares in the logarithms
    of all parameters refines it, and reweighting [1]_ reduces the largest relative error. Non-negative terms
    exist for Cole-Cole and constant-phase laws, and for Havriliak-Negami laws with alpha <= 1 and alpha beta
    <= 1; for a law without them the result is the nearest passive sum, with its ``largest_error``. Outside
    the band the sum is passive but does not describe the material.
    """
    check_range(low=low, high=high, terms=terms, slowest=slowest)
    decades = np.log10(high / low)
    count = max(int(np.ceil(PER_DECADE * decades)) + 1, 4 * terms + 1)
    frequency = np.geomspace(low, high, count)
    target = evaluated(bound_permittivity, frequency)
    refuse_active(frequency, target, allowed=1e-9)
    spectrum = _spectrum(frequency, target, SLOW_ROOM / (2 * np.pi * low) if slowest is None else slowest)
    found = tidied(spectrum, level_errors(spectrum, _least(spectrum, terms)))
    check = np.geomspace(low, high, 4 * count)
    return _report(found, check, evaluated(bound_permittivity, check))


def fit_debye_table(
    frequency: npt.ArrayLike,
    bound_permittivity: npt.ArrayLike,
    *,
    terms: int = 14,
    slowest: float | None = None,
) -> PronyFit:
    """Reduce a measured spectrum of the bound permittivity to Debye terms that are passive by construction.

    `frequency` (N,) [Hz], `bound_permittivity` (N,).

    Plain least squares of the relative error: reweighting towards the worst point would follow the noise.
    By default no term is slower than 1/(2 pi) of the lowest frequency, because noisy data cannot distinguish such a term
    from conduction; loss of that kind in the table remains as an error at the lowest frequencies (6 % for a
    constant phase of exponent 0.75). Where the conduction is known, a ``slowest`` of ten times the default allows
    the fit to represent that loss by relaxations.
    """
    hertz, target = table(frequency, bound_permittivity)
    low, high = float(hertz[0]), float(hertz[-1])
    check_range(low=low, high=high, terms=terms, slowest=slowest)
    refuse_active(hertz, target, allowed=noise_limit(target))
    spectrum = _spectrum(hertz, target, 1 / (2 * np.pi * low) if slowest is None else slowest)
    found = _least(spectrum, min(terms, hertz.size - 1))
    return _report(found, hertz, target)


def _least(spectrum: Spectrum, terms: int) -> Terms:
    starts = [clustered_start(spectrum, terms), even_start(spectrum, terms)]
    polished = [
        tidied(spectrum, least_squares(spectrum, start, evaluations=80)) if start.times.size else start
        for start in starts
    ]
    errors = [float(np.linalg.norm(spectrum.relative_error(one))) for one in polished]
    good = [one for one, error in zip(polished, errors, strict=True) if error <= max(min(errors), EXACT)]
    return min(good, key=lambda one: one.times.size)


def _spectrum(frequency: Real, target: Complex, slowest: float) -> Spectrum:
    return Spectrum(
        angular=2 * np.pi * frequency,
        target=target,
        fastest=1 / (2 * np.pi * frequency[-1] * FAST_ROOM),
        slowest=slowest,
    )


def _report(terms: Terms, frequency: Real, target: Complex) -> PronyFit:
    debye = DebyeSum(terms.high, tuple(map(float, terms.strengths)), tuple(map(float, terms.times)))
    error = np.abs(debye.permittivity(frequency) / target - 1)
    return PronyFit(
        debye=debye,
        largest_error=float(error.max()),
        rms_error=float(np.sqrt(np.mean(error**2))),
        band=(float(frequency[0]), float(frequency[-1])),
    )
