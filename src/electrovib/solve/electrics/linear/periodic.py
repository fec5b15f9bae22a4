"""Steady response to a periodic drive from its harmonics: exact for a finite number of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.stack.harmonics import spectrum

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.base import Drive


def periodic(
    transfer: Callable[[Real], Complex], drive: Drive, time: Real, *, static: float, harmonics: int = 4096
) -> Real:
    """Compute the steady response of one linear quantity.

    `time` (n,) [s]; returns `response` (n,).
    """
    if drive.period is None:
        raise InputError(f"drive: {type(drive).__name__} has no period and therefore no harmonics")
    frequencies, amplitudes = spectrum(drive, harmonics=harmonics)
    gain = np.full(len(frequencies), static, complex)
    moving = frequencies > 0
    gain[moving] = transfer(frequencies[moving])
    total = np.zeros(len(time))
    for frequency, amplitude in zip(frequencies, gain * amplitudes, strict=True):
        total += (amplitude * np.exp(2j * np.pi * frequency * time)).real
    return total
