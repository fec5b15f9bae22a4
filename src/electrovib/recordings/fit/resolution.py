"""The resolution of a recorded signal, and how its rounding errors depend on the noise before rounding."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_FEWEST: Final = 20
"""Fewest samples from which a resolution is found."""
_FIT: Final = 1e-3
"""Departure of the distances between recorded values from whole multiples of the resolution, over the resolution."""
_HARMONICS: Final = 64


def resolution_of(values: Real) -> float:
    """Return the smallest step between distinct values of a signal if all their distances are whole multiples of it, else 0.

    It is 0 too for fewer than 20 samples, or more than half as many distinct values as samples.
    """
    distinct = np.unique(values)
    if values.size < _FEWEST or not 1 < distinct.size <= values.size / 2:
        return 0.0
    precision = 16 * np.spacing(np.max(np.abs(distinct)))
    steps = np.diff(distinct)
    steps = steps[steps > precision]
    if not steps.size:
        return 0.0
    smallest = float(np.min(steps))
    # from the widest distance, because the smallest one has the largest relative error
    whole = np.round((distinct - distinct[0]) / smallest)
    finest = float((distinct[-1] - distinct[0]) / whole[-1])
    off = np.abs(distinct - distinct[0] - whole * finest)
    return finest if np.all(off <= _FIT * finest + precision) else 0.0


def rounding_amplitudes(noise: float, resolution: float) -> Real:
    """Compute the amplitudes of the mean rounding error as a function of the value that is rounded, harmonics 1 to k.

    (q/(pi k)) (-1)^k exp(-2 (pi k sigma/q)^2) with the resolution q and the noise sigma before rounding: the
    Fourier series of the sawtooth, averaged over the noise (Widrow and Kollar, Quantization Noise, 2008).
    From sigma = q/2 on it vanishes, and rounding adds an independent error of the variance q^2/12.
    """
    order = np.arange(1, _HARMONICS + 1)
    damped = np.exp(-2 * (np.pi * order * noise / resolution) ** 2)
    return np.asarray(resolution / np.pi * (-1.0) ** order / order * damped)


def least_noise(scatter: float, coherence: float) -> float:
    """Return the noise before rounding, over the step, that the scatter of residuals over the step implies at least.

    At all positions between two steps alike the variance of rounded values is that of the noise plus 1/12;
    halfway between two steps it is largest, and 1/4 without noise. The share `coherence` of the samples is
    assumed to be there.
    """
    from scipy.optimize import brentq

    def variance(noise: float) -> float:
        return (1 - coherence) * (noise**2 + 1 / 12) + coherence * _variance_halfway(noise)

    if variance(0.0) >= scatter**2:
        return 0.0
    return float(brentq(lambda noise: variance(noise) - scatter**2, 0.0, scatter))


def _variance_halfway(noise: float) -> float:
    """Return the variance of rounded values about halfway between two steps, over the square of the step [1]."""
    from scipy.stats import norm

    if noise > 1:
        return noise**2 + 1 / 12
    if noise == 0:
        return 0.25
    edges = np.arange(12.0)
    return float(np.sum(2 * np.diff(norm.cdf(edges / noise)) * (edges[1:] - 0.5) ** 2))


def coherence_of(steps: Real) -> float:
    """Return how much the rounding errors of a signal are alike: from 0, spread over many steps evenly, to 1, constant.

    It is the mean of the cosine of 2 pi times the distance in steps, over all pairs of samples, or the share
    of pairs in the same half of a step if that is larger. `steps` is the prediction over the step between
    recorded values.
    """
    _, counts = np.unique(np.floor(2 * steps), return_counts=True)
    alike = float(np.abs(np.mean(np.exp(2j * np.pi * steps))) ** 2)
    return min(1.0, max(alike, float(np.sum((counts / steps.size) ** 2))))
