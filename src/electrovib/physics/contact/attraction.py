"""Attraction per area as a function of the mean gap, for plates and for a rough skin with contact spots."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.contact.surface import MOST_TOUCHING, Surface
from electrovib.physics.roughness import ContactSpots, Pull, mean_pull

SMALLEST = 1e-9
"""Mean gap over the electrical thickness below which the gap changes the attraction by less than rounding."""


class Attraction(Protocol):
    """An attraction per area that depends on the mean gap."""

    convex: ClassVar[bool]
    """Whether the slope increases with the gap everywhere, so that every equilibrium is found."""

    @property
    def smallest_gap(self) -> float:
        """Mean gap [m] from which on the attraction is known; 0 if it is known for every gap."""

    def total(self, gap: float) -> float:
        """Return the attraction [Pa] at a gap [m], 0 or more."""

    def pressure(self, gap: float) -> float:
        """Return the part of it that brings the faces closer [Pa], as a load does."""

    def slope(self, gap: float) -> float:
        """Return the derivative of that part with the gap [Pa/m] at a gap [m]."""


@dataclass(frozen=True)
class PlateAttraction:
    """Attraction of parallel plates with layers and a uniform gap g between them: eps0 V^2/(2 (K + g)^2).

    Parameters
    ----------
    voltage : float
        Constant voltage, or root mean square of a sine [V].
    electrical_thickness : float
        K, the sum of T/eps over the layers that block [m], above 0.
    """

    voltage: float
    electrical_thickness: float
    convex: ClassVar[bool] = True
    smallest_gap: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        """Refuse an electrical thickness for which the attraction is unbounded."""
        check_thickness(electrical_thickness=self.electrical_thickness)

    def pressure(self, gap: float) -> float:
        """Return the attraction [Pa] at a gap [m]."""
        return eps0 * self.voltage**2 / (2 * (self.electrical_thickness + gap) ** 2)

    total = pressure

    def slope(self, gap: float) -> float:
        """Return the derivative of the attraction with the gap [Pa/m] at a gap [m]."""
        return -eps0 * self.voltage**2 / (self.electrical_thickness + gap) ** 3


@dataclass(frozen=True, kw_only=True)
class RoughAttraction:
    """Attraction of a rough skin, averaged over its gaps and its contact spots.

    Parameters
    ----------
    voltage : float
        Constant voltage, or root mean square of a sine [V].
    electrical_thickness : float
        K, the sum of T/eps over the layers that block [m], above 0.
    surface : Surface
        Surface topography with a distribution of gaps under pressure.
    spots : ContactSpots
        Share of the field at places where skin and plate touch.
    frequency : float
        Frequency of the sine [Hz]; 0 for a constant voltage.

    Notes
    -----
    eps0 V^2/2 [phi |share|^2/K^2 + integral over u > 0 of P(u)/(u + K)^2 du]: `mean_pull` over the gaps of the
    surface under the pressure that it bears at this mean gap, which is that of load and attraction together without the
    share `surface.held` of what the spots attract. The attraction is not convex everywhere; with contact spots that attract
    less than a gap, on a thick layer, it even increases with the gap.
    """

    voltage: float
    electrical_thickness: float
    surface: Surface
    spots: ContactSpots
    frequency: float = 0.0
    convex: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Refuse an electrical thickness for which the attraction is unbounded."""
        check_thickness(electrical_thickness=self.electrical_thickness)

    @property
    def smallest_gap(self) -> float:
        """Mean gap [m] from which on the surface topography is a Gaussian: at most half of the area touches there."""
        low, high = SMALLEST * self.electrical_thickness, 1.0
        if self._touching(low) <= MOST_TOUCHING:
            return low
        while high - low > 1e-12 * high:  # halvings: the share in contact falls with the gap
            middle = (low + high) / 2
            low, high = (middle, high) if self._touching(middle) > MOST_TOUCHING else (low, middle)
        return high

    def parts(self, gap: float) -> Pull:
        """Attraction [Pa] of spots and gaps at a mean gap [m]."""
        return mean_pull(
            self.voltage,
            electrical_thickness=self.electrical_thickness,
            gaps=self.surface.gaps(self._borne(gap)),
            spots=self.spots,
            frequency=self.frequency,
        )

    def total(self, gap: float) -> float:
        """Attraction [Pa] at a mean gap [m]."""
        return float(self.parts(gap).total)

    def pressure(self, gap: float) -> float:
        """Attraction without what the spots hold [Pa] at a mean gap [m]."""
        parts = self.parts(gap)
        return float(parts.total - self.surface.held * parts.spots)

    def slope(self, gap: float) -> float:
        """Change of that pressure [Pa/m] at a mean gap [m].

        By the chain rule: the mean gap moves the share phi that touches and with it x = mean/rms and the rms, and both the gaps
        at given quantiles.
        """
        pressure, thickness = self._borne(gap), self.electrical_thickness
        gaps = self.surface.gaps(pressure)
        x = gaps.mean / gaps.rms
        density = math.exp(-(x**2) / 2) / math.sqrt(2 * math.pi)
        touching = self.surface.real_growth(pressure) * float(self.surface.slope(np.asarray(gap)))
        x_moves = -touching / density
        places, shares = gaps.rule(thickness)
        reduced = places / gaps.rms
        away = reduced ** (1 / gaps.power) - x
        # the mean gap is the rms times the mean of the reduced gaps
        rms_moves = (1 - gaps.rms * x_moves * float(np.sum(shares * away * reduced))) * gaps.rms / gap
        beyond = places + thickness
        inverse = float(np.sum(shares * (away * x_moves / beyond**2 - 2 * reduced * rms_moves / beyond**3)))
        share = abs(complex(self.spots.field_share(np.asarray(self.frequency)))) ** 2
        share *= 1 - self.surface.held
        return eps0 * self.voltage**2 / 2 * (touching * share / thickness**2 + inverse)

    def _borne(self, gap: float) -> float:
        return float(self.surface.pressure(np.asarray(gap)))

    def _touching(self, gap: float) -> float:
        return float(self.surface.real_share(np.asarray(self._borne(gap))))


def check_thickness(*, electrical_thickness: float) -> None:
    """Refuse an electrical thickness [m] that is not above 0: the attraction of a closed gap would be unbounded."""
    if not (electrical_thickness > 0 and math.isfinite(electrical_thickness)):
        raise InputError(
            f"electrical_thickness = {electrical_thickness}: must be above 0 m, for instance 27e-6; without a blocking layer"
            " the attraction of a closing gap is unbounded"
        )
