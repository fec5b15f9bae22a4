"""The loss in a measured table of a dielectric: four quantities in which a column may give it."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from electrovib.core.column_unit import column_unit
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.model import Model

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    Real = NDArray[np.float64]


class LossColumn(Model, family=True):
    """The column of a table that gives the loss, and its quantity.

    Notes
    -----
    It is the whole loss, conduction included. Rows with NaN are refused by the table.
    """

    noun: ClassVar[str] = "loss"
    needs: ClassVar[str] = "0 or more"

    column: str | int
    unit: str

    def allowed(self, values: Real) -> NDArray[np.bool_]:
        """Mark the values [unit of the column] that a passive dielectric may have."""
        passive: NDArray[np.bool_] = values >= 0
        return passive

    @abstractmethod
    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Convert the column to the loss factor eps''.

        Parameters
        ----------
        frequency : ndarray, shape (N,)
            Frequency [Hz].
        permittivity : ndarray, shape (N,)
            Relative permittivity eps', dimensionless.
        values : ndarray, shape (N,)
            Values of the column, in SI units.

        Returns
        -------
        loss_factor : ndarray, shape (N,)
            Relative loss factor eps'', dimensionless.
        """


class LossFactor(LossColumn):
    """The column is eps'' itself."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "values"}

    noun: ClassVar[str] = "loss factor"

    column: Annotated[str | int, Field(description="name or number of the column")] = "loss"
    unit: Annotated[str, column_unit("1"), Field(description="unit of the column")] = "1"

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return the column as it is."""
        del frequency, permittivity
        return values


class LossTangent(LossColumn):
    """The column is tan delta = eps''/eps'."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "permittivity*values"}

    noun: ClassVar[str] = "loss tangent"

    column: Annotated[str | int, Field(description="name or number of the column")] = "loss_tangent"
    unit: Annotated[str, column_unit("1"), Field(description="unit of the column")] = "1"

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return eps' tan delta."""
        del frequency
        return permittivity * values


class Conductivity(LossColumn):
    """The column is the whole conductivity, w eps0 eps''."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "values/(2*pi*frequency*eps0)"}

    noun: ClassVar[str] = "conductivity"

    column: Annotated[str | int, Field(description="name or number of the column")] = "conductivity"
    unit: Annotated[str, column_unit("S/m"), Field(description="unit of the column")] = "S/m"

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return sigma/(w eps0)."""
        del permittivity
        return values / (2 * np.pi * frequency * VACUUM_PERMITTIVITY)


class Resistivity(LossColumn):
    """The column is the resistivity, 1/(w eps0 eps'')."""

    equation: ClassVar[Mapping[str, str]] = {"loss_factor": "1/(2*pi*frequency*eps0*values)"}

    noun: ClassVar[str] = "resistivity"
    needs: ClassVar[str] = "above 0"

    column: Annotated[str | int, Field(description="name or number of the column")] = "resistivity"
    unit: Annotated[str, column_unit("ohm m"), Field(description="unit of the column")] = "ohm m"

    def allowed(self, values: Real) -> NDArray[np.bool_]:
        """Mark the values [ohm m] that a passive dielectric may have; 0 would be an infinite loss."""
        passive: NDArray[np.bool_] = values > 0
        return passive

    def loss_factor(self, frequency: Real, permittivity: Real, values: Real) -> Real:
        """Return 1/(w eps0 rho)."""
        del permittivity
        return 1 / (2 * np.pi * frequency * VACUUM_PERMITTIVITY * values)
