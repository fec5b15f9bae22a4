"""What the relief of the skin does under pressure: the gap it keeps, and how much of it touches."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.roughness import GaussianGaps, contact_fraction, contact_growth

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

MOST_TOUCHING = 0.5
"""Share of real contact up to which a Gaussian of gaps with a mean not below 0 stands for the relief."""
MODULUS = Quantity("Pa", 1e2, 1e12, "effective modulus E/(1 - nu^2) of the skin at the plate")
SLOPE = Quantity("1", 1e-6, 1e3, "root mean square slope of the relief")


class Surface(Model, family=True):
    """The relief of the skin as a cushion between skin and plate.

    Notes
    -----
    The repulsion falls with the gap, ever less (decreasing and convex): what `solve.equilibrium` rests on.
    At gap 0 the relief is flat and the skin stands on the plate, which bears any more pressure.
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
            m, same shape; 0 where the pressure flattens the relief.
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
        """Rate at which the touching share grows with pressure [1/Pa], at a pressure in Pa."""
        raise _no_relief(self, pressure)

    def gaps(self, pressure: float) -> GaussianGaps:
        """Gaps from place to place under a pressure [Pa]."""
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


class PerssonSurface(Surface):
    """A rough elastic skin after Persson: repulsion falls exponentially with the mean gap.

    Notes
    -----
    p = pressure_factor E* exp(-gap/(decay_factor rms_gap)) and A_real/A0 = erf(sqrt(2) p/(E* h')). The forms
    are recalled, not read; so are the two factors (for the pressure of the order of the wave number of the
    longest roughness times its rms height, for the decay somewhat below 1), which therefore have no default.
    Valid for small pressures, mean gaps of some rms gaps; towards gap 0 the exponential has no ground.
    """

    reference: ClassVar[str] = "doi:10.1063/1.5024038"
    status: ClassVar[str] = "recalled"
    equation: ClassVar[Mapping[str, str]] = {
        "pressure": "pressure_factor*modulus*exp(-gap/(decay_factor*rms_gap))",
        "slope": "-pressure_factor*modulus*exp(-gap/(decay_factor*rms_gap))/(decay_factor*rms_gap)",
        "real_share": "erf(sqrt(2)*pressure/(modulus*rms_slope))",
    }
    example: ClassVar[Mapping[str, Any]] = {
        "modulus": 2e7,
        "rms_slope": 1.0,
        "rms_gap": 2e-5,
        "pressure_factor": 0.5,
        "decay_factor": 0.5,
    }

    modulus: Annotated[Number, MODULUS]
    rms_slope: Annotated[Number, SLOPE]
    rms_gap: Annotated[Number, Quantity("m", 1e-10, 1e-2, "root mean square height of the relief")]
    pressure_factor: Annotated[Number, Quantity("1", 1e-6, 1e3, "repulsion at gap 0 over the modulus")]
    decay_factor: Annotated[Number, Quantity("1", 0.01, 10, "gap of an e-fold of repulsion over rms height")]

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Repulsion per area [Pa]."""
        flat, decay = self.pressure_factor * self.modulus, self.decay_factor * self.rms_gap
        return exponential_pressure(gap, flat=flat, decay=decay)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Change of the repulsion with the gap [Pa/m]."""
        return -self.pressure(gap) / (self.decay_factor * self.rms_gap)

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean gap under a pressure [m]."""
        flat, decay = self.pressure_factor * self.modulus, self.decay_factor * self.rms_gap
        return exponential_gap(pressure, flat=flat, decay=decay)

    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share that touches."""
        return contact_fraction(pressure, modulus=self.modulus, slope=self.rms_slope)

    def real_growth(self, pressure: float) -> float:
        """Growth of the touching share with pressure [1/Pa]."""
        return contact_growth(pressure, modulus=self.modulus, slope=self.rms_slope)

    def gaps(self, pressure: float) -> GaussianGaps:
        """Gaps under a pressure: those with its mean gap and its real contact."""
        at = np.asarray(pressure)
        return gaussian_gaps(mean_gap=float(self.gap(at)), touching=float(self.real_share(at)))


def exponential_pressure(gap: ArrayLike, *, flat: float, decay: float) -> NDArray[np.float64]:
    """Repulsion that falls exponentially with the gap.

    Parameters
    ----------
    gap : float or array_like
        m.
    flat : float
        Pressure at gap 0 [Pa].
    decay : float
        Gap over which it falls e-fold [m].

    Returns
    -------
    float or ndarray
        Pa, same shape.
    """
    pressure: NDArray[np.float64] = flat * np.exp(-np.asarray(gap, dtype=float) / decay)
    return pressure


def exponential_gap(pressure: ArrayLike, *, flat: float, decay: float) -> NDArray[np.float64]:
    """Gap at which an exponential repulsion bears a pressure.

    Parameters
    ----------
    pressure : float or array_like
        Pa; 0 or less is borne at no gap, an infinite one.
    flat : float
        Pressure at gap 0 [Pa].
    decay : float
        Gap over which the repulsion falls e-fold [m].

    Returns
    -------
    float or ndarray
        m, same shape; 0 from the flat pressure on.
    """
    with np.errstate(divide="ignore"):
        ratio = np.log(flat / np.maximum(np.asarray(pressure, dtype=float), 0.0))
    gap: NDArray[np.float64] = np.maximum(decay * ratio, 0.0)
    return gap


def gaussian_gaps(*, mean_gap: float, touching: float) -> GaussianGaps:
    """Gaps of a relief whose mean gap and whose real contact are known.

    Parameters
    ----------
    mean_gap : float
        Mean over the whole area, places that touch counted as 0 [m], above 0.
    touching : float
        Share that touches, above 0 and at most `MOST_TOUCHING`.

    Returns
    -------
    GaussianGaps
        The one Gaussian that has both: x = mean/rms from Phi(-x) = touching, rms = mean_gap/(x Phi(x) + n(x)).

    Raises
    ------
    InputError
        If the relief is flattened too far for a Gaussian, or bears nothing.
    """
    from scipy.special import ndtr, ndtri

    if not (mean_gap > 0 and math.isfinite(mean_gap) and 0 < touching <= MOST_TOUCHING):
        raise InputError(
            f"a share of {touching:g} in contact at a mean gap of {mean_gap:g} m: a Gaussian of gaps stands for the relief"
            f" only above gap 0 and up to {MOST_TOUCHING:g} in contact; lower the pressure, or use one gap (no 'spots')"
        )
    x = -float(ndtri(touching))
    rms = mean_gap / (x * float(ndtr(x)) + math.exp(-(x**2) / 2) / math.sqrt(2 * math.pi))
    return GaussianGaps(mean=x * rms, rms=rms)


def pull_in_voltage(
    stiffness: float, free_gap: float, electrical_thickness: float, *, pressure: float = 0.0
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
