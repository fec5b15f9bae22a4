"""Calibration of a sensor from pairs of known value and reading, with the covariance of its line and the error it leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

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
    if not np.ptp(x):
        raise InputError("calibrate: all readings are equal; they have to cover the range of the sensor")
    (sensitivity, intercept), covariance = np.polyfit(x, y, 1, cov=True)
    left = y - intercept - sensitivity * x
    return SensorCalibration(
        sensitivity=float(sensitivity),
        intercept=float(intercept),
        covariance=covariance[::-1, ::-1],
        residual=float(np.sqrt(np.sum(left**2) / (x.size - 2))),
    )


_ATTRIBUTES: Final = {
    "gain": "gain_uncertainty",
    "zero": "zero_uncertainty",
    "covariance": "gain_zero_covariance",
}
"""Number of a calibration error to the attribute of the signal that holds it."""


@dataclass(frozen=True, kw_only=True)
class CalibrationError:
    """Systematic error of a measured signal: values = true values times (1 + gain error) + zero error.

    `gain` is the standard uncertainty of the gain over the gain, `zero` that of the zero in the unit of the
    signal, and `covariance` that of both, in the same unit.
    """

    gain: float = 0.0
    zero: float = 0.0
    covariance: float = 0.0

    def __post_init__(self) -> None:
        numbers = (self.gain, self.zero, self.covariance)
        if not np.isfinite(numbers).all() or self.gain < 0 or self.zero < 0:
            raise InputError(
                f"gain error {self.gain:g}, zero error {self.zero:g}: expected finite uncertainties of 0 or more"
            )
        if abs(self.covariance) > self.gain * self.zero * (1 + 1e-9):
            raise InputError(
                f"covariance of gain and zero {self.covariance:g}: expected at most the product of both uncertainties"
            )

    def attributes(self) -> dict[str, float]:
        """Return the error as attributes of the signal."""
        return {attribute: float(getattr(self, name)) for name, attribute in _ATTRIBUTES.items()}

    @classmethod
    def from_attributes(cls, attributes: Mapping[Any, Any]) -> CalibrationError | None:
        """Read the error from the attributes of a signal; None where no attribute states an error other than 0."""
        try:
            stated = {name: float(attributes.get(attribute, 0.0)) for name, attribute in _ATTRIBUTES.items()}
        except (TypeError, ValueError):
            raise InputError(f"attributes {', '.join(_ATTRIBUTES.values())}: expected numbers") from None
        return cls(**stated) if any(stated.values()) else None
