"""Relaxation of a force over time, and its reading by a resonant sensor, a mass on a spring."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


_POINTS: Final = 300
"""Steps of the numerical reading in a period of the sensor."""


def stretched_exponential(time: Real, *, time_constant: float, stretching: float) -> Real:
    """Compute a stretched exponential relaxation at times (n,) [s] after the start: exp(-(t/tau)^beta), and 1 before it.

    `time_constant` tau, at which 1/e remains [s], above 0; `stretching` beta, above 0, 1 for an exponential.
    """
    return np.asarray(np.exp(-((np.maximum(time, 0.0) / time_constant) ** stretching)))


def stretched_seen_by_sensor(
    time: Real, *, time_constant: float, stretching: float, frequency: float, quality: float
) -> Real:
    """Compute the reading of a resonant sensor after a force of 1 that relaxes as a stretched exponential.

    `time` (n,) [s] after the start of the relaxation, before which the reading is 1; natural `frequency` [Hz]
    and `quality` factor, above 1/2, of the sensor.

    y'' + (w/Q) y' + w^2 y = w^2 f, solved exactly for a force that is linear between the points of a grid of
    300 steps in a period of the sensor, which for stretching between 0.3 and 1.5 leaves an error below 1e-3
    of the change.
    """
    from scipy.signal import lfilter

    last = float(np.max(time))
    if last <= 0:
        return np.ones_like(time)
    count = min(int(np.ceil(last * _POINTS * frequency)) + 2, 200_000)
    grid = np.linspace(0.0, last, count)
    step = grid[1]
    natural = 2 * np.pi * frequency
    pole = natural * complex(-1 / (2 * quality), np.sqrt(1 - 1 / (4 * quality**2)))
    force = stretched_exponential(grid, time_constant=time_constant, stretching=stretching)
    decay = np.exp(pole * step)
    ramp = (decay - 1) / (pole**2 * step) - 1 / pole
    gain = np.array([ramp, (decay - 1) / pole - ramp])
    # the state before the first step is that of a constant force of 1
    state, _ = lfilter(gain, [1.0, -decay], force[1:], zi=[decay * (-1 / pole) + gain[1] * force[0]])
    reading = np.concatenate([[1.0], 2 * np.real(natural**2 / (2j * pole.imag) * state)])
    return np.where(time > 0, np.interp(time, grid, reading), 1.0)


def time_of_progress(progress: float, *, time_constant: float, stretching: float = 1.0) -> float:
    """Compute the time [s] at which a stretched exponential has made a fraction, below 1, of its change.

    tau (-ln(1 - progress))^(1/beta), with tau and beta as for `stretched_exponential`.
    """
    return float(time_constant * (-np.log1p(-progress)) ** (1 / stretching))


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
