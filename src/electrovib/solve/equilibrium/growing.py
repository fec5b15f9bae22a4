"""Equilibria of surface topography, load and attraction on a contact area that grows with load and attraction."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.electrics.pressed import LARGEST, crossed, without_bound
from electrovib.solve.equilibrium.states import BEYOND, Equilibrium

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.contact import Attraction, Contact, Surface


def growing_states(
    contact: Contact, surface: Surface, attraction_on: Callable[[float], Attraction], *, load: float
) -> tuple[tuple[Equilibrium, ...], tuple[float, ...]]:
    """Return the equilibria of a gap under a constant voltage, on the area under load and attraction together.

    The gap follows from the pressure W/area(W) of each total force W, and the attraction across it has to be
    W - load. States are sought in steps of a 64th of the force; two states closer than that are missed.
    """
    least = float(surface.gap(np.asarray(contact.mean_pressure(np.asarray(load)))))
    if not math.isfinite(least):
        raise InputError(
            "contact.surface: without a load the gap of the surface topography is infinite; give load.normal_force above 0"
        )

    def gap(whole: float) -> float:
        return float(surface.gap(np.asarray(contact.mean_pressure(np.asarray(whole)))))

    def drawn(whole: float, low: float) -> float:
        area = contact.gross_area(whole)
        attraction = attraction_on(area)
        return attraction.pressure(max(gap(whole), low)) * area

    low = float(getattr(attraction_on(contact.gross_area(load)), "smallest_gap", 0.0))

    def lacking(whole: Real) -> Real:
        return np.array([each - load - drawn(each, low) for each in whole.tolist()])

    closed = drawn(load, low) / contact.gross_area(load)
    highest = load * (1 + BEYOND) + attraction_on(contact.gross_area(load)).pressure(low) * LARGEST
    found = [(whole, stable) for whole, stable in crossed(lacking, least=load * (1 - BEYOND), most=highest)]
    if not found:
        raise without_bound(contact, pull=closed)
    states = [
        _state(contact, surface, attraction_on, whole, stable, load) for whole, stable in reversed(found)
    ]
    kept = [(state, area) for state, area in states if state.gap >= low]
    return tuple(state for state, _ in kept), tuple(area for _, area in kept)


def _state(
    contact: Contact,
    surface: Surface,
    attraction_on: Callable[[float], Attraction],
    whole: float,
    stable: bool,
    load: float,
) -> tuple[Equilibrium, float]:
    area = contact.gross_area(whole)
    pressing = float(contact.mean_pressure(np.asarray(whole)))
    gap = float(surface.gap(np.asarray(pressing)))
    repulsion, drawn = float(surface.pressure(np.asarray(gap))), attraction_on(area).pressure(gap)
    stop = max(0.0, pressing - repulsion) if gap == 0 else 0.0
    residual = repulsion + stop - load / area - drawn
    state = Equilibrium(
        gap=gap,
        stable=stable,
        touching=gap == 0 and stop > 0,
        fold=False,
        repulsion=repulsion,
        attraction=drawn,
        stop=stop,
        residual=residual,
        iterations=0,
    )
    return state, area
