"""The steady response to a periodic drive from its harmonics, also for materials as declared: an independent method."""

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.stack.harmonics import spectrum


def periodic(transfer, drive, time, *, static, harmonics=4096):
    """Response of one linear quantity at times (n,) [s]; `static` is its response at zero frequency."""
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
