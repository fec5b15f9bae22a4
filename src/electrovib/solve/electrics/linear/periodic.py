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

    Parameters
    ----------
    transfer : callable
        Complex response per volt at frequencies in Hz, shape (n,) to (n,); materials may be as declared,
        without reduction to Debye terms.
    drive : Drive
        With a period.
    time : ndarray, shape (n,)
        Times [s].
    static : float
        Response at zero frequency, at which a formula in 1/(j w) is not defined.
    harmonics : int
        Number of harmonics of a drive with edges; a sum of sines is complete.

    Returns
    -------
    response : ndarray, shape (n,)
        Real response, in the unit of `transfer` times that of the drive. The harmonics of a piecewise linear drive
        fall as 1/n^2 (as 1/n with discontinuities), so the truncation error is of the order of 1/harmonics^2 of the peak
        (of 1/harmonics near a discontinuity).

    Raises
    ------
    InputError
        If the drive has no period.
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
