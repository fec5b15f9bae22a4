"""Conduction that is not in proportion to the field: laws of current density in a layer."""

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
    """A conduction current that rises with the field, but not in proportion to it.

    Notes
    -----
    It flows beside the material's own conduction and polarisation. J(0) = 0 and J never falls with E, so a
    layer can only lose energy by it.
    """

    @abstractmethod
    def current_density(self, E: ArrayLike) -> NDArray[np.float64]:
        """Conduction current density, of the sign of the field.

        Parameters
        ----------
        E : array_like, any shape
            Field towards the finger [V/m]; NaN gives NaN.

        Returns
        -------
        ndarray
            A/m2, same shape.
        """

    @abstractmethod
    def slope(self, E: ArrayLike) -> NDArray[np.float64]:
        """Differential conductivity dJ/dE.

        Parameters
        ----------
        E : array_like, any shape
            Field towards the finger [V/m]; NaN gives NaN. At a kink the value for rising fields.

        Returns
        -------
        ndarray
            S/m, same shape, >= 0.
        """

    @property
    def small_signal(self) -> float:
        """Conductivity that a vanishing sine around zero field sees [S/m]."""
        tiny = np.array([-1e-12, 1e-12])
        return float(np.mean(self.slope(tiny)))


class PolarityConduction(Conduction):
    """Conduction that depends on the polarity: a rectifying layer.

    Notes
    -----
    Positive is a field towards the finger, that is a plate positive against the finger. For a sine of any
    size the fundamental of the current sees the mean of both conductivities.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "current_density": "(conductivity_positive + conductivity_negative)*E/2"
        " + (conductivity_positive - conductivity_negative)*Abs(E)/2"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "conductivity_positive": 5.5e-6,
        "conductivity_negative": 1.8e-6,
    }

    conductivity_positive: Annotated[Number, Quantity("S/m", 0, 1e3, "for fields towards the finger")]
    conductivity_negative: Annotated[Number, Quantity("S/m", 0, 1e3, "for fields towards the plate")]

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
    J = conductivity E (1 + (E/onset_field)^2), the lowest departure from Ohm's law that does not know the
    polarity; at the onset field the conductivity J/E has doubled.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "current_density": "conductivity*E*(1 + (E/onset_field)**2)",
        "slope": "conductivity*(1 + 3*(E/onset_field)**2)",
    }
    example: ClassVar[Mapping[str, Any]] = {"conductivity": 1.8e-6, "onset_field": 5e4}

    conductivity: Annotated[Number, Quantity("S/m", 0, 1e3, "conductivity of a vanishing field")]
    onset_field: Annotated[Number, Quantity("V/m", 1, 1e12, "field at which the conductivity has doubled")]

    def current_density(self, E: ArrayLike) -> NDArray[np.float64]:
        """Conduction current density [A/m2] at fields [V/m]."""
        field = np.asarray(E, dtype=float)
        return np.asarray(self.conductivity * field * (1 + (field / self.onset_field) ** 2))

    def slope(self, E: ArrayLike) -> NDArray[np.float64]:
        """Differential conductivity [S/m] at fields [V/m]."""
        field = np.asarray(E, dtype=float)
        return np.asarray(self.conductivity * (1 + 3 * (field / self.onset_field) ** 2))
