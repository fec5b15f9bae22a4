"""Real contact under load and attraction: of a contact that is solved, or of a law, without what its spots hold themselves.

Inside a spot attraction and contact pressure balance, so that a share `held` of what spots attract presses nothing: the pressure
that is borne is b = P - held s(b) a, with P of load and attraction together, a of the attraction, and s the share of the
attraction that spots have in the local gaps under b.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.roughness import PullingSpots, mean_pull
from electrovib.solve.rough_contact.solved import solved_contact
from electrovib.solve.stack.blocking import blocking_thickness

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.contact import Surface
    from electrovib.scenario import Scenario

NODES: Final = 24
"""Pressures in a decade at which the share of spots is computed, the same ones for every finger and time; linear between them."""
STEPS: Final = 50
CLOSE: Final = 1e-14
"""Relative change of the pressure at which it is found."""


def real_area(scenario: Scenario, load: Real, attraction: Real) -> Real:
    """Compute the real contact area [m2] under a load and an attraction that presses [N]."""
    contact, surface = scenario.contact, scenario.contact.surface
    whole = np.asarray(load + attraction, dtype=float)
    if surface is None:
        return np.asarray(contact.real_area(whole))  # which explains what is missing
    pressure = np.asarray(contact.mean_pressure(whole), dtype=float)
    if (solved := solved_contact(scenario)) is not None:
        return np.asarray(contact.outline(whole) * solved.contact_share(pressure))
    thickness = blocking_thickness(scenario) if surface.held and np.any(attraction > 0) else None
    if thickness is not None and getattr(scenario.force, "spots", PullingSpots()).leak == 0:
        with np.errstate(invalid="ignore", divide="ignore"):
            own = np.nan_to_num(np.maximum(attraction, 0.0) / whole) * pressure
        pressure = borne(surface, pressure, own, electrical_thickness=thickness)
    return np.asarray(contact.outline(whole) * surface.real_share(pressure))


def borne(surface: Surface, pressure: Real, attraction: Real, *, electrical_thickness: Any) -> Real:
    """Return the pressure [Pa] that a contact bears, of load and attraction together, of which the attraction is a part [Pa].

    `electrical_thickness` [m] may be a column of many fingers.
    """
    within = pressure[np.isfinite(pressure) & (pressure > 0)]
    if not within.size:
        return pressure
    ends = np.log10([(1 - surface.held) * within.min(), within.max()])
    low, high = math.floor(NODES * ends[0]) - 1, math.ceil(NODES * ends[1]) + 1
    at = 10 ** (np.arange(low, high + 1) / NODES)
    shares = surface.held * _of_spots(surface, at, np.atleast_1d(np.ravel(electrical_thickness)))
    logarithm = np.log(at)
    if len(shares) > 1:
        both = np.broadcast_arrays(pressure, attraction)
        return np.array([_borne(each, logarithm, *some) for each, *some in zip(shares, *both, strict=True)])
    return _borne(shares[0], logarithm, pressure, attraction)


def _borne(held: Real, logarithm: Real, pressure: Real, attraction: Real) -> Real:
    """Return the pressure that is borne by Newton's method, for the share of the attraction that is held, over ln(pressure)."""
    slopes, found = np.gradient(held, logarithm), np.array(pressure, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(STEPS):
            at = np.log(found)
            rest = found + np.interp(at, logarithm, held) * attraction - pressure
            step = rest / (1 + np.interp(at, logarithm, slopes) * attraction / found)
            found = np.maximum(found - np.nan_to_num(step), np.exp(logarithm[0]) * (pressure > 0))
            if not np.any(np.abs(step) > CLOSE * pressure):
                break
    return found


def _of_spots(surface: Surface, pressures: Real, electrical_thickness: Real) -> Real:
    """Return the share of the attraction that spots have (thicknesses, pressures), beyond the gaps of the law the last."""
    found = np.zeros((electrical_thickness.size, pressures.size))
    for place, each in enumerate(pressures.tolist()):
        try:
            gaps = surface.gaps(each)
        except InputError:  # more than half of the area touches
            found[:, place:] = found[:, place - 1 : place] if place else 1.0
            break
        pull = mean_pull(1.0, electrical_thickness=electrical_thickness, gaps=gaps, spots=PullingSpots())
        found[:, place] = pull.spots / pull.total
    return found
