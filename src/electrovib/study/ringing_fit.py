"""Least-squares fits of a release, seen by a load cell that rings and by one that does not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.study.ringing_parts import levels_and_misfit

if TYPE_CHECKING:
    from numpy.typing import NDArray

Fit = tuple[tuple[float, float, float, float], float, float, float, "NDArray[np.float64]"]


def resonant_release(stamps: NDArray[np.float64], force: NDArray[np.float64], window: float) -> Fit:
    """Fit a release and the resonance of the cell, from the best of a grid.

    Parameters
    ----------
    stamps : ndarray, shape (n,)
        s after the end of the drive.
    force : ndarray, shape (n,)
        N.
    window : float
        How long after that end the samples go on [s].

    Returns
    -------
    tuple
        Delay, fall time [s], frequency [Hz] and quality [1] as one; force before and long after [N]; misfit [1];
        model, shape (n,) [N].

    Raises
    ------
    InputError
        If the samples are too far apart to show a ringing.
    """
    from scipy.optimize import least_squares

    step = float(np.median(np.diff(stamps)))
    slow, fast = 0.5 / window, 1 / (6 * step)
    if fast <= slow:
        raise InputError(f"samples {step:g} s apart are too few to show a ringing within {window:g} s")

    def shape(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        fall_time, frequency, quality = (float(value) for value in np.exp(logs[1:]))
        return release_seen_by_sensor(
            stamps, start=float(logs[0]) / slow, fall_time=fall_time, frequency=frequency, quality=quality
        )

    def residual(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        return levels_and_misfit(shape(logs), force, stamps)[3]

    # a fall faster than a tenth of the step cannot be told from a jump
    lowest = np.array([-step * slow, np.log(step / 10), np.log(slow), np.log(0.6)])
    highest = np.array([window * slow / 2, np.log(window / 2), np.log(fast), np.log(100.0)])
    starts = [
        np.array([delay / frequency * slow, np.log(part / frequency), np.log(frequency), np.log(quality)])
        for frequency in np.geomspace(1.2 * slow, fast / 1.2, 25)
        for quality in (1.0, 3.0, 10.0)
        for delay in (0.0, 0.15, 0.4)
        for part in (0.03, 0.2)
    ]
    starts = [np.clip(start, lowest + 1e-6, highest - 1e-6) for start in starts]
    costs = [float(np.sum(residual(start) ** 2)) for start in starts]
    best = None
    for place in np.argsort(costs)[:4]:
        found = least_squares(residual, starts[place], bounds=(lowest, highest), x_scale=[0.1, 0.3, 0.1, 0.3])
        best = found if best is None or found.cost < best.cost else best
    assert best is not None
    held, after, misfit, _, model = levels_and_misfit(shape(best.x), force, stamps)
    fall_time, frequency, quality = (float(value) for value in np.exp(best.x[1:]))
    return (float(best.x[0]) / slow, fall_time, frequency, quality), held, after, misfit, model


def plain_release(
    stamps: NDArray[np.float64], force: NDArray[np.float64], window: float
) -> tuple[float, NDArray[np.float64]]:
    """Fit an exponential release to a cell that follows at once.

    Parameters
    ----------
    stamps : ndarray, shape (n,)
        s after the end of the drive.
    force : ndarray, shape (n,)
        N.
    window : float
        How long after that end the samples go on [s].

    Returns
    -------
    tuple
        Misfit [1] and model, shape (n,) [N].
    """
    from scipy.optimize import least_squares

    step = float(np.median(np.diff(stamps)))

    def shape(values: NDArray[np.float64]) -> NDArray[np.float64]:
        late = np.maximum(stamps - values[0] * window, 0.0)
        return np.asarray(np.exp(-late / np.exp(values[1])))

    def residual(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return levels_and_misfit(shape(values), force, stamps)[3]

    bounds = ([-step / window, np.log(step / 10)], [0.5, np.log(window)])
    fits = [
        least_squares(residual, [delay, np.log(part * window)], bounds=bounds, x_scale=[0.01, 0.3])
        for delay in (0.02, 0.05, 0.1, 0.2)
        for part in (0.01, 0.05, 0.2)
    ]
    _, _, misfit, _, model = levels_and_misfit(shape(min(fits, key=lambda fit: fit.cost).x), force, stamps)
    return misfit, model
