"""Rough contact: a distribution of local gaps, and the attraction averaged over gaps and contact spots.

At each place the layers and the local gap are treated as parallel plates in series. That holds where the roughness
varies along the surface over lengths that are long compared with 2 pi T_i, T_i being the thickness of the insulator: on
a coating of a micrometre, not on a film of 90 um (0.57 mm, more than the period of a fingerprint).
"""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity


def contact_fraction(pressure: ArrayLike, *, modulus: float, slope: float) -> NDArray[np.float64]:
    """Return the share of the nominal area in real contact when a rough elastic body is pressed on a plate.

    Parameters
    ----------
    pressure : float or array_like
        Nominal pressure [Pa], 0 or more: load plus attraction.
    modulus : float
        Effective modulus E/(1 - nu^2) [Pa], above 0.
    slope : float
        Root mean square slope of the roughness, above 0.

    Returns
    -------
    share : float or ndarray
        Real over nominal contact area [1], from 0 to 1.

    Notes
    -----
    erf(sqrt(2) p/(E* h')) from Persson's contact mechanics, cited from memory, unverified. Its limits are checked:
    1.596 p/(E* h') for small pressures, 1 for large ones.
    """
    from scipy.special import erf

    share: NDArray[np.float64] = erf(math.sqrt(2) * np.asarray(pressure, dtype=float) / (modulus * slope))
    return share


def contact_growth(*, pressure: float, modulus: float, slope: float) -> float:
    """Return the derivative of `contact_fraction` with pressure [1/Pa]: sqrt(8/pi)/(E* h') exp(-2 (p/(E* h'))^2)."""
    reduced = pressure / (modulus * slope)
    return math.sqrt(8 / math.pi) / (modulus * slope) * math.exp(-2 * reduced**2)


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


def share_of_field(spots: ContactSpots, frequency: float) -> float:
    """Return the size of the field at spots over that at insulating ones [1], at a frequency [Hz] that is 0 or more."""
    if not 0 <= frequency < math.inf:
        raise InputError(
            f"frequency = {frequency}: finite and not below 0 is expected, for instance 200.0 Hz"
        )
    return abs(complex(spots.field_share(np.asarray(frequency))))


def _shared(value: float, frequency: ArrayLike) -> NDArray[np.complex128]:
    given = np.asarray(frequency, dtype=float)
    return np.asarray(np.where(np.isnan(given), np.nan, value), dtype=complex)


NODES = 96
"""Gauss points of the average, which give it to 1e-9 for layers from 1e-5 to 1e5 rms gaps thick."""


REACH = 9.0
"""Half width of the integration in rms gaps; 1e-19 of the area lies beyond."""


_gauss = functools.cache(np.polynomial.legendre.leggauss)


