"""Non-ohmic conduction: laws of the current density in a layer."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


class Conduction(Model, family=True):
    """A non-ohmic conduction current, which rises with the field.

    Notes
    -----
    It flows in parallel with the conduction and polarisation of the material. J(0) = 0 and J does not decrease with E, so
    it only dissipates energy.
    """

    @abstractmethod
    def current_density(self, E: ArrayLike) -> NDArray[np.float64]:
        """Conduction current density, with the sign of the field.

        Parameters
        ----------
        E : array_like, any shape
            Field towards the finger [V/m]; NaN gives NaN.

        Returns
        -------
        current_density : ndarray
            Current density [A/m2], same shape.
        """

    @abstractmethod
    def slope(self, E: ArrayLike) -> NDArray[np.float64]:
        """Differential conductivity dJ/dE.

        Parameters
        ----------
        E : array_like, any shape
            Field towards the finger [V/m]; NaN gives NaN. Where the slope is discontinuous, that towards higher fields.

        Returns
        -------
        slope : ndarray
            Derivative of the current density by the field [S/m], same shape, >= 0.
        """

    @property
    def small_signal(self) -> float:
        """Conductivity for a vanishing sine around zero field [S/m]."""
        tiny = np.array([-1e-12, 1e-12])
        return float(np.mean(self.slope(tiny)))


class PolarityConduction(Conduction):
    """Conduction that depends on the polarity: a rectifying layer.

    Notes
    -----
    A positive field points towards the finger: the plate is positive relative to the finger. For a sine field of any
    amplitude without a mean the fundamental of the current follows from the mean of both conductivities; where no direct
    current can flow the layer charges, and the field has a mean.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "current_density": "conductivity_positive*Max(E, 0) + conductivity_negative*Min(E, 0)",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "conductivity_positive": 5.5e-6,
        "conductivity_negative": 1.8e-6,
    }

    conductivity_positive: Annotated[
        Number, Quantity("S/m", 0, 1e3, "conductivity for fields towards the finger")
    ]
    conductivity_negative: Annotated[
        Number, Quantity("S/m", 0, 1e3, "conductivity for fields towards the plate")
    ]

    def current_density(self, E: ArrayLike) -> NDArray[np.float64]:
        """Conduction current density [A/m2] at fields [V/m]."""
        return np.asarray(self.slope(E) * np.asarray(E, dtype=float))

    def slope(self, E: ArrayLike) -> NDArray[np.float64]:
        """Conductivity [S/m] of the polarity of each field [V/m]; at 0 that of positive fields."""
        field = np.asarray(E, dtype=float)
        chosen = np.where(field < 0, self.conductivity_negative, self.conductivity_positive)
        return np.where(np.isnan(field), np.nan, chosen)


class FieldConduction(Conduction):
    """Conduction that grows with the field in either polarity.

    Notes
    -----
    J = conductivity E (1 + (E/onset_field)^2), the departure from Ohm's law of lowest order that is independent of the
    polarity; at the onset field the conductivity J/E has doubled.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "current_density": "conductivity*E*(1 + (E/onset_field)**2)",
        "slope": "conductivity*(1 + 3*(E/onset_field)**2)",
    }
    example: ClassVar[Mapping[str, Any]] = {"conductivity": 1.8e-6, "onset_field": 5e4}

    conductivity: Annotated[Number, Quantity("S/m", 0, 1e3, "conductivity at a vanishing field")]
    onset_field: Annotated[Number, Quantity("V/m", 1, 1e12, "field at which the conductivity has doubled")]

    def current_density(self, E: ArrayLike) -> NDArray[np.float64]:
        """Conduction current density [A/m2] at fields [V/m]."""
        field = np.asarray(E, dtype=float)
        return np.asarray(self.conductivity * field * (1 + (field / self.onset_field) ** 2))

    def slope(self, E: ArrayLike) -> NDArray[np.float64]:
        """Differential conductivity [S/m] at fields [V/m]."""
        field = np.asarray(E, dtype=float)
        return np.asarray(self.conductivity * (1 + 3 * (field / self.onset_field) ** 2))
