"""What the surface topography of the skin does under pressure: the gap it keeps, and how much of it touches."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.physics.roughness import GaussianGaps


class Surface(Model, family=True):
    """The surface topography of the skin as a cushion between skin and plate.

    Notes
    -----
    The repulsion falls with the gap, ever less (decreasing and convex): what `solve.equilibrium` rests on.
    At gap 0 the surface topography is flat and the skin stands on the plate, which bears any more pressure.
    """

    @abstractmethod
    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Repulsion per area at a mean gap.

        Parameters
        ----------
        gap : float or ndarray
            m; NaN gives NaN.

        Returns
        -------
        float or ndarray
            Pa, same shape; without the stop at gap 0.
        """

    @abstractmethod
    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rate at which the repulsion changes with the gap.

        Parameters
        ----------
        gap : float or ndarray
            m; NaN gives NaN.

        Returns
        -------
        float or ndarray
            Pa/m, below 0, rising with the gap, same shape.
        """

    @abstractmethod
    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean gap under a pressure.

        Parameters
        ----------
        pressure : float or ndarray
            Pa; NaN gives NaN.

        Returns
        -------
        float or ndarray
            m, same shape; 0 where the pressure flattens the surface topography.
        """

    @abstractmethod
    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the area that touches.

        Parameters
        ----------
        pressure : float or ndarray
            Pa, load plus attraction; NaN gives NaN.

        Returns
        -------
        float or ndarray
            A_real/A0, from 0 to 1, same shape.
        """

    def real_growth(self, pressure: float) -> float:
        """Rate at which the touching share grows with pressure [1/Pa], at a pressure in Pa.

        Raises
        ------
        InputError
            If the surface has one gap everywhere.
        """
        raise _no_relief(self, pressure)

    def gaps(self, pressure: float) -> GaussianGaps:
        """Gaps from place to place under a pressure [Pa].

        Raises
        ------
        InputError
            If the surface has one gap everywhere, or is flattened too far for a Gaussian of them.
        """
        raise _no_relief(self, pressure)


def _no_relief(surface: Surface, pressure: float) -> InputError:
    return InputError(
        f"{type(surface).__name__} has one gap everywhere, also at {pressure:g} Pa: it has no distribution of gaps to"
        " average over. Leave 'spots' out, or use a rough surface, for instance PerssonSurface"
    )


class LinearSpring(Surface):
    """A spring that keeps the skin off the plate, with the plate as its stop.

    Notes
    -----
    Nothing touches before the gap is closed, then all of it.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "pressure": "stiffness*(free_gap - gap)",
        "slope": "-stiffness",
    }
    example: ClassVar[Mapping[str, Any]] = {"stiffness": 1e9, "free_gap": 1e-5}

    stiffness: Annotated[Number, Quantity("Pa/m", 1, 1e15, "pressure for each length of closing")]
    free_gap: Annotated[Number, Quantity("m", 1e-10, 1e-1, "gap without any pressure")]

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Repulsion per area [Pa]; beyond the free gap the spring draws, below 0."""
        return self.stiffness * (self.free_gap - gap)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Change of the repulsion with the gap [Pa/m], the same at every gap."""
        level: NDArray[np.float64] = np.where(np.isnan(gap), np.nan, -self.stiffness)
        return level

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gap under a pressure [m], 0 from the closing pressure on."""
        gap: NDArray[np.float64] = np.maximum(self.free_gap - np.asarray(pressure) / self.stiffness, 0.0)
        return gap

    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share that touches: 0 before the gap is closed, then 1."""
        given = np.asarray(pressure, dtype=float)
        closed = (given >= self.stiffness * self.free_gap).astype(float)
        share: NDArray[np.float64] = np.where(np.isnan(given), np.nan, closed)
        return share


def pull_in_voltage(
    *, stiffness: float, free_gap: float, electrical_thickness: float, pressure: float = 0.0
) -> float | None:
    """Voltage at which a skin on a linear spring snaps to the plate.

    Parameters
    ----------
    stiffness : float
        Of the spring, per area [Pa/m].
    free_gap : float
        Gap without pressure [m].
    electrical_thickness : float
        K, the sum of T/eps over the layers that block [m], 0 or more.
    pressure : float
        Of the load [Pa]: it leaves a free gap of free_gap - pressure/stiffness.

    Returns
    -------
    float or None
        V; None where the gap closes without a snap.

    Notes
    -----
    V^2 = 8 k (K + g0)^3/(27 eps0), at g = (2 g0 - K)/3: only if g0 > K/2, else that place is behind the plate.
    """
    left = free_gap - pressure / stiffness
    if not left > electrical_thickness / 2:
        return None
    return math.sqrt(8 * stiffness * (electrical_thickness + left) ** 3 / (27 * eps0))
