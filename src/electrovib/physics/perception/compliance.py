"""Lateral compliance of the skin under the finger."""

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
"""Frequency at which fingertip skin turns from elastic to viscous [Hz], cited from memory, unverified: shown, never used."""


class SkinCompliance(Model, family=True):
    """Lateral displacement of the skin under the finger per lateral force."""

    @abstractmethod
    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the lateral displacement of the skin per force.

        Parameters
        ----------
        frequency : array_like
            Frequency [Hz], >= 0; NaN gives NaN.

        Returns
        -------
        compliance : ndarray of complex, same shape
            Displacement per force [m/N].
        """


class ElasticSkin(SkinCompliance):
    """Elastic skin: a spring at all frequencies."""

    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/stiffness"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the lateral displacement per force [m/N] at frequencies [Hz]."""
        places = np.asarray(frequency, dtype=float)
        result: NDArray[np.complex128] = 1 / self.stiffness + 0j * places
        return result


class ElasticViscousSkin(SkinCompliance):
    """Viscoelastic skin: a spring at low and a damper at high frequencies.

    Notes
    -----
    A spring and a damper in parallel, corner = stiffness/(2 pi damping). A corner near 100 Hz and a stiffness near
    1 N/mm, measured on fingertips, are cited from memory, unverified, and therefore not defaults.
    """

    status: ClassVar[str] = "unverified"
    reference: ClassVar[str] = (
        "elastic below some 100 Hz, viscous above: Wiertlewski and Hayward 2012, cited from memory, unverified"
    )
    equation: ClassVar[Mapping[str, str]] = {"compliance": "1/(stiffness*(1 + I*frequency/corner))"}
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1000.0, "corner": 100.0}

    stiffness: Annotated[Number, Quantity("N/m", 1, 1e6, "lateral stiffness of the fingertip")]
    corner: Annotated[
        Number, Quantity("Hz", 0.1, 1e5, "frequency above which the damper dominates the spring")
    ]

    def compliance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the lateral displacement per force [m/N] at frequencies [Hz]."""
        ratio = np.asarray(frequency, dtype=float) / self.corner
        in_phase = 1 / (self.stiffness * (1 + ratio**2))
        result: NDArray[np.complex128] = in_phase - 1j * ratio * in_phase
        return result
