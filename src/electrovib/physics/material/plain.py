"""Dielectrics of one permittivity, and of one loss angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material.base import CONDUCTIVITY, NAN_PASSES, Material, level

if TYPE_CHECKING:
    from collections.abc import Mapping


class Constant(Material):
    """A dielectric without dispersion."""

    equation: ClassVar[Mapping[str, str]] = {"bound_permittivity": "permittivity"}
    example: ClassVar[Mapping[str, Any]] = {"permittivity": 3.35}

    permittivity: Annotated[Number, Quantity("1", 1, 1e9, "relative permittivity")]
    conductivity: Annotated[Number, CONDUCTIVITY] = 0.0

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone, the same at all frequencies."""
        return level(self.permittivity, frequency=frequency)

    def debye(self) -> DebyeSum:
        """Return the sum without any relaxation."""
        return DebyeSum(self.permittivity, (), ())


class ConstantPhase(Material):
    """A dielectric with one loss angle at all frequencies: eps' falls as a power of the frequency.

    Notes
    -----
    eps*(f) = eps'(f0) (j f/f0)^(n-1)/cos((n-1) pi/2); n is the exponent of its admittance Y ~ (j w)^n, so a
    Cole admittance Y = G0 + Q (j w)^n is this material with a conductivity. The permittivity has no finite limit at low
    frequency: it is valid inside the band in which it was measured.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "bound_permittivity": "permittivity*(I*frequency/reference_frequency)**(exponent - 1)"
        "/cos((exponent - 1)*pi/2)"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "permittivity": 1560,
        "reference_frequency": 50.9,
        "exponent": 0.7545,
        "conductivity": 1e-6,
    }

    permittivity: Annotated[Number, Quantity("1", 1, 1e9, "eps' at the reference frequency")]
    reference_frequency: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "frequency at which eps' is given")]
    exponent: Annotated[Number, Quantity("1", 0.05, 0.9999, "exponent n of the admittance, 1 for no loss")]
    conductivity: Annotated[Number, CONDUCTIVITY]

    @NAN_PASSES
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone."""
        power = self.exponent - 1
        ratio = 1j * np.asarray(frequency, dtype=float) / self.reference_frequency
        total: Complex = self.permittivity * ratio**power / np.cos(power * np.pi / 2)
        return total
