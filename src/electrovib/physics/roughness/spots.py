"""What pulls where rough skin touches the plate."""

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
    """What the voltage does where skin and plate touch."""

    @property
    @abstractmethod
    def leak(self) -> float | None:
        """Conductivity of what is between the faces of a spot [S/m]; None where there is no field at all."""

    @abstractmethod
    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Field at a spot over that at one that insulates.

        Parameters
        ----------
        frequency : float or ndarray
            Hz, 0 or more; 0 is a voltage held for ever. NaN gives NaN.

        Returns
        -------
        complex or ndarray
            1, same shape.
        """


class PullingSpots(ContactSpots):
    """Spots that insulate: the whole field of a vanishing gap pulls."""

    equation: ClassVar[Mapping[str, str]] = {"field_share": "1"}

    @property
    def leak(self) -> float:
        """Conduct nothing [S/m]."""
        return 0.0

    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Give 1, NaN where the frequency is NaN."""
        return _shared(1.0, frequency)


class IdleSpots(ContactSpots):
    """Spots without a field between the faces, bridged for instance by sweat: they touch and do not pull."""

    @property
    def leak(self) -> None:
        """Give nothing: there is no field to conduct in."""

    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Give 0, NaN where the frequency is NaN."""
        return _shared(0.0, frequency)


class LeakingSpots(ContactSpots):
    """Spots that conduct: charge crosses to the plate's surface, so a held voltage ends up not pulling there.

    Notes
    -----
    A gap that vanishes and leaks is a high pass of time constant eps0 rho, while the charge that has crossed
    does not spread along the surface of the insulator.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "field_share": "2*pi*I*frequency*eps0*resistivity/(1 + 2*pi*I*frequency*eps0*resistivity)"
    }
    example: ClassVar[Mapping[str, Any]] = {"resistivity": 1e8}

    resistivity: Annotated[
        Number, Quantity("ohm m", 1e-3, 1e18, "resistivity of what is between the faces of a spot")
    ]

    @property
    def leak(self) -> float:
        """Conductivity [S/m]."""
        return 1 / self.resistivity

    def field_share(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Give the high pass."""
        phase = 2j * np.pi * np.asarray(frequency, dtype=float) * eps0 * self.resistivity
        with np.errstate(invalid="ignore"):  # a NaN is handed on
            share: NDArray[np.complex128] = phase / (1 + phase)
        return share


def _shared(value: float, frequency: ArrayLike) -> NDArray[np.complex128]:
    given = np.asarray(frequency, dtype=float)
    return np.asarray(np.where(np.isnan(given), np.nan, value), dtype=complex)
