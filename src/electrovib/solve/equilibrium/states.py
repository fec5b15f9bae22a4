"""States in which surface topography, load and attraction balance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.contact.attraction import Attraction, PlateAttraction
from electrovib.physics.contact.surface import Surface
from electrovib.solve.equilibrium.roots import NOISE, Crossing, crossings

BEYOND = 1e-6
"""How far past the gap under the load alone is searched, as a share of it: without voltage it is the state."""
PARTS = 64
"""Parts of the range for an attraction that is not convex."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """One state in which the pressures balance.

    Parameters
    ----------
    gap : float
        Mean gap [m].
    stable : bool
        A small push is taken back. A fold, where a stable and an unstable state meet, is not stable.
    touching : bool
        The gap is closed and the plate itself bears a part.
    fold : bool
        Two states closer than rounding tells, where a branch ends.
    repulsion, attraction : float
        Of the surface topography and of the voltage at this gap [Pa].
    stop : float
        What the plate itself bears [Pa]; 0 where the surface topography is not flat.
    residual : float
        repulsion + stop - load - attraction [Pa].
    iterations : int
        Halvings and steps that led to it.
    """

    gap: float
    stable: bool
    touching: bool
    fold: bool
    repulsion: float
    attraction: float
    stop: float
    residual: float
    iterations: int


def equilibria(
    *,
    surface: Surface,
    pressure: float,
    voltage: float,
    electrical_thickness: float,
    gaps: tuple[float, float] | None = None,
) -> tuple[Equilibrium, ...]:
    """Gaps at which surface topography, load and the attraction of plates balance: all of them.

    Parameters
    ----------
    surface : Surface
        What repels.
    pressure : float
        Of the load [Pa].
    voltage : float
        Held [V], or the root mean square of a sine.
    electrical_thickness : float
        K, the sum of T/eps over the layers that block [m], above 0.
    gaps : (float, float), optional
        Range searched [m]; by default from closed to the gap under the load alone, which holds every state.

    Returns
    -------
    tuple of Equilibrium
        From the smallest gap to the largest, the closed state first if there is one.

    Raises
    ------
    InputError
        If the range is none, or infinite because nothing presses.

    Notes
    -----
    repulsion(g) = pressure + eps0 V^2/(2 (K + g)^2). With the plate as a stop at gap 0 the closed state is one
    more where the surface topography bears less there than presses. A surface topography that stiffens has one
    state, or two stable ones with an unstable one between.
    """
    return balance(surface, PlateAttraction(voltage, electrical_thickness), pressure=pressure, gaps=gaps)


def balance(
    surface: Surface,
    attraction: Attraction,
    *,
    pressure: float,
    gaps: tuple[float, float] | None = None,
) -> tuple[Equilibrium, ...]:
    """Gaps at which surface topography, load and any attraction balance.

    Parameters
    ----------
    surface : Surface
        What repels.
    attraction : Attraction
        For instance that of a rough skin with its spots, `RoughAttraction`.
    pressure : float
        Of the load [Pa].
    gaps : (float, float), optional
        Range searched [m]; by default as far as the attraction is defined.

    Returns
    -------
    tuple of Equilibrium
        From the smallest gap to the largest. The closed state is looked for where the range begins at 0.

    Raises
    ------
    InputError
        If the range is none, or infinite because nothing presses.

    Notes
    -----
    All states of a convex attraction are found for certain. Of another, two states closer than a 64th of the
    range may be missed where the attraction has a point of inflection.
    """
    low, high = _range(surface, attraction, pressure) if gaps is None else gaps
    if not (0 <= low <= high and math.isfinite(high)):
        raise InputError(f"gaps = ({low}, {high}): two finite lengths in m, 0 or more and the smaller first")

    def repels(gap: float) -> tuple[float, float]:
        at = np.asarray(gap)
        return float(surface.pressure(at)), float(surface.slope(at))

    def draws(gap: float) -> tuple[float, float]:
        return pressure + attraction.pressure(gap), attraction.slope(gap)

    states = [
        _state(place, repels(place.place), draws(place.place), pressure)
        for place in crossings(repels, draws, low=low, high=high, parts=1 if attraction.convex else PARTS)
    ]
    lacking = draws(low)[0] - repels(low)[0]
    if low == 0 and lacking > 0:
        closed = Equilibrium(
            gap=0.0,
            stable=True,
            touching=True,
            fold=False,
            repulsion=repels(0)[0],
            attraction=draws(0)[0] - pressure,
            stop=lacking,
            residual=0.0,
            iterations=0,
        )
        states = [closed, *(state for state in states if state.gap > 0)]
    return tuple(states)


def _state(
    found: Crossing, repels: tuple[float, float], draws: tuple[float, float], pressure: float
) -> Equilibrium:
    (repulsion, first), (drawn, second) = repels, draws
    marginal = abs(first - second) <= NOISE * (abs(first) + abs(second))
    return Equilibrium(
        gap=found.place,
        stable=first < second and not found.fold and not marginal,
        touching=False,
        fold=found.fold or marginal,
        repulsion=repulsion,
        attraction=drawn - pressure,
        stop=0.0,
        residual=repulsion - drawn,
        iterations=found.iterations,
    )


def _range(surface: Surface, attraction: Attraction, pressure: float) -> tuple[float, float]:
    """Every state bears at least the load: its gap is at most the one under the load alone."""
    high = float(surface.gap(np.asarray(pressure))) * (1 + BEYOND)
    if not math.isfinite(high):
        raise InputError(
            f"pressure = {pressure} Pa: nothing presses skin and plate together, so the gap has no bound. Give a pressure"
            " above 0, or the range of gaps to search, gaps = (0, 1e-4)"
        )
    low = float(getattr(attraction, "smallest_gap", 0.0))
    return low, max(low, high)
