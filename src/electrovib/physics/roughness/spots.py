"""Field and conduction at the spots where rough skin touches the plate."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.constants import eps0
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity


class ContactSpots(Model, family=True):
    """Field between skin and plate at the spots where they touch."""

    @property
    @abstractmethod
    def leak(self) -> float | None:
        """Conductivity of the medium between the faces of a spot [S/m]; None where there is no field."""

    @abstractmethod
    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return the field at a spot over that at an insulating spot.

        Parameters
        ----------
        frequency : float or ndarray
            Frequency [Hz], 0 or more; 0 for a constant voltage. NaN gives NaN.

        Returns
        -------
        share : complex or ndarray, same shape
            Complex ratio of the fields [1].
        """


class PullingSpots(ContactSpots):
    """Insulating spots, which attract with the whole field of a vanishing gap."""

    equation: ClassVar[Mapping[str, str]] = {"field_share": "1"}

    @property
    def leak(self) -> float:
        """0 S/m: the spots do not conduct."""
        return 0.0

    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return 1; NaN where the frequency is NaN."""
        return _shared(1.0, frequency)


class IdleSpots(ContactSpots):
    """Spots without a field between the faces, bridged for instance by sweat, which do not attract."""

    equation: ClassVar[Mapping[str, str]] = {"field_share": "0"}

    @property
    def leak(self) -> None:
        """None: there is no field between the faces that could drive a current."""

    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return 0; NaN where the frequency is NaN."""
        return _shared(0.0, frequency)


class LeakingSpots(ContactSpots):
    """Conducting spots: charge crosses to the surface of the plate, and the attraction of a held voltage decays.

    Notes
    -----
    A vanishing gap that leaks is a high-pass with the time constant eps0 rho, as long as the charge that has crossed
    does not spread along the surface of the insulator.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "field_share": "2*pi*I*frequency*eps0*resistivity/(1 + 2*pi*I*frequency*eps0*resistivity)"
    }
    example: ClassVar[Mapping[str, Any]] = {"resistivity": 1e8}

    resistivity: Annotated[
        Number, Quantity("ohm m", 1e-3, 1e18, "resistivity of the medium between the faces of a spot")
    ]

    @property
    def leak(self) -> float:
        """Conductivity [S/m], the reciprocal of the resistivity."""
        return 1 / self.resistivity

    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return the response of the high-pass [1]."""
        phase = 2j * np.pi * np.asarray(frequency, dtype=float) * eps0 * self.resistivity
        with np.errstate(invalid="ignore"):  # NaN gives NaN
            share: NDArray[np.complex128] = phase / (1 + phase)
        return share


def _shared(value: float, frequency: ArrayLike) -> NDArray[np.complex128]:
    given = np.asarray(frequency, dtype=float)
    return np.asarray(np.where(np.isnan(given), np.nan, value), dtype=complex)
