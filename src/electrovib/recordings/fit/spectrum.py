"""The spectrum of residuals as white noise and a correlated part, by the largest likelihood."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_RATIOS: Final = np.append(0.0, np.geomspace(0.1, 1e5, 31))
"""Power of the correlated part over that of the white one, where it is largest, among which the likeliest is taken."""
_BANDS: Final = 160
"""Bands of components in which the spectrum is compared with the residuals."""
_WORTH: Final = 4.0
"""Twice the logarithm of the likelihood that two further parameters have to gain, by Akaike's criterion."""
_DOUBTED: Final = 13.8
"""Twice the logarithm of the likelihood by which a correlated part has to surpass noise without it: chi-squared with the two
degrees of freedom of power and knee exceeds it once in 1000."""


@dataclass(frozen=True, kw_only=True)
class NoiseSpectrum:
    """Power of noise by components of a cosine transform, shape (samples,).

    - `power`: variance of each component; `share`: that of the correlated part in it.
    - `is_correlated`: whether noise is not white; `is_unexplained`: nor as the declared sensor makes it.
    """

    power: Real
    share: Real
    is_correlated: bool
    is_unexplained: bool


def spectrum_of(energy: Real, freedom: Real, sensor: Real | None = None) -> NoiseSpectrum:
    """Find the spectrum of residuals from their sums of squares and degrees of freedom by component, the slowest first.

    It is a(1 + c/(1 + (k/knee)^2)), as of noise with a memory, or a(1 + c S) with the power S that a
    `sensor` passes, which is taken unless the former is likelier by far; the likelihood is Whittle's.
    """
    count = energy.size
    starts = np.unique(np.geomspace(1, count + 1, min(count, _BANDS) + 1).astype(int))[:-1] - 1
    widths = np.diff(starts, append=count)
    knees = 2.0 ** np.arange(1, max(np.log2(count), 2))
    shapes = [1 / (1 + (np.arange(count) / knee) ** 2) for knee in knees]
    if sensor is not None:
        shapes = [sensor / np.max(sensor), *shapes]
    free = np.maximum(np.add.reduceat(freedom, starts), 0.0)
    mean = np.array([np.add.reduceat(shape, starts) / widths for shape in shapes])
    rises = 1 + _RATIOS[:, None, None] * mean
    level = np.sum(np.add.reduceat(energy, starts) / rises, axis=2) / max(np.sum(free), 1e-9)
    level = np.maximum(level, 1e-100)
    deviance = np.sum(free * np.log(rises), axis=2) + np.sum(free) * np.log(level)
    best, white = float(np.min(deviance)), float(deviance[0, 0])
    declared = white if sensor is None else float(np.min(deviance[:, 0]))
    is_unexplained = declared - best > _DOUBTED
    among = deviance if sensor is None or is_unexplained else deviance[:, :1]
    ratio, shape = np.unravel_index(int(np.argmin(among)), among.shape)
    if white - among[ratio, shape] < _WORTH:
        ratio, shape = np.intp(0), np.intp(0)
    rise = _RATIOS[ratio] * shapes[shape]
    return NoiseSpectrum(
        power=level[ratio, shape] * (1 + rise),
        share=rise / (1 + rise),
        is_correlated=white - min(best, declared) > _DOUBTED,
        is_unexplained=is_unexplained,
    )
