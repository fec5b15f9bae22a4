"""How much of a rough contact has a field above the strength of its film, where a law declares the local gaps.

The films at a place and its gap are plates in series, across which the whole voltage is; a spot that touches has the field of
the closed gap. The limit of the closed gap stays the bound: this share says on how much of the area it is exceeded, and allows
nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.contact.attraction import RoughAttraction
from electrovib.physics.roughness import REACH, GaussianGaps, PullingSpots
from electrovib.solve.rough_contact.solved import solved_contact

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.contact import Surface
    from electrovib.scenario import Scenario

CLOSE: Final = 1e-6
"""Relative change of the gap at which the contact under load and attraction is found."""
MOST_STEPS: Final = 1000
NARROW: Final = 1e-12
"""Gap [m] that counts as closed."""


def area_beyond(
    scenario: Scenario,
    field: Callable[[float], float],
    *,
    strength: float,
    voltage: float,
    electrical_thickness: float,
) -> tuple[float, str] | None:
    """Return the share of the contact area with a field above a strength [V/m], and by which law; None where none is declared.

    `field` [V/m] of the film at a local gap [m], falling with it; `voltage` [V] and `electrical_thickness` [m] of the films,
    from which the attraction follows that presses the surface closer.
    """
    if (found := _solved(scenario, voltage)) is not None:
        widest = float(found[-1])
        reach = _gap_at(field, strength, widest) if field(widest) <= strength else widest
        share = float(np.searchsorted(found, reach, side="right")) / found.size
        return share, "contact.surface, which is solved under load and attraction"
    gaps = scenario.force.gaps()
    law = f"{type(scenario.force).__name__}, whose gaps are declared and follow no attraction"
    if gaps is None:
        surface, load = scenario.contact.surface, scenario.load.normal_force
        if surface is None or not (surface.is_rough and load > 0):
            return None
        pressure = float(scenario.contact.mean_pressure(np.asarray(load)))
        attraction = RoughAttraction(
            voltage=voltage,
            electrical_thickness=electrical_thickness,
            surface=surface,
            spots=PullingSpots(),
        )
        gaps, may_shut = pressed_gaps(surface, attraction, pressure)
        law = f"{type(surface).__name__}, {surface.standing}, under load and attraction"
        if gaps is None:
            return 1.0, f"{law}, where the contact falls shut"
        if may_shut:
            law += " of a voltage that rises, and on all of it once the contact has fallen shut"
    widest = float(gaps.rms * (gaps.mean / gaps.rms + REACH) ** gaps.power)
    if not field(widest) <= strength:
        return 1.0, f"{law}; no gap keeps the voltage off the film"
    return float(gaps.share_up_to(_gap_at(field, strength, widest))), law


def _solved(scenario: Scenario, voltage: float) -> Real | None:
    """Return the gaps [m] in rising order of a contact that is solved; None where there is none, or it is not known so far."""
    try:
        known = solved_contact(scenario)
        return None if known is None else known.gaps(voltage)
    except ElectrovibError:
        return None


def pressed_gaps(
    surface: Surface, attraction: RoughAttraction, pressure: float
) -> tuple[GaussianGaps | None, bool]:
    """Return the gaps that a rising voltage reaches under a load [Pa], None if it shuts them, and whether they could be shut."""
    try:
        least = attraction.smallest_gap
        may_shut = pressure + attraction.pressure(least) > float(surface.pressure(np.asarray(least)))
        gap = float(surface.gap(np.asarray(pressure)))
        for _ in range(MOST_STEPS):
            if gap <= least:
                return None, may_shut
            borne = pressure + attraction.pressure(gap)
            before, gap = gap, float(surface.gap(np.asarray(borne)))
            if least < gap and before - gap <= CLOSE * before:
                return surface.gaps(borne), may_shut
    except (
        InputError
    ):  # a surface so soft that no distribution bears it counts as shut: a check does not end here
        return None, True
    return None, may_shut


def _gap_at(field: Callable[[float], float], strength: float, widest: float) -> float:
    """Return the gap [m] at which the field falls to a strength; 0 where that gap counts as closed."""
    from scipy.optimize import brentq

    if field(NARROW) <= strength:
        return 0.0
    return float(brentq(lambda gap: field(gap) - strength, NARROW, widest, rtol=1e-9))
