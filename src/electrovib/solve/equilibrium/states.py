"""Equilibrium states of surface topography, load and attraction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.contact.attraction import Attraction, PlateAttraction
from electrovib.physics.contact.surface import Surface
from electrovib.solve.equilibrium.roots import NOISE, Crossing, crossings

BEYOND = 1e-6
"""Extension of the range beyond the gap under the load alone, as a share of it; without voltage that gap is the state."""
PARTS = 64
"""Number of parts of the range for an attraction that is not convex."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """One equilibrium state.

    Parameters
    ----------
    gap : float
        Mean gap [m].
    stable : bool
        Whether the state is stable against a small displacement. A fold, where a stable and an unstable state meet, is
        not stable.
    touching : bool
        Whether the gap is closed and the plate itself supports a part of the pressure.
    fold : bool
        Whether two states coincide within rounding, where a branch ends.
    repulsion, attraction : float
        Pressures of the surface topography and of the voltage at this gap [Pa].
    stop : float
        Pressure that the plate itself supports [Pa]; 0 where the gap is open.
    residual : float
        repulsion + stop - load - attraction [Pa].
    iterations : int
        Number of halvings and steps of the solution.
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
    """Return all equilibria of surface topography, load and the attraction of parallel plates.

    repulsion(g) = pressure + eps0 V^2/(2 (K + g)^2). The plate is a stop at gap 0; the closed state is an
    additional one where the surface topography supports less there than load and attraction. A stiffening
    surface topography has one state, or two stable states with an unstable one between.
    """
    return balance(surface, PlateAttraction(voltage, electrical_thickness), pressure=pressure, gaps=gaps)


def balance(
    surface: Surface,
    attraction: Attraction,
    *,
    pressure: float,
    gaps: tuple[float, float] | None = None,
) -> tuple[Equilibrium, ...]:
    """Return the equilibria of surface topography, load and any attraction.

    All states of a convex attraction are found with certainty. For other attractions two states closer than a
    64th of the range may be missed where the attraction has a point of inflection.
    """
    low, high = _range(surface, attraction, pressure) if gaps is None else gaps
    if not (0 <= low <= high and math.isfinite(high)):
        raise InputError(
            f"gaps = ({low}, {high}): expected two finite lengths in m, 0 or more, the smaller first"
        )

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
    """Return the range that contains every state: the largest gap is that under the load alone."""
    high = float(surface.gap(np.asarray(pressure))) * (1 + BEYOND)
    if not math.isfinite(high):
        raise InputError(
            f"pressure = {pressure} Pa: nothing presses skin and plate together, so the gap has no bound. Give a pressure"
            " above 0, or the range of gaps to search, gaps = (0, 1e-4)"
        )
    low = float(getattr(attraction, "smallest_gap", 0.0))
    return low, max(low, high)
