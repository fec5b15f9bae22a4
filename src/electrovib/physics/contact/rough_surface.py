"""Rough elastic skin: repulsion that falls exponentially with the gap, and real contact."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.contact.surface import Surface
from electrovib.physics.roughness import GaussianGaps, contact_fraction, contact_growth

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

MOST_TOUCHING = 0.5
"""Share of real contact up to which a Gaussian distribution of gaps, with a mean not below 0, is used."""
MODULUS = Quantity("Pa", 1e2, 1e12, "effective modulus E/(1 - nu^2) of the skin at the plate")
SLOPE = Quantity("1", 1e-6, 1e3, "root mean square slope of the surface topography")


class RoughSurface(Surface, family=True):
    """A rough elastic skin whose real contact is that of Persson's theory.

    Notes
    -----
    A_real/A0 = erf(sqrt(2) p/(E* h')), cited from memory, unverified. Every member declares its `modulus` E* and its
    `rms_slope` h'.
    """

    @property
    def standing(self) -> str:
        """The law by its name, and whether it is corrected by contacts that were solved."""
        return f"{type(self).__name__}, not corrected"

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
        return gaussian_gaps(mean_gap=float(self.gap(at)), touching=float(self.real_share(at)))


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
    rms_gap: Annotated[
        Number, Quantity("m", 1e-10, 1e-2, "root mean square height of the surface topography")
    ]
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


def gaussian_gaps(*, mean_gap: float, touching: float) -> GaussianGaps:
    """Return the Gaussian distribution of gaps with a given mean gap and a given real contact.

    `mean_gap` [m], above 0, is the mean over the whole area, where contact counts as gap 0; `touching` is the
    share of the area in contact, above 0 and at most `MOST_TOUCHING`. With x = mean/rms: Phi(-x) = touching
    and rms = mean_gap/(x Phi(x) + n(x)).
    """
    from scipy.special import ndtr, ndtri

    if not (mean_gap > 0 and math.isfinite(mean_gap) and 0 < touching <= MOST_TOUCHING):
        raise InputError(
            f"a share of {touching:g} in contact at a mean gap of {mean_gap:g} m: a Gaussian distribution of gaps needs a mean"
            f" gap above 0 m and a share above 0 and up to {MOST_TOUCHING:g}; lower the pressure, or omit 'spots' for one"
            " gap everywhere"
        )
    x = -float(ndtri(touching))
    rms = mean_gap / (x * float(ndtr(x)) + math.exp(-(x**2) / 2) / math.sqrt(2 * math.pi))
    return GaussianGaps(mean=x * rms, rms=rms)
