"""Which area the finger touches: the outline of the contact, and what of it really touches."""

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
_CLOSING = Field(description="lets the gap follow load and attraction; it stays as it is without")


class Closing(Model):
    """A gap that follows load and attraction: the layer ``gap`` closes against the surface topography of the skin.

    Notes
    -----
    damping g' = repulsion(g) - load pressure - attraction: what is squeezed out resists, no mass. It begins at
    rest where the surface topography carries the load of time 0; with the thickness of the layer where a surface
    topography that reaches endlessly far carries none.
    """

    example: ClassVar[Mapping[str, Any]] = {"damping": 1e6}

    damping: Annotated[
        Number, Quantity("Pa s/m", 1e-3, 1e15, "pressure over the speed with which the gap closes")
    ]


class Contact(Model, family=True):
    """From load to contact.

    Notes
    -----
    Two areas that are not each other. The gross area is that of the outline and what forces per area are
    multiplied with; the real area is where the surface topography of the skin touches the plate, and needs a `surface`. Both
    are those under load and attraction together (`solve.equilibrium.pressed`). A ridged print touches with a third
    less than flat skin (Warman and Ennos 2009); no force law here knows of ridges, so no parameter does.
    """

    if TYPE_CHECKING:  # declared by every member, beside its own parameters

        @property
        def length(self) -> float | None:
            """Length along the sliding direction [m], if given."""

        @property
        def surface(self) -> Surface | None:
            """How the surface topography answers a pressure, if given."""

        @property
        def closing(self) -> Closing | None:
            """How the gap follows the forces, if it does."""

    @abstractmethod
    def gross_area(self, normal_force: float | None = None) -> float:
        """Area of the outline of the contact.

        Parameters
        ----------
        normal_force : float, optional
            With which skin and plate are pressed together [N], 0 or more.

        Returns
        -------
        float
            m2; without a force the area that the model was given.
        """

    @abstractmethod
    def mean_pressure(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force over gross area.

        Parameters
        ----------
        normal_force : float or ndarray
            With which skin and plate are pressed together [N], 0 or more; NaN gives NaN.

        Returns
        -------
        float or ndarray
            Pa, same shape.
        """

    def outline(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Area of the outline under many forces.

        Parameters
        ----------
        normal_force : float or ndarray
            With which skin and plate are pressed together [N], 0 or more; NaN gives NaN.

        Returns
        -------
        float or ndarray
            m2, same shape; 0 without a force where the area needs one.
        """
        force = np.asarray(normal_force, dtype=float)
        pressure = np.asarray(self.mean_pressure(force))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.where(force == 0, self.gross_area(0.0), force / pressure))

    def sliding_length(self, normal_force: float | None = None) -> float:
        """Length of the contact along the sliding direction.

        Parameters
        ----------
        normal_force : float, optional
            As for `gross_area` [N].

        Returns
        -------
        float
            `length` [m] if given, else the root of the gross area.
        """
        return math.sqrt(self.gross_area(normal_force)) if self.length is None else self.length

    def real_area(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Area where the surface topography of the skin touches the plate.

        Parameters
        ----------
        normal_force : float or ndarray
            With which skin and plate are pressed together [N], load plus attraction, 0 or more; NaN gives NaN.

        Returns
        -------
        float or ndarray
            m2, same shape.

        Raises
        ------
        InputError
            Without a `surface`.
        """
        if self.surface is None:
            raise InputError(
                "contact.surface is not given: real contact follows from the surface topography of the skin, for instance"
                ' contact.surface = { model = "PerssonSurface", ... }; the gross area needs none'
            )
        force = np.asarray(normal_force, dtype=float)
        pressure = np.asarray(self.mean_pressure(force))
        area: NDArray[np.float64] = self.outline(force) * self.surface.real_share(pressure)
        return area


class FixedArea(Contact):
    """A contact area that does not depend on the load."""

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
        """Area of the outline of the contact [m2], whatever the force."""
        del normal_force
        return self.area

    def outline(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Area of the outline [m2], the same under all forces."""
        force = np.asarray(normal_force, dtype=float)
        return np.asarray(np.where(np.isnan(force), np.nan, self.area))

    def mean_pressure(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force over gross area [Pa]."""
        return normal_force / self.area


class GrowingArea(Contact):
    """A contact area that grows as a power of the force with which skin and plate are pressed together.

    Notes
    -----
    That force is load plus attraction, and more area attracts more: both are found together. With exponent 1 an
    attraction above at_force/area lets the area grow without bound, which is refused.
    The exponent of a finger was not found in what could be read, so it has to be given: 2/3 is that of a
    smooth elastic sphere. Without a force the area is that at the reference force.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "mean_pressure": "at_force/area*(sign(normal_force)*(Abs(normal_force)/at_force)**(1 - exponent))"
    }
    example: ClassVar[Mapping[str, Any]] = {
        "area": 1e-4,
        "at_force": 0.5,
        "exponent": 2 / 3,
        "surface": {"model": "LinearSpring"} | dict(LinearSpring.example),
    }

    area: Annotated[Number, Quantity("m2", 1e-9, 1, "gross contact area at the reference force")]
    at_force: Annotated[Number, Quantity("N", 1e-6, 1e3, "reference force")]
    exponent: Annotated[Number, Quantity("1", 0, 1, "power of the force with which the area grows")]
    length: Annotated[Number | None, _LENGTH] = None
    surface: Surface | None = None
    closing: Annotated[Closing | None, _CLOSING] = None

    def gross_area(self, normal_force: float | None = None) -> float:
        """Area of the outline of the contact: area (force/at_force)^exponent [m2]."""
        if normal_force is None:
            return self.area
        return self.area * math.pow(normal_force / self.at_force, self.exponent)

    def mean_pressure(self, normal_force: NDArray[np.float64]) -> NDArray[np.float64]:
        """Force over gross area [Pa]: it grows with what of the power the area leaves."""
        force = np.asarray(normal_force, dtype=float)
        share = np.sign(force) * (np.abs(force) / self.at_force) ** (1 - self.exponent)
        pressure: NDArray[np.float64] = self.at_force / self.area * share
        return pressure
