"""Least-squares fits of a release recorded by a resonant sensor, and by one without resonance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.recordings.release.parts import levels_and_misfit

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SCALE = (0.05, 0.3, 0.1, 0.3)
"""Changes of the start and of the logarithms of fall time, frequency and quality with about equal effect on the fit."""


@dataclass(frozen=True, kw_only=True)
class Release:
    """A fitted release, with times after the end of the drive.

    `start` is the time at which the force begins to fall, `held` and `after` are its levels before and long
    after, and `misfit` is the rms of the residual over the rms of the force about its last level, both after
    the end of the drive.
    """

    start: float
    fall_time: float
    frequency: float
    quality: float
    held: float
    after: float
    misfit: float
    model: NDArray[np.float64]
    residual: NDArray[np.float64]

    @property
    def delay(self) -> float:
        """Mean time of the fall of the force [s]: its start plus its time constant."""
        return self.start + self.fall_time

    def shape(self, stamps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the normalised reading at times [s] after the end of the drive: 1 before the release, 0 long after it."""
        return release_seen_by_sensor(
            stamps,
            start=self.start,
            fall_time=self.fall_time,
            frequency=self.frequency,
            quality=self.quality,
        )


def resonant_release(*, stamps: NDArray[np.float64], force: NDArray[np.float64], window: float) -> Release:
    """Fit a release and one resonance to times `stamps` after the end of the drive, from the four best points of a grid."""
    fit = _Fit(stamps, force, window)
    starts = [
        np.array([delay / frequency / window, np.log(part / frequency), np.log(frequency), np.log(quality)])
        for frequency in np.geomspace(1.2 * fit.slow, fit.fast / 1.2, 25)
        for quality in (1.0, 3.0, 10.0)
        for delay in (0.0, 0.15, 0.4)
        for part in (0.03, 0.2)
    ]
    starts = [fit.inside(start) for start in starts]
    costs = [float(np.sum(fit.residual(start) ** 2)) for start in starts]
    found = [fit.solve(starts[place]) for place in np.argsort(costs)[:4]]
    return fit.release(min(found, key=lambda result: float(np.sum(fit.residual(result) ** 2))))


def refined(
    stamps: NDArray[np.float64],
    force: NDArray[np.float64],
    begin: Release,
    *,
    window: float,
    fall_time: float | None = None,
) -> Release:
    """Fit the same release to other samples, or with a prescribed fall time."""
    fit = _Fit(stamps, force, window)
    fall = begin.fall_time if fall_time is None else fall_time
    start = max(begin.delay - fall, 0.0)
    logs = np.log([fall, begin.frequency, begin.quality])
    fixed = None if fall_time is None else float(logs[0])
    return fit.release(fit.solve(fit.inside(np.array([start / window, *logs]), fixed), fixed))


class _Fit:
    """Least-squares problem in the start over the window and the logarithms of fall time, frequency and quality."""

    def __init__(self, stamps: NDArray[np.float64], force: NDArray[np.float64], window: float) -> None:
        step = float(np.median(np.diff(stamps)))
        self.stamps, self.force, self.window = stamps, force, window
        self.slow, self.fast = 0.5 / window, 1 / (6 * step)
        if self.fast <= self.slow:
            raise InputError(
                f"samples {step:g} s apart are too few to resolve an oscillation within {window:g} s"
            )
        # a fall faster than a tenth of the step cannot be distinguished from a discontinuity
        self.lowest = np.array([-step / window, np.log(step / 10), np.log(self.slow), np.log(0.6)])
        self.highest = np.array([0.5, np.log(window / 2), np.log(self.fast), np.log(100.0)])

    def inside(self, start: NDArray[np.float64], fixed: float | None = None) -> NDArray[np.float64]:
        clipped = np.clip(start, self.lowest + 1e-6, self.highest - 1e-6)
        if fixed is not None:
            clipped[1] = fixed
        return np.asarray(clipped)

    def _shape(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        fall_time, frequency, quality = (float(value) for value in np.exp(values[1:]))
        start = float(values[0]) * self.window
        return release_seen_by_sensor(
            self.stamps, start=start, fall_time=fall_time, frequency=frequency, quality=quality
        )

    def residual(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return levels_and_misfit(shape=self._shape(values), force=self.force, stamps=self.stamps)[3]

    def solve(self, start: NDArray[np.float64], fixed: float | None = None) -> NDArray[np.float64]:
        from scipy.optimize import least_squares

        free = np.array([0, 2, 3] if fixed is not None else [0, 1, 2, 3])

        def residual(part: NDArray[np.float64]) -> NDArray[np.float64]:
            values = start.copy()
            values[free] = part
            return self.residual(values)

        found = least_squares(
            residual,
            start[free],
            bounds=(self.lowest[free], self.highest[free]),
            x_scale=np.array(_SCALE)[free],
        )
        values = start.copy()
        values[free] = found.x
        return values

    def release(self, values: NDArray[np.float64]) -> Release:
        held, after, misfit, residual, model = levels_and_misfit(
            shape=self._shape(values), force=self.force, stamps=self.stamps
        )
        fall_time, frequency, quality = (float(value) for value in np.exp(values[1:]))
        start = float(values[0]) * self.window
        return Release(
            start=start,
            fall_time=fall_time,
            frequency=frequency,
            quality=quality,
            held=held,
            after=after,
            misfit=misfit,
            model=model,
            residual=residual,
        )


def plain_release(
    *, stamps: NDArray[np.float64], force: NDArray[np.float64], window: float
) -> tuple[float, NDArray[np.float64]]:
    """Fit an exponential release recorded by a sensor without resonance; return misfit, as in `Release`, and fitted force."""
    from scipy.optimize import least_squares

    step = float(np.median(np.diff(stamps)))

    def shape(values: NDArray[np.float64]) -> NDArray[np.float64]:
        late = np.maximum(stamps - values[0] * window, 0.0)
        return np.asarray(np.exp(-late / np.exp(values[1])))

    def residual(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return levels_and_misfit(shape=shape(values), force=force, stamps=stamps)[3]

    bounds = ([-step / window, np.log(step / 10)], [0.5, np.log(window)])
    starts = [
        np.array([delay, np.log(part * window)])
        for delay in (0.02, 0.05, 0.1, 0.2)
        for part in (0.01, 0.05, 0.2)
    ]
    costs = [float(np.sum(residual(start) ** 2)) for start in starts]
    fits = [
        least_squares(residual, starts[place], bounds=bounds, x_scale=[0.01, 0.3])
        for place in np.argsort(costs)[:6]
    ]
    _, _, misfit, _, model = levels_and_misfit(
        shape=shape(min(fits, key=lambda fit: fit.cost).x), force=force, stamps=stamps
    )
    return misfit, model
