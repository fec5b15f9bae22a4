"""The family of dielectrics: relative permittivity over frequency, conduction declared apart from polarisation."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.model import Model
from electrovib.core.quantity import Quantity
from electrovib.physics.debye_sum import DebyeSum

CONDUCTIVITY = Quantity("S/m", 0, 1e3, "conductivity at zero frequency")
NAN_PASSES = np.errstate(invalid="ignore")
"""A NaN in a frequency is handed on; numpy would warn of it when it divides complex numbers."""


class Material(Model, family=True):
    """What fills a layer.

    Notes
    -----
    Time factor exp(+j w t), eps* = eps' - j eps''; eps*(w) = bound_permittivity(w) + conductivity/(j w eps0).
    Passive: Im eps* <= 0 at all frequencies. Every member declares its `conductivity` at zero frequency.
    """

    offered_by: ClassVar[tuple[str, ...]] = ("skins", "materials")

    @classmethod
    def from_offer(cls, offer: Any) -> Self:
        """Take the material out of a published skin, or as it is."""
        return cls.model_validate(getattr(offer, "material", offer))

    if TYPE_CHECKING:  # a parameter of most members; a mixture has it from its parts

        @property
        def conductivity(self) -> float:
            """Conductivity at zero frequency [S/m]."""

    @abstractmethod
    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone.

        Parameters
        ----------
        frequency : array_like
            Hz, above 0, any shape; NaN gives NaN.

        Returns
        -------
        ndarray of complex
            Same shape, without conduction.
        """

    @NAN_PASSES
    def complex_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity with conduction.

        Parameters
        ----------
        frequency : array_like
            Hz, above 0, any shape; NaN gives NaN.

        Returns
        -------
        ndarray of complex
            eps' - j eps'', 1, same shape.
        """
        angular = 2 * np.pi * np.asarray(frequency, dtype=float)
        total: Complex = self.bound_permittivity(frequency) + self.conductivity / (
            1j * angular * VACUUM_PERMITTIVITY
        )
        return total

    def debye(self) -> DebyeSum | None:
        """Give the finite sum of Debye terms this material is, or None if it is not one."""
        return None

    @property
    def pulling_share(self) -> float:
        """Share of the area on which the field of this layer pulls; a bridge that conducts does not."""
        return 1.0

    def conducting(self, conductivity: float) -> Self:
        """Give the same material with another conductivity at zero frequency [S/m]."""
        return self.model_copy(update={"conductivity": conductivity})

    @property
    def slowest_relaxation(self) -> float | None:
        """Longest relaxation time a reduction may use [s]; None for no limit."""
        return None

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency at which the material is known [Hz]; a formula is, everywhere."""
        return 0.0, math.inf

    def diagnostics(self, name: str) -> tuple[Diagnostic, ...]:
        """Say how far the values of this material can be believed, in the layer of this name."""
        del name
        return ()


def axis(frequency: ArrayLike) -> Complex:
    """Imaginary angular frequency.

    Parameters
    ----------
    frequency : array_like
        Hz, any shape; NaN gives NaN.

    Returns
    -------
    ndarray of complex
        j w [1/s], same shape.
    """
    result: Complex = 2j * np.pi * np.asarray(frequency, dtype=float)
    return result


def level(value: float, *, frequency: ArrayLike) -> Complex:
    """Give the same number at all frequencies.

    Parameters
    ----------
    value : float
        The number.
    frequency : array_like
        Hz, any shape.

    Returns
    -------
    ndarray of complex
        Same shape, NaN where the frequency is.
    """
    return np.full(np.shape(frequency), value, complex) + 0 * axis(frequency)
