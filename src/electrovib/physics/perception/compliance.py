"""Lateral compliance of the skin under the finger."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final

import numpy as np

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity
from electrovib.physics.body_current import SECOND_HAND
from electrovib.physics.finger import GrowthWithSpeed
from electrovib.physics.perception.channels import ISRAR

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


@dataclass(frozen=True, kw_only=True)
class PublishedCompliance:
    """A lateral skin from publications, an assumption where the finger at hand has not been measured.

    `conditions`, `source` and `status` say what was measured, by whom, and how it was read.
    """

    skin: SkinCompliance
    conditions: str
    source: str
    status: str


_STIFFNESS: Final = GrowthWithSpeed(known_at=0.02).added_stiffness(0.1)
_PEN, _PEN_CONTACT, _FINGER_CONTACT = 15.8, 400e-6, 1e-4
"""Largest impedance of the hand on a pen [N s/m], its smallest contact, and that of a finger [m2]."""
_DAMPING: Final = _PEN * _FINGER_CONTACT / _PEN_CONTACT
COMPLIANCES: Final = (
    PublishedCompliance(
        skin=ElasticSkin(stiffness=_STIFFNESS),
        conditions=f"softest: {format_quantity(_STIFFNESS, 'N/m', digits=3)}, the rise of the stiffness of the fingertip from 20"
        " to 100 mm/s; that at 20 mm/s, which was not read, is left out",
        source="arXiv:2505.11162, abstract",
        status="derived",
    ),
    PublishedCompliance(
        skin=ElasticViscousSkin(stiffness=_STIFFNESS, corner=_STIFFNESS / (2 * math.pi * _DAMPING)),
        conditions=f"stiffest: with a damping of {format_quantity(_DAMPING, 'N s/m', digits=3)}, that of a hand on a pen below"
        " 40 Hz (-36 dB re 1 N s/mm on 400 mm2) for 1 cm2",
        source=ISRAR,
        status=SECOND_HAND,
    ),
)
"""Softest and stiffest lateral skin that publications give: the ends of what is assumed without a measurement."""
