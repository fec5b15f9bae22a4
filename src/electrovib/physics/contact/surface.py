"""Response of the surface topography of the skin to pressure: mean gap and real contact."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.physics.roughness import GaussianGaps


class Surface(Model, family=True):
    """The surface topography of the skin as an elastic layer between skin and plate.

    Notes
    -----
    The repulsion is a decreasing and convex function of the gap, which `solve.equilibrium` relies on. At gap 0 the
    surface topography is flattened, and the plate bears any further pressure.
    """

    never_negative: ClassVar[frozenset[str]] = frozenset({"gap", "pressure", "real_share"})

    is_rough: ClassVar[bool] = False
    """Whether there is a distribution of local gaps."""
    held: ClassVar[float] = 0.0
    """Share of the attraction of contact spots that the spots bear themselves, and that brings the faces no closer."""
    standing: ClassVar[str] = ""
    """Whether contacts that were solved correct a law of rough contact, in words."""

    @abstractmethod
    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the repulsion per area at a mean gap.

        Parameters
        ----------
        gap : float or ndarray
            Mean gap [m]; NaN gives NaN.

        Returns
        -------
        pressure : float or ndarray, same shape
            Repulsion per area [Pa], without the reaction of the plate at gap 0.
        """

    @abstractmethod
    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative of the repulsion with the gap.

        Parameters
        ----------
        gap : float or ndarray
            Mean gap [m]; NaN gives NaN.

        Returns
        -------
        slope : float or ndarray, same shape
            Derivative of the pressure by the gap [Pa/m], below 0 and increasing with the gap.
        """

    @abstractmethod
    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean gap under a pressure.

        Parameters
        ----------
        pressure : float or ndarray
            Pressure [Pa]; NaN gives NaN.

        Returns
        -------
        gap : float or ndarray, same shape
            Mean gap [m]; 0 where the pressure flattens the surface topography.
        """

    @abstractmethod
    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the area in contact.

        Parameters
        ----------
        pressure : float or ndarray
            Pressure of load and attraction [Pa]; NaN gives NaN.

        Returns
        -------
        share : float or ndarray, same shape
            Real over gross contact area [1], from 0 to 1.
        """

    def real_growth(self, pressure: float) -> float:
        """Return the derivative of the share in contact with pressure [1/Pa], at a pressure [Pa].

        Raises
        ------
        InputError
            If the surface has the same gap everywhere.
        """
        raise _one_gap(self, pressure)

    def diagnostics(self, share: ArrayLike) -> tuple[Diagnostic, ...]:
        """Return how large the error of a law of rough contact is at shares in contact [1]; of others nothing."""
        del share
        return ()

    def gaps(self, pressure: float) -> GaussianGaps:
        """Return the distribution of local gaps under a pressure [Pa].

        Raises
        ------
        InputError
            If the surface has the same gap everywhere, or is flattened too far for a Gaussian distribution.
        """
        raise _one_gap(self, pressure)


def _one_gap(surface: Surface, pressure: float) -> InputError:
    return InputError(
        f"{type(surface).__name__} has the same gap everywhere, also at {pressure:g} Pa, and no distribution of gaps to"
        " average over. Omit 'spots', or use a rough surface, for instance PerssonSurface"
    )


class LinearSpring(Surface):
    """A linear spring between skin and plate, with a rigid stop at gap 0.

    Notes
    -----
    The share in contact is 0 while the gap is open and 1 when it is closed.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "pressure": "stiffness*(free_gap - gap)",
        "slope": "-stiffness",
    }
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1e9, "free_gap": 1e-5}

    stiffness: Annotated[Number, Quantity("Pa/m", 1, 1e15, "pressure over the reduction of the gap")]
    free_gap: Annotated[Number, Quantity("m", 1e-10, 1e-1, "gap without any pressure")]

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the repulsion per area [Pa], negative beyond the free gap."""
        return self.stiffness * (self.free_gap - gap)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative of the repulsion with the gap [Pa/m], the same at every gap."""
        level: NDArray[np.float64] = np.where(np.isnan(gap), np.nan, -self.stiffness)
        return level

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gap under a pressure [m], 0 from the closing pressure on."""
        gap: NDArray[np.float64] = np.maximum(self.free_gap - np.asarray(pressure) / self.stiffness, 0.0)
        return gap

    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share in contact [1], 0 while the gap is open and 1 when it is closed."""
        given = np.asarray(pressure, dtype=float)
        closed = (given >= self.stiffness * self.free_gap).astype(float)
        share: NDArray[np.float64] = np.where(np.isnan(given), np.nan, closed)
        return share
