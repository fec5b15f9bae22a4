"""Harmonics of a force at multiples of the frequency of a target."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

MOST: Final = 5
"""Highest multiple of the frequency."""


def harmonics(edges: Real, predicted: Real, wanted: Real, frequency: float | None) -> dict[int, float]:
    """Return amplitudes at 1 to 5 times a frequency, over the wanted amplitude at that frequency.

    They are fitted to means over intervals by least squares of a constant and all sines over the last whole
    periods, without the first one if there are several; a multiple needs intervals shorter than half its
    period.
    """
    if frequency is None:
        return {}
    whole = math.floor(float(edges[-1] - edges[0]) * frequency * (1 + 1e-9))
    if whole < 1:
        return {}
    middles = (edges[1:] + edges[:-1]) / 2
    kept = middles >= edges[-1] - max(1, whole - 1) / frequency
    interval = float(edges[1] - edges[0])
    orders = [each for each in range(1, MOST + 1) if 2 * each * frequency * interval < 1]
    if not orders:
        return {}
    first = _amplitudes(middles[kept], wanted[kept], [frequency])[0]
    if first <= 0:
        return {}
    found = _amplitudes(middles[kept], predicted[kept], [each * frequency for each in orders])
    return {order: float(each / first) for order, each in zip(orders, found, strict=True)}


def _amplitudes(times: Real, values: Real, frequencies: list[float]) -> Real:
    """Return the amplitudes of sines and a constant fitted together, of the sines alone."""
    turns = 2 * np.pi * np.array(frequencies) * times[:, None]
    basis = np.column_stack([np.ones(len(times)), np.cos(turns), np.sin(turns)])
    found = np.linalg.lstsq(basis, values, rcond=None)[0][1:].reshape(2, -1)
    return np.asarray(np.hypot(*found))
