"""Debye terms of a polarisation spectrum, given as a function or as a table."""

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
# Terms this far beyond the band show in it as a constant, or as conduction, to less than 1 part in 100.
SLOW_ROOM, FAST_ROOM = 100.0, 1000.0


@dataclass(frozen=True, kw_only=True)
class PronyFit:
    """Debye terms of a spectrum and how well they follow it.

    Parameters
    ----------
    debye : DebyeSum
        The terms.
    largest_error, rms_error : float
        Largest and root mean square of the modulus of fit/target - 1, 1, over ``band``.
    band : tuple of float
        Lowest and highest frequency of the target, Hz.
    """

    debye: DebyeSum
    largest_error: float
    rms_error: float
    band: tuple[float, float]


def fit_debye(
    polarisation: Callable[[Real], npt.ArrayLike],
    *,
    low: float,
    high: float,
    terms: int = 14,
    slowest: float | None = None,
) -> PronyFit:
    """Reduce a polarisation law to Debye terms that are passive by construction.

    Parameters
    ----------
    polarisation : callable
        Takes frequencies, Hz, shape (N,), and gives the relative permittivity ``eps' - j eps''`` without
        conduction, 1, shape (N,).
    low, high : float
        Ends of the band, Hz, 0 < low < high.
    terms : int
        Most Debye terms, 1 to 59; terms that come out as zero are dropped.
    slowest : float, optional
        Longest relaxation time allowed, s, above 1/(2 pi high); by default 100/(2 pi low).

    Returns
    -------
    PronyFit
        The terms, from fast to slow, and their error on a grid four times as dense as that of the fit.

    Raises
    ------
    InputError
        The band, ``terms`` or ``slowest`` is out of range, or the law is active (eps'' < 0), not finite, or
        has eps' <= 0 in the band.

    Notes
    -----
    Non-negative least squares on a grid of relaxation times gives the start, least squares in the logarithms
    of all parameters refines it, and reweighting [1]_ brings the largest relative error down. Non-negative
    terms exist for Cole-Cole and constant-phase laws, and for Havriliak-Negami laws with alpha <= 1 and
    alpha beta <= 1; a law without them still gets the nearest passive sum, and ``largest_error`` shows it.
    Outside the band the sum is passive but says nothing about the material.

    References
    ----------
    .. [1] C. L. Lawson, *Contributions to the theory of linear least maximum approximation*, thesis,
       University of California, Los Angeles, 1961.
    """
    check_range(low=low, high=high, terms=terms, slowest=slowest)
    decades = np.log10(high / low)
    count = max(int(np.ceil(PER_DECADE * decades)) + 1, 4 * terms + 1)
    frequency = np.geomspace(low, high, count)
    target = evaluated(polarisation, frequency)
    refuse_active(frequency, target, allowed=1e-9)
    spectrum = _spectrum(frequency, target, SLOW_ROOM / (2 * np.pi * low) if slowest is None else slowest)
    found = tidied(spectrum, level_errors(spectrum, _least(spectrum, terms)))
    check = np.geomspace(low, high, 4 * count)
    return _report(found, check, evaluated(polarisation, check))


def fit_debye_table(
    frequency: npt.ArrayLike,
    polarisation: npt.ArrayLike,
    *,
    terms: int = 14,
    slowest: float | None = None,
) -> PronyFit:
    """Reduce a measured polarisation spectrum to Debye terms that are passive by construction.

    Parameters
    ----------
    frequency : array_like
        Frequencies, Hz, shape (N,), N >= 3, positive, in any order.
    polarisation : array_like of complex
        Relative permittivity ``eps' - j eps''`` with the declared conduction taken out, 1, shape (N,).
    terms : int
        Most Debye terms, 1 to 59; never more than N - 1.
    slowest : float, optional
        Longest relaxation time allowed, s; by default 1/(2 pi min(frequency)).

    Returns
    -------
    PronyFit
        The terms, from fast to slow, and their error against the table itself, noise included.

    Raises
    ------
    InputError
        The table is too short, not finite, not positive, or active beyond its noise.

    Notes
    -----
    Plain least squares of the relative error: reweighting towards the worst point would follow the noise.
    By default no term is slower than the lowest frequency shows, because noisy data cannot tell such a term
    from conduction; loss of that kind left in the table stays as error at the lowest frequencies (6 % for a
    constant phase of exponent 0.75). Where the conduction is known, ``slowest`` of ten times the default lets
    the fit take it as polarisation.
    """
    hertz, target = table(frequency, polarisation)
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
