"""Systematic error of a measured signal by its calibration, and the attributes that carry it in a Trace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

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
