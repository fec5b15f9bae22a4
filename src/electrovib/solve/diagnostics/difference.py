"""Signed relaxations on a fixed grid that follow the difference between a declared and a reduced quantity."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real


POLES_PER_DECADE: Final = 10
"""Relaxation rates of the fit of D."""
ROWS_PER_DECADE: Final = 16
"""Frequencies at which D is fitted."""
BEYOND: Final = 10.0
"""Factor by which the relaxation rates of D extend beyond the band on both sides."""
POWERS: Final = (0.0, -0.5, -1.0, 0.5, 1.0)
"""Powers of the frequency by which a quantity may fall; the fit of D is weighted by the one with the least residual."""
AT_REST: Final = 1e-60
"""Frequency that replaces 0, where a power law has no value [Hz]."""


class _DifferenceFit:
    """Signed relaxations on a fixed grid of rates that follow D over a band.

    Parameters
    ----------
    low, high : float
        Band [Hz].
    steady : bool
        Whether D is fitted at zero frequency as well.
    smallest : tuple of float
        Smallest singular values over the largest that are kept; the fit is made with each [1].
    """

    def __init__(self, low: float, high: float, *, steady: bool, smallest: tuple[float, ...]) -> None:
        self.frequency = _spaced(low, high, ROWS_PER_DECADE)
        self.rates = 2 * np.pi * _spaced(low / BEYOND, high * BEYOND, POLES_PER_DECADE)
        falls = [(self.frequency / low) ** -power for power in POWERS]
        if steady:
            self.frequency = np.append(AT_REST, self.frequency)
            self.rates = np.append(1e-6 * self.rates[0], self.rates)
            falls = [np.append(fall[0], fall) for fall in falls]
        s = 2j * np.pi * self.frequency[:, None]
        columns = np.concatenate([np.ones((len(s), 1)), self.rates / (s + self.rates)], axis=1)
        self.columns = np.concatenate([columns.real, columns.imag])
        weights = [np.tile(1 / fall, 2) for fall in falls]
        self.inverses = np.concatenate([_inverses(self.columns, row, smallest) for row in weights])

    @staticmethod
    @functools.lru_cache(maxsize=16)
    def over(low: float, high: float, *, steady: bool, smallest: tuple[float, ...]) -> _DifferenceFit:
        """Return the fit over a band: the same object for the same band."""
        return _DifferenceFit(low, high, steady=steady, smallest=smallest)

    def of(self, declared: Complex, reduced: Complex, *, unasked: bool = False) -> tuple[Transfer, float]:
        """Return the fit of one D and its largest residual over the quantity; with `unasked` without zero frequency."""
        difference, size = declared - reduced, np.maximum(np.abs(declared), np.abs(reduced))
        if unasked and self.frequency[0] == AT_REST:
            difference[0], size[0] = difference[1], size[1]
        wanted = np.concatenate([difference.real, difference.imag])
        size[0] = max(size[:2])  # at rest a quantity may vanish
        floor = np.finfo(float).eps * float(np.max(size, initial=0.0))
        weights = 1 / np.tile(np.maximum(size, floor or 1.0), 2)
        tried = (self.inverses @ wanted).reshape(-1, self.columns.shape[1])
        left = np.max(np.abs(tried @ self.columns.T - wanted) * weights, axis=1)
        best = int(np.argmin(left))
        found = tried[best]
        return Transfer(rates=self.rates, gains=found[1:], direct=float(found[0])), float(left[best])


def _inverses(columns: Real, weights: Real, smallest: tuple[float, ...]) -> Real:
    """Return pseudo-inverses of weighted rows with columns scaled to equal norms, one below the other."""
    weighted = columns * weights[:, None]
    sizes = np.linalg.norm(weighted, axis=0)
    left, values, right = np.linalg.svd(weighted / sizes, full_matrices=False)
    parts = []
    for least in smallest:
        kept = values > least * values[0]
        inverse = (right[kept].T / values[kept]) @ left[:, kept].T
        parts.append(inverse / sizes[:, None] * weights)
    return np.concatenate(parts)


def _spaced(low: float, high: float, per_decade: int) -> Real:
    return np.geomspace(low, high, max(2, int(np.ceil(per_decade * np.log10(high / low))) + 1))
