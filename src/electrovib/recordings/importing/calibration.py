"""Calibration of a sensor from pairs of known value and reading, with the covariance of its line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.calibration_error import CalibrationError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real


@dataclass(frozen=True, kw_only=True)
class SensorCalibration:
    """A straight calibration line: value = intercept + sensitivity reading, in SI.

    `covariance` is that of intercept and sensitivity, in that order; `residual` the standard deviation of the
    values about the line.
    """

    sensitivity: float
    intercept: float
    covariance: Real
    residual: float

    def value(self, reading: ArrayLike) -> Real:
        """Convert readings to values."""
        return np.asarray(self.intercept + self.sensitivity * np.asarray(reading, dtype=float))

    def standard_uncertainty(self, reading: ArrayLike) -> Real:
        """Return the standard uncertainty of values by that of the line, common to all samples: it does not average out."""
        at = np.asarray(reading, dtype=float)
        (first, both), (_, second) = self.covariance
        variance: Real = np.maximum(first + 2 * both * at + second * at**2, 0.0)
        return np.asarray(np.sqrt(variance))

    def error(self, *, zero_known: bool = False) -> CalibrationError:
        """Return the systematic error of a signal that the line has converted.

        With value v = a + b r of the reading r, deviations da and db change v by dz + g v, where g = db / b
        and dz = da - (a / b) db. `zero_known` says that a mean or trend of the signal has been subtracted,
        which removes the error of its zero.
        """
        (first, both), (_, second) = self.covariance
        ratio = self.intercept / self.sensitivity
        gain = float(np.sqrt(second)) / abs(self.sensitivity)
        if zero_known:
            return CalibrationError(gain=gain)
        zero = float(np.sqrt(max(first - 2 * ratio * both + ratio**2 * second, 0.0)))
        covariance = float((both - ratio * second) / self.sensitivity)
        largest = gain * zero  # exceeded only by rounding
        return CalibrationError(gain=gain, zero=zero, covariance=min(max(covariance, -largest), largest))


def calibrate(reading: ArrayLike, known: ArrayLike) -> SensorCalibration:
    """Fit a calibration line to readings at known values.

    Parameters
    ----------
    reading : array_like, shape (n,)
        Readings of the sensor, in the SI unit of the reading; at least three, not all equal.
    known : array_like, shape (n,)
        Known values, such as weights [N], without error.

    Returns
    -------
    SensorCalibration
        Least-squares line with its covariance, from the scatter of the values about it with n - 2 degrees of freedom.

    Raises
    ------
    InputError
        If there are fewer than three pairs, one is not finite, or all readings are equal.

    Notes
    -----
    The line is fitted to the values over the readings, which is unbiased if the scatter of the readings is small compared with
    their range.
    """
    x, y = np.asarray(reading, dtype=float), np.asarray(known, dtype=float)
    if x.ndim != 1 or x.shape != y.shape or x.size < 3 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise InputError(
            "calibrate: expected three or more pairs of finite numbers, a reading and a known value"
        )
    centre = x.mean()
    spread = float(np.sum((x - centre) ** 2))
    if not spread:
        raise InputError("calibrate: all readings are equal; they have to cover the range of the sensor")
    sensitivity = float(np.sum((x - centre) * (y - y.mean())) / spread)
    intercept = float(y.mean() - sensitivity * centre)
    variance = float(np.sum((y - intercept - sensitivity * x) ** 2) / (x.size - 2))
    covariance = variance * np.array(
        [[1 / x.size + centre**2 / spread, -centre / spread], [-centre / spread, 1 / spread]]
    )
    return SensorCalibration(
        sensitivity=sensitivity, intercept=intercept, covariance=covariance, residual=float(np.sqrt(variance))
    )
