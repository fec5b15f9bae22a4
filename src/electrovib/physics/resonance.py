"""A resonant force sensor: a mass on a spring whose deflection is the reading."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def release_seen_by_sensor(
    time: NDArray[np.float64], *, start: float, fall_time: float, frequency: float, quality: float
) -> NDArray[np.float64]:
    """Reading of a resonant force sensor after a constant force of 1 that decays exponentially.

    `time` (n,) [s]. The force is 1 until `start` [s] and exp(-(t - start)/fall_time) after it; natural
    `frequency` [Hz] and `quality` factor, above 1/2, of the sensor with all that it carries. The reading is 1
    before the start, 0 long after it.

    Closed form of y'' + (w/Q) y' + w^2 y = w^2 f with y = 1, y' = 0 at the start: A e^{-t/tau} + Re(B
    e^{pt}), p the upper pole of the resonance.
    """
    natural = 2 * np.pi * frequency
    damping = natural / (2 * quality)
    damped = natural * np.sqrt(1 - 1 / (4 * quality**2))
    after = np.maximum(time - start, 0.0)
    rate = 1 / fall_time
    forced = natural**2 / (rate**2 - rate * natural / quality + natural**2)
    real = 1 - forced
    imaginary = (-damping * real - rate * forced) / damped
    ringing = (real + 1j * imaginary) * np.exp((-damping + 1j * damped) * after)
    return np.asarray(forced * np.exp(-rate * after) + ringing.real, dtype=np.float64)
