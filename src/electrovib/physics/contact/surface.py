"""Response of the surface topography of the skin to pressure, mean gap and real contact: a spring, and rough skins."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity
from electrovib.physics.roughness import GaussianGaps, contact_fraction, contact_growth

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


MOST_TOUCHING = 0.5
"""Share of real contact up to which a Gaussian distribution of gaps, with a mean not below 0, is used."""
MODULUS = Quantity("Pa", 1e2, 1e12, "effective modulus E/(1 - nu^2) of the skin at the plate")
SLOPE = Quantity("1", 1e-6, 1e3, "root mean square slope of the surface topography")
HEIGHT = Quantity("m", 1e-10, 1e-2, "root mean square height of the surface topography")


FITTED: Final = {
    "real over gross contact area": ("1", 1e-3, MOST_TOUCHING),
    "rms_height": ("m", 0.5e-6, 30e-6),
    "rms_slope": ("1", 0.04, 0.7),
}
"""Ranges in which `FittedSurface` was fitted."""


class RoughSurface(Surface, family=True):
    """A rough elastic skin whose real contact is that of Persson's theory.

    Notes
    -----
    A_real/A0 = erf(sqrt(2) p/(E* h')), cited from memory, unverified. Every member declares its `modulus` E* and its
    `rms_slope` h'.
    """

    power: ClassVar[float] = 1.0
    """Power of a Gaussian that the gaps follow."""
    error: ClassVar[str] = ""
    """By how much a corrected law is wrong, in words."""

    is_rough: ClassVar[bool] = True
    standing: ClassVar[str] = "not corrected"

    def doubts(self, share: ArrayLike) -> str:
        """Return what makes the law wrong by more than the goal at shares in contact [1]; empty where nothing does."""
        del share
        return (
            "its real contact is 0.55 to 1 (median 0.74) times that of contacts solved, and its attraction at their mean gap"
            " 0.52 to 1 (0.8) times theirs; FittedSurface is corrected"
        )

    def diagnostics(self, share: ArrayLike) -> tuple[Diagnostic, ...]:
        """Return how large the error of the law is at shares in contact [1]."""
        law, doubts = f"real contact is that of {type(self).__name__}, {self.standing}", self.doubts(share)
        return (Diagnostic("real contact", "warning" if doubts else "ok", f"{law}: {doubts or self.error}"),)

    if TYPE_CHECKING:  # parameters of every member, each in its own order

        @property
        def modulus(self) -> float:
            """Effective modulus of the skin [Pa]."""

        @property
        def rms_slope(self) -> float:
            """Root mean square slope of the surface topography."""

    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the area in contact [1]."""
        return contact_fraction(pressure, modulus=self.modulus, slope=self.rms_slope)

    def real_growth(self, pressure: float) -> float:
        """Return the derivative of the share in contact with pressure [1/Pa]."""
        return contact_growth(pressure=pressure, modulus=self.modulus, slope=self.rms_slope)

    def gaps(self, pressure: float) -> GaussianGaps:
        """Return the Gaussian distribution of gaps with the mean gap and the real contact at a pressure [Pa]."""
        at = np.asarray(pressure)
        mean_gap, touching = float(self.gap(at)), float(self.real_share(at))
        return gaussian_gaps(mean_gap=mean_gap, touching=touching, power=self.power)


class PerssonSurface(RoughSurface):
    """A rough elastic skin after Persson: repulsion falls exponentially with the mean gap.

    Notes
    -----
    p = pressure_factor E* exp(-gap/(decay_factor rms_gap)) and A_real/A0 = erf(sqrt(2) p/(E* h')). The forms
    are cited from memory, unverified; so are the two factors (for the pressure of the order of the wave number of the
    longest roughness times its rms height, for the decay somewhat below 1), which therefore have no default.
    Valid for small pressures, at mean gaps of some rms gaps; towards gap 0 the exponential is not justified.
    """

    reference: ClassVar[str] = "doi:10.1063/1.5024038"
    status: ClassVar[str] = "unverified"
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
    rms_gap: Annotated[Number, HEIGHT]
    pressure_factor: Annotated[Number, Quantity("1", 1e-6, 1e3, "repulsion at gap 0 over the modulus")]
    decay_factor: Annotated[
        Number, Quantity("1", 0.01, 10, "change of gap for a factor e in repulsion, over rms height")
    ]

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the repulsion per area [Pa]."""
        flat, decay = self.pressure_factor * self.modulus, self.decay_factor * self.rms_gap
        return exponential_pressure(gap, flat=flat, decay=decay)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative of the repulsion with the gap [Pa/m]."""
        return -self.pressure(gap) / (self.decay_factor * self.rms_gap)

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean gap under a pressure [m]."""
        flat, decay = self.pressure_factor * self.modulus, self.decay_factor * self.rms_gap
        return exponential_gap(pressure, flat=flat, decay=decay)


class FittedSurface(RoughSurface):
    """A rough elastic skin by laws that were fitted to contacts solved together with their field.

    Notes
    -----
    With the reduced pressure x = p/(E* h'): A_real/A0 = erf(sqrt(2) SHARE x^GROWTH), the form of Persson's theory with a factor
    and a power, and p = FLAT E* h' exp(-gap/(DECAY rms_height)). Local gaps follow the power 4/3 of a Gaussian. p is load and
    attraction, without the share `held` of what the spots attract: inside a spot attraction and contact pressure balance each
    other and bend nothing, so that on a thin film an attraction brings the faces less close than a load. The six numbers are
    those of 30 self-affine surfaces with rms heights of 0.5 to 30 um under 1 to 50 kPa and voltages until they fall shut;
    `benchmarks/rough_laws.md` has them beside the contacts solved, and ten surfaces on which nothing was fitted.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "pressure": "0.362*rms_slope*modulus*exp(-gap/(0.451*rms_height))",
        "slope": "-0.362*rms_slope*modulus*exp(-gap/(0.451*rms_height))/(0.451*rms_height)",
        "real_share": "erf(sqrt(2)*1.29*Max(pressure/(modulus*rms_slope), 0)**0.974)",
    }
    example: ClassVar[Mapping[str, Any]] = {"modulus": 2e6, "rms_height": 2e-5, "rms_slope": 0.5}
    standing: ClassVar[str] = "corrected by contacts solved"
    error: ClassVar[str] = (
        "from a contact share of 0.01 on the attraction at a given pressure is within 15 % of contacts solved and it within 20 %,"
        " below both within 25 %; an attraction from the load alone is within 15 % for nine in ten and 30 % for all, as a mean of"
        " many places, until a part of them falls shut"
    )
    power: ClassVar[float] = 4 / 3
    held: ClassVar[float] = 0.7
    SHARE: ClassVar[float] = 1.29
    GROWTH: ClassVar[float] = 0.974
    FLAT: ClassVar[float] = 0.362
    DECAY: ClassVar[float] = 0.451

    modulus: Annotated[Number, MODULUS]
    rms_height: Annotated[Number, HEIGHT]
    rms_slope: Annotated[Number, SLOPE]

    def doubts(self, share: ArrayLike) -> str:
        """Return where the surface, or a share in contact [1] above 0, is outside those that the law was fitted to."""
        given = np.asarray(share, dtype=float)
        touching = given[given > 0]
        reached = {
            "real over gross contact area": touching[[touching.argmin(), touching.argmax()]]
            if touching.size
            else (),
            "rms_height": (self.rms_height,),
            "rms_slope": (self.rms_slope,),
        }
        off = [
            f"{name} = {format_quantity(float(value), unit, digits=3)} (fitted: {format_quantity(low, unit)} to"
            f" {format_quantity(high, unit)})"
            for name, (unit, low, high) in FITTED.items()
            for value in reached[name]
            if not low <= value <= high
        ]
        return f"its error is not known outside what it was fitted to, {'; '.join(off)}" if off else ""

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the repulsion per area [Pa]."""
        return exponential_pressure(gap, flat=self._flat, decay=self.DECAY * self.rms_height)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative of the repulsion with the gap [Pa/m]."""
        return -self.pressure(gap) / (self.DECAY * self.rms_height)

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean gap under a pressure [m]."""
        return exponential_gap(pressure, flat=self._flat, decay=self.DECAY * self.rms_height)

    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the area in contact [1]."""
        reduced = np.maximum(np.asarray(pressure, dtype=float) / (self.modulus * self.rms_slope), 0.0)
        return contact_fraction(self.SHARE * reduced**self.GROWTH, modulus=1.0, slope=1.0)

    def real_growth(self, pressure: float) -> float:
        """Return the derivative of the share in contact with pressure [1/Pa]."""
        reduced = pressure / (self.modulus * self.rms_slope)
        inner = self.SHARE * reduced**self.GROWTH
        growth = contact_growth(pressure=float(inner), modulus=1.0, slope=1.0)
        return growth * self.GROWTH * float(inner) / pressure

    @property
    def _flat(self) -> float:
        return self.FLAT * self.rms_slope * self.modulus


def exponential_pressure(gap: ArrayLike, *, flat: float, decay: float) -> NDArray[np.float64]:
    """Return a repulsion per area [Pa] that falls exponentially with the gap [m]: flat exp(-gap/decay).

    `flat` is the pressure at gap 0 [Pa], `decay` the change of gap over which it falls by a factor e [m].
    """
    pressure: NDArray[np.float64] = flat * np.exp(-np.asarray(gap, dtype=float) / decay)
    return pressure


def exponential_gap(pressure: ArrayLike, *, flat: float, decay: float) -> NDArray[np.float64]:
    """Return the gap [m] at which `exponential_pressure` bears a pressure [Pa]: decay ln(flat/pressure).

    It is infinite at pressures of 0 or less, and 0 at pressures of `flat` or more.
    """
    with np.errstate(divide="ignore"):
        ratio = np.log(flat / np.maximum(np.asarray(pressure, dtype=float), 0.0))
    gap: NDArray[np.float64] = np.maximum(decay * ratio, 0.0)
    return gap


def gaussian_gaps(*, mean_gap: float, touching: float, power: float = 1.0) -> GaussianGaps:
    """Return the Gaussian distribution of gaps, or one of a power of it, with a given mean gap and a given real contact.

    `mean_gap` [m], above 0, is the mean over the whole area, where contact counts as gap 0; `touching` is the
    share of the area in contact, above 0 and at most `MOST_TOUCHING`. With x = mean/rms: Phi(-x) = touching
    and rms = mean_gap over the mean gap of rms 1, for the power 1 x Phi(x) + n(x).
    """
    from scipy.special import ndtr, ndtri

    if not (mean_gap > 0 and math.isfinite(mean_gap) and 0 < touching <= MOST_TOUCHING):
        raise InputError(
            f"a share of {touching:g} in contact at a mean gap of {mean_gap:g} m: a Gaussian distribution of gaps needs a mean"
            f" gap above 0 m and a share above 0 and up to {MOST_TOUCHING:g}; lower the pressure, or omit 'spots' for one"
            " gap everywhere"
        )
    x = -float(ndtri(touching))
    if power == 1:
        reduced = x * float(ndtr(x)) + math.exp(-(x**2) / 2) / math.sqrt(2 * math.pi)
    else:
        gaps, shares = GaussianGaps(mean=x, rms=1.0, power=power).rule(1.0)
        reduced = float(np.sum(gaps * shares))
    rms = mean_gap / reduced
    return GaussianGaps(mean=x * rms, rms=rms, power=power)
