"""How far a force on it moves the skin."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final

import numpy as np

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


UNVERIFIED_CORNER: Final = 100.0
"""Where the skin of a fingertip turns from elastic to viscous: recalled, never a default, only shown beside [Hz]."""


class SkinCompliance(Model, family=True):
    """How far the skin under the finger moves for a lateral force on it."""

    @abstractmethod
    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Lateral displacement of the skin per force.

        Parameters
        ----------
        frequency : array_like
            Hz, >= 0; NaN gives NaN.

        Returns
        -------
        ndarray
            m/N, complex, same shape.
        """


class ElasticSkin(SkinCompliance):
    """Skin that follows the force as a spring, at any frequency."""

    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/stiffness"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Lateral displacement per force [m/N] at frequencies in Hz."""
        places = np.asarray(frequency, dtype=float)
        result: NDArray[np.complex128] = 1 / self.stiffness + 0j * places
        return result


class ElasticViscousSkin(SkinCompliance):
    """Skin that follows the force as a spring at low and as a damper at high frequencies.

    Notes
    -----
    A spring and a damper side by side, corner = stiffness/(2 pi damping). A corner near 100 Hz and a stiffness
    near 1 N/mm are recalled of measurements on fingertips whose paper was not read: they are no defaults.
    """

    status: ClassVar[str] = "unverified"
    reference: ClassVar[str] = (
        "elastic below some 100 Hz, viscous above: Wiertlewski and Hayward 2012, not read"
    )
    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/(stiffness*(1 + I*frequency/corner))"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0, "corner": 100.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]
    corner: Annotated[Number, Quantity("Hz", 0.1, 1e5, "where the damper takes over from the spring")]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Lateral displacement per force [m/N] at frequencies in Hz."""
        ratio = np.asarray(frequency, dtype=float) / self.corner
        in_phase = 1 / (self.stiffness * (1 + ratio**2))
        result: NDArray[np.complex128] = in_phase - 1j * ratio * in_phase
        return result
