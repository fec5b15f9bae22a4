"""From normal force to lateral force."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray


class Load(Model):
    """How the finger is pressed on the plate."""

    example: ClassVar[Mapping[str, Any]] = {"normal_force": 0.5}

    normal_force: Annotated[Number, Quantity("N", 0, 1e3, "force with which the finger is pressed")]


class Friction(Model, family=True):
    """Friction of a sliding finger."""

    @abstractmethod
    def lateral_force(
        self, normal_force: NDArray[np.float64], electrostatic_force: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Friction force of the sliding finger.

        Parameters
        ----------
        normal_force, electrostatic_force : float or ndarray, one shape
            Load and attraction [N]; NaN gives NaN.

        Returns
        -------
        float or ndarray
            N, same shape.
        """


class Coulomb(Friction):
    """Friction in proportion to the whole normal force."""

    equation: ClassVar[Mapping[str, str]] = {
        "lateral_force": "coefficient*(normal_force + electrostatic_force)"
    }
    example: ClassVar[Mapping[str, Any]] = {"coefficient": 0.5}

    coefficient: Annotated[Number, Quantity("1", 0, 100, "coefficient of friction of the sliding finger")]

    def lateral_force(
        self, normal_force: NDArray[np.float64], electrostatic_force: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Friction force [N]."""
        return self.coefficient * (normal_force + electrostatic_force)