@dataclass(frozen=True)
class GaussianGaps:
    """Gaussian distribution of gaps, whose part at or below 0 is in contact.

    `mean` of the Gaussian [m], 0 or more, which above 0 is near the mean gap of the whole contact, and its
    standard deviation `rms` [m]. With a `power` above 1 the gap is rms (y/rms)^power, y being the positive part of that Gaussian:
    more of the area is narrow beside a spot, as it is where an elastic body leaves the spot with the power 3/2 of the distance.
    """

    mean: Any
    rms: Any
    power: Any = 1.0

    def __post_init__(self) -> None:
        """Refuse a mean, an rms or a power outside its limits."""
        mean, rms, power = (np.asarray(each, dtype=float) for each in (self.mean, self.rms, self.power))
        if not np.all(np.isfinite(mean) & (mean >= 0)):
            raise InputError(f"mean = {self.mean}: a mean gap is finite and not below 0, for instance 5e-6 m")
        if not np.all(np.isfinite(rms) & (rms > 0)):
            raise InputError(f"rms = {self.rms}: an rms gap is finite and above 0, for instance 5e-6 m")
        if not np.all((power >= 1) & (power <= 2)):
            raise InputError(f"power = {self.power}: from 1, a Gaussian, to 2, for instance 4/3")
        for name, value in (("mean", mean), ("rms", rms), ("power", power)):
            object.__setattr__(self, name, value)

    @property
    def contact_fraction(self) -> NDArray[np.float64]:
        """Share phi = A_real/A0 of the area in contact [1]: the part of the Gaussian at or below 0."""
        return self.share_up_to(0.0)

    def share_up_to(self, gap: ArrayLike) -> NDArray[np.float64]:
        """Return the share of the area with a gap [m] up to this one, 0 or more, contact included [1]."""
        from scipy.special import ndtr

        reduced = (np.asarray(gap, dtype=float) / self.rms) ** (1 / self.power)
        share: NDArray[np.float64] = ndtr(reduced - self.mean / self.rms)
        return share

    def density(self, gap: ArrayLike) -> NDArray[np.float64]:
        """Return the probability density of the gap [1/m] at gaps [m] above 0."""
        rms, power = self.rms[..., None], self.power[..., None]
        reduced = np.asarray(gap, dtype=float) / rms
        away = reduced ** (1 / power) - self.mean[..., None] / rms
        spread: NDArray[np.float64] = _normal(away) * reduced ** (1 / power - 1) / (power * rms)
        return spread

    def rule(
        self, near: ArrayLike, *, count: int = NODES, reach: float = REACH
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return nodes (..., count) [m] and weights [1] of a quadrature over the gaps above 0.

        The weights add up to 1 - `contact_fraction`. `near` is the gap [m], above 0, over which the integrand
        changes near contact: the electrical thickness; `reach` is the half width of the integration in rms
        gaps. Gauss-Legendre in t, y = s (e^t - 1) of the Gaussian y, s the one at the gap `near`: one rule resolves
        1/(gap + near)^2 and the Gaussian.
        """
        rms, power, middle = self.rms[..., None], self.power[..., None], (self.mean / self.rms)[..., None]
        scale = (np.asarray(near, dtype=float)[..., None] / rms) ** (1 / power)
        low = np.log1p(np.maximum(0.0, middle - reach) / scale)
        high = np.log1p((middle + reach) / scale)
        points, weights = _gauss(count)
        half = (high - low) / 2
        place = low + half * (1 + points)
        reduced = scale * np.expm1(place)
        shares = weights * half * scale * np.exp(place) * _normal(reduced - middle)
        return rms * reduced**power, shares


def _normal(away: NDArray[np.float64]) -> NDArray[np.float64]:
    density: NDArray[np.float64] = np.exp(-(away**2) / 2) / math.sqrt(2 * math.pi)
    return density


@dataclass(frozen=True)
class Pull:
    """Attraction per area of the whole contact [Pa], in two parts: that of the contact spots and that of the gaps.

    Each is the contribution over the whole area.
    """

    spots: NDArray[np.float64]
    gaps: NDArray[np.float64]

    @property
    def total(self) -> NDArray[np.float64]:
        """Mean attraction per area [Pa]."""
        return self.spots + self.gaps


def local_pull(
    voltage: ArrayLike, *, electrical_thickness: ArrayLike, gap: ArrayLike = 0.0
) -> NDArray[np.float64]:
    """Return the attraction per area where the gap is the same everywhere.

    Parameters
    ----------
    voltage : float or array_like
        Voltage across layers and gap [V]: constant, or the root mean square of a sine, its amplitude over sqrt(2).
    electrical_thickness : complex or array_like
        Sum of T/eps* over the layers [m]; complex at a frequency at which they are lossy.
    gap : float or array_like
        Gap [m], 0 or more.

    Returns
    -------
    attraction : float or ndarray
        Attraction per area [Pa]; for a sine the mean over time.

    Notes
    -----
    eps0 V^2/(2 |u + h0|^2), for a sine of amplitude V0 eps0 V0^2/(4 |u + h0|^2).
    """
    reach = np.abs(np.asarray(gap, dtype=float) + np.asarray(electrical_thickness))
    pull: NDArray[np.float64] = eps0 * np.asarray(voltage, dtype=float) ** 2 / (2 * reach**2)
    return pull


def mean_pull(
    voltage: ArrayLike,
    *,
    electrical_thickness: ArrayLike,
    gaps: GaussianGaps,
    spots: ContactSpots,
    frequency: ArrayLike = 0.0,
) -> Pull:
    """Return the attraction per area of a rough contact, averaged over gaps and contact spots.

    Parameters
    ----------
    voltage : float or array_like
        Voltage across layers and gap [V]: constant, or the root mean square of a sine.
    electrical_thickness : complex or array_like
        Sum of T/eps* over the layers [m], not 0.
    gaps : GaussianGaps
        Distribution of the gaps, from which both parts follow.
    spots : ContactSpots
        Share of the field at contact spots.
    frequency : float or array_like
        Frequency of the sine [Hz]; 0 for a constant voltage.

    Returns
    -------
    Pull
        Both parts [Pa], arrays of the common shape of the arguments.

    Notes
    -----
    eps0 V^2/2 [phi |share|^2/|h0|^2 + integral over u > 0 of P(u)/|u + h0|^2 du], phi = A_real/A0 the contact
    fraction of the same P. Valid for roughness of wavelengths that are long compared with 2 pi T_i.
    """
    thickness = np.asarray(electrical_thickness, dtype=complex)
    places, shares = gaps.rule(np.abs(thickness))
    inverse = np.sum(shares / np.abs(places + thickness[..., None]) ** 2, axis=-1)
    stress = eps0 * np.asarray(voltage, dtype=float) ** 2 / 2
    share = np.abs(spots.field_share(np.asarray(frequency, dtype=float))) ** 2
    return Pull(stress * gaps.contact_fraction * share / np.abs(thickness) ** 2, stress * inverse)
