"""Gross and real contact area of the finger on the plate."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.contact.surface import LinearSpring, Surface

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

_LENGTH = Quantity("m", 1e-6, 1, "length of the contact along the sliding direction")
_CLOSING = Field(description="lets the gap follow load and attraction; without it the gap is constant")


class Closing(Model):
    """A gap that follows load and attraction: the layer ``gap`` closes against the surface topography of the skin.

    Notes
    -----
    `repulsion` is the pressure of the surface topography at the gap, `load_pressure` the load over the contact area and
    `attraction` the Maxwell stress in the gap [Pa]. The medium that is squeezed out resists; inertia is neglected. The
    initial gap is the one at which the surface topography bears the load of time 0, or the thickness of the layer where
    that gap is infinite, as it is without load for a repulsion without a finite range.
    """

    equation: ClassVar[Mapping[str, str]] = {"gap'": "(repulsion - load_pressure - attraction)/damping"}
    example: ClassVar[Mapping[str, Any]] = {"damping": 1e6}

    damping: Annotated[
        Number, Quantity("Pa s/m", 1e-3, 1e15, "pressure over the speed with which the gap closes")
    ]


class Contact(Model, family=True):
    """Contact area of the finger under load and attraction.

    Notes
    -----
    The gross area is the area of the outline, with which forces per area are multiplied; a member whose gross area is the
    same under every force declares `grows` = False. The real area is where the surface topography of the skin touches the
    plate, and needs a `surface`. Both are taken under load and attraction together (`solve.equilibrium.pressed`). A ridged
    fingerprint has a third less contact area than flat skin (Warman and Ennos 2009); ridges are not modelled.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset(
        {"gross_area", "mean_pressure", "outline", "sliding_length", "real_area"}
    )

    grows: ClassVar[bool] = True

    if TYPE_CHECKING:  # declared by every member, beside its own parameters

        @property
        def length(self) -> float | None:
            """Length along the sliding direction [m], if given."""

        @property
        def surface(self) -> Surface | None:
            """Response of the surface topography to pressure, if given."""

        @property
        def closing(self) -> Closing | None:
            """Dynamics of a gap that follows the forces; None for a constant gap."""

    @abstractmethod
    def gross_area(self, normal_force: float | None = None) -> float:
        """Return the area of the outline of the contact.

        Parameters
        ----------
        normal_force : float, optional
            Force with which skin and plate are pressed together [N], 0 or more.

        Returns
        -------
        area : float
            Gross contact area [m2]; without a force the area that is a parameter of the model.
        """

    @abstractmethod
    def mean_pressure(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the force over the gross area.

        Parameters
        ----------
        normal_force : float or ndarray
            Force with which skin and plate are pressed together [N], 0 or more; NaN gives NaN.

        Returns
        -------
        pressure : float or ndarray, same shape
            Mean pressure [Pa].
        """

    def outline(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the area of the outline under many forces.

        Parameters
        ----------
        normal_force : float or ndarray
            Force with which skin and plate are pressed together [N], 0 or more; NaN gives NaN.

        Returns
        -------
        area : float or ndarray, same shape
            Gross contact area [m2]; 0 at force 0 where the area grows with the force.
        """
        force = np.asarray(normal_force, dtype=float)
        pressure = np.asarray(self.mean_pressure(force))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.where(force == 0, self.gross_area(0.0), force / pressure))

    def sliding_length(self, normal_force: float | None = None) -> float:
        """Return the length of the contact along the sliding direction.

        Parameters
        ----------
        normal_force : float, optional
            As for `gross_area` [N].

        Returns
        -------
        length : float
            `length` [m] if given, else the square root of the gross area.
        """
        return math.sqrt(self.gross_area(normal_force)) if self.length is None else self.length

    def real_area(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the area where the surface topography of the skin touches the plate.

        Parameters
        ----------
        normal_force : float or ndarray
            Force with which skin and plate are pressed together [N], load plus attraction, 0 or more; NaN gives NaN.

        Returns
        -------
        area : float or ndarray, same shape
            Real contact area [m2].

        Raises
        ------
        InputError
            Without a `surface`.
        """
        if self.surface is None:
            raise InputError(
                "contact.surface is not given, but the real contact area follows from it; give for instance"
                ' contact.surface = { model = "PerssonSurface", ... }'
            )
        force = np.asarray(normal_force, dtype=float)
        pressure = np.asarray(self.mean_pressure(force))
        area: NDArray[np.float64] = self.outline(force) * self.surface.real_share(pressure)
        return area


class FixedArea(Contact):
    """A contact area that does not depend on the load."""

    grows: ClassVar[bool] = False
    equation: ClassVar[Mapping[str, str]] = {"mean_pressure": "normal_force/area"}
    example: ClassVar[Mapping[str, Any]] = {
        "area": 1e-4,
        "surface": {"model": "LinearSpring"} | dict(LinearSpring.example),
    }

    area: Annotated[Number, Quantity("m2", 1e-9, 1, "gross contact area")]
    length: Annotated[Number | None, _LENGTH] = None
    surface: Surface | None = None
    closing: Annotated[Closing | None, _CLOSING] = None

    def gross_area(self, normal_force: float | None = None) -> float:
        """Return the area of the outline of the contact [m2], which does not depend on the force."""
        del normal_force
        return self.area

    def outline(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the area of the outline [m2], the same under all forces."""
        force = np.asarray(normal_force, dtype=float)
        return np.asarray(np.where(np.isnan(force), np.nan, self.area))

    def mean_pressure(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the force over the gross area [Pa]."""
        return normal_force / self.area


class GrowingArea(Contact):
    """A contact area that grows as a power of the force with which skin and plate are pressed together.

    Notes
    -----
    The force is load plus attraction, and the attraction grows with the area: both are solved together. With exponent 1
    an attraction per area above at_force/area lets the area grow without bound, which is refused. No source for the
    exponent of a finger is known, so it has to be given; 2/3 is that of a smooth elastic sphere. Without a force the
    area is that at the reference force.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "mean_pressure": "at_force/area*sign(normal_force)*(Abs(normal_force)/at_force)**(1 - exponent)"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "area": 1e-4,
        "at_force": 0.5,
        "exponent": 2 / 3,
        "surface": {"model": "LinearSpring"} | dict(LinearSpring.example),
    }

    area: Annotated[Number, Quantity("m2", 1e-9, 1, "gross contact area at the reference force")]
    at_force: Annotated[Number, Quantity("N", 1e-6, 1e3, "force under which the contact has the area given")]
    exponent: Annotated[Number, Quantity("1", 0, 1, "power of the force with which the area grows")]
    length: Annotated[Number | None, _LENGTH] = None
    surface: Surface | None = None
    closing: Annotated[Closing | None, _CLOSING] = None

    def gross_area(self, normal_force: float | None = None) -> float:
        """Return the area of the outline of the contact, area (force/at_force)^exponent [m2]."""
        if normal_force is None:
            return self.area
        return self.area * math.pow(normal_force / self.at_force, self.exponent)

    def mean_pressure(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the force over the gross area [Pa], which grows with the power 1 - exponent of the force."""
        force = np.asarray(normal_force, dtype=float)
        share = np.sign(force) * (np.abs(force) / self.at_force) ** (1 - self.exponent)
        pressure: NDArray[np.float64] = self.at_force / self.area * share
        return pressure
