"""Rough contact: gaps that differ from place to place, and the pull averaged over them with its contact part.

At each place the layers and the local gap are taken as plates in series. That holds where the roughness varies
along the surface over lengths long against 2 pi T_i, T_i being the thickness of the insulator: on a coat of a
micrometre, not on a film of 90 um (0.57 mm, more than the period of a print).
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

NODES = 96
"""Gauss points of the average: within 1e-9 of it for layers from 1e-5 to 1e5 rms gaps thick."""
REACH = 9.0
"""How many rms gaps on either side of the mean are integrated: 1e-19 of the places lie beyond."""

_gauss = functools.cache(np.polynomial.legendre.leggauss)


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


@dataclass(frozen=True)
class GaussianGaps:
    """Gaps distributed as a Gaussian, of which what is at or below 0 touches.

    Parameters
    ----------
    mean : float
        Mean of the Gaussian [m], 0 or more; above 0 it is near the mean gap of the whole contact.
    rms : float
        Standard deviation of the Gaussian [m], above 0.

    """

    mean: float
    rms: float

    def __post_init__(self) -> None:
        """Refuse what is no distribution of gaps."""
        if not (math.isfinite(self.mean) and self.mean >= 0):
            raise InputError(f"mean = {self.mean}: a mean gap is finite and not below 0, for instance 5e-6 m")
        if not (math.isfinite(self.rms) and self.rms > 0):
            raise InputError(f"rms = {self.rms}: an rms gap is finite and above 0, for instance 5e-6 m")

    @property
    def contact_fraction(self) -> float:
        """Share phi of the area that touches, A_real/A0: the part of the Gaussian at or below 0."""
        return 0.5 * math.erfc(self.mean / (self.rms * math.sqrt(2)))

    def density(self, gap: ArrayLike) -> NDArray[np.float64]:
        """Share of the area for each length of gap [1/m] at gaps [m] above 0."""
        away = (np.asarray(gap, dtype=float) - self.mean) / self.rms
        spread: NDArray[np.float64] = np.exp(-(away**2) / 2) / (math.sqrt(2 * math.pi) * self.rms)
        return spread

    def rule(
        self, near: ArrayLike, *, count: int = NODES, reach: float = REACH
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Gaps above 0 and shares of the area that stand for all of them in an average.

        Parameters
        ----------
        near : float or array_like
            Gap [m], above 0, over which what is averaged changes near contact: the electrical thickness.
        count : int
            How many gaps.
        reach : float
            How many rms gaps around the mean count.

        Returns
        -------
        gaps, shares : ndarray, shape (..., count)
            m and 1; the shares add up to 1 - `contact_fraction`.

        Notes
        -----
        Gauss-Legendre in t, gap = near (e^t - 1): one rule resolves 1/(gap + near)^2 and the Gaussian.
        """
        scale = np.asarray(near, dtype=float)[..., None]
        low = np.log1p(max(0.0, self.mean - reach * self.rms) / scale)
        high = np.log1p((self.mean + reach * self.rms) / scale)
        points, weights = _gauss(count)
        half = (high - low) / 2
        place = low + half * (1 + points)
        gaps = scale * np.expm1(place)
        shares = weights * half * scale * np.exp(place) * self.density(gaps)
        return gaps, shares


@dataclass(frozen=True)
class Pull:
    """Attraction per area of the whole contact, in its two parts.

    Parameters
    ----------
    spots : float or ndarray
        What the spots that touch contribute [Pa of the whole area].
    gaps : float or ndarray
        What all other places contribute [Pa of the whole area].
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
    """Attraction per area where the gap is the same everywhere.

    Parameters
    ----------
    voltage : float or array_like
        Across layers and gap [V]: held, or the root mean square of a sine, its amplitude over sqrt(2).
    electrical_thickness : complex or array_like
        Sum of T/eps* over the layers [m]; complex at a frequency where they lose.
    gap : float or array_like
        m, 0 or more.

    Returns
    -------
    float or ndarray
        Pa; for a sine the mean over time.

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
    """Attraction per area averaged over the gaps of a rough contact, with its contact part.

    Parameters
    ----------
    voltage : float or array_like
        Across layers and gap [V]: held, or the root mean square of a sine.
    electrical_thickness : complex or array_like
        Sum of T/eps* over the layers [m], not 0.
    gaps : GaussianGaps
        From which both parts are taken.
    spots : ContactSpots
        What the voltage does where the gap is 0.
    frequency : float or array_like
        Of the sine [Hz]; 0 for a held voltage.

    Returns
    -------
    Pull
        Pa, arrays of the common shape of the arguments.

    Notes
    -----
    eps0 V^2/2 [phi |share|^2/|h0|^2 + integral over u > 0 of P(u)/|u + h0|^2 du], phi = A_real/A0 the contact
    fraction of the same P. Valid for roughness long along the surface against 2 pi T_i.
    """
    thickness = np.asarray(electrical_thickness, dtype=complex)
    places, shares = gaps.rule(np.abs(thickness))
    inverse = np.sum(shares / np.abs(places + thickness[..., None]) ** 2, axis=-1)
    stress = eps0 * np.asarray(voltage, dtype=float) ** 2 / 2
    share = np.abs(spots.field_share(np.asarray(frequency, dtype=float))) ** 2
    return Pull(stress * gaps.contact_fraction * share / np.abs(thickness) ** 2, stress * inverse)


def contact_fraction(pressure: ArrayLike, *, modulus: float, slope: float) -> NDArray[np.float64]:
    """Share of the nominal area in real contact when a rough elastic body is pressed on a plate.

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
    float or ndarray
        A_real/A0, from 0 to 1.

    Notes
    -----
    erf(sqrt(2) p/(E* h')): recalled from Persson's contact mechanics, not read. Its limits are checked: 1.596
    p/(E* h') for small pressures, 1 for large ones.
    """
    from scipy.special import erf

    share: NDArray[np.float64] = erf(math.sqrt(2) * np.asarray(pressure, dtype=float) / (modulus * slope))
    return share


def contact_growth(pressure: float, *, modulus: float, slope: float) -> float:
    """Rate at which `contact_fraction` grows with pressure.

    Parameters
    ----------
    pressure : float
        Nominal pressure [Pa], 0 or more.
    modulus : float
        Effective modulus [Pa], above 0.
    slope : float
        Root mean square slope, above 0.

    Returns
    -------
    float
        1/Pa.
    """
    reduced = pressure / (modulus * slope)
    return math.sqrt(8 / math.pi) / (modulus * slope) * math.exp(-2 * reduced**2)
