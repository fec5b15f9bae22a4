"""Electrostatic attraction from the pressure of a force law and the contact area under load and attraction.

Where the area grows with the force, load, attraction and area belong to one equilibrium, and there may be several.

The real contact is that of a contact that is solved, or of a law, without what its spots hold themselves. Inside a spot
attraction and contact pressure balance, so that a share `held` of what spots attract presses nothing: the pressure that is borne
is b = P - held s(b) a, with P of load and attraction together, a of the attraction, and s the share of the attraction that spots
have in the local gaps under b.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.roughness import PullingSpots, mean_pull
from electrovib.solve.rough_contact.solved import solved_contact
from electrovib.solve.stack.blocking import blocking_thickness
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.contact import Contact, Surface
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.section import PhasorSection

PHASES = 32
"""Points per period of the average of a force on a constant area; four are exact for a pressure of second degree."""
LARGEST = 10.0
"""Area [m2] beyond which a contact counts as growing without bound."""
FAR, NEAR = 4.0, 1 + 1 / 64
"""Ratio of the forces between which a state is sought: where there can be only one, and where there may be several."""
FORCES = 256
"""Forces at which it is checked that the mean contact pressure rises with the force."""
SMALLEST = 1e-200
"""Share of the load below which a repelled contact counts as lifted."""
MOST_STEPS, HALVED = 200, 12
"""Largest number of steps to a root, and the number of steps after which one bisects, should straight lines stall."""


def total_pull(scenario: Scenario, amplitudes: dict[str, Real]) -> Real:
    """Compute the attraction per area of the first contact, that of a second contact in series included."""
    if (contact := solved_contact(scenario)) is not None:
        return contact.attraction(**amplitudes)
    second = Surroundings.of(scenario).second
    total = scenario.force.pressure(**amplitudes)
    if np.any(second):  # a column of many fingers has one for each
        denser = {name: values * second for name, values in amplitudes.items()}
        total = total + scenario.force.pressure(**denser) / second
    return np.asarray(total)


def attraction(scenario: Scenario, pull: Real, times: Real | None = None) -> Real:
    """Compute the force of an attraction per area on the contact area under load and attraction together.

    `pull` (..., n) [Pa], `times` (n,) [s]; returns `force` (..., n) [N].
    """
    contact, load = scenario.contact, scenario.load
    if not contact.grows:
        return np.asarray(contact.gross_area() * pull)
    if times is None:
        forces, pressing = np.asarray(load.normal_force), pull
    else:
        forces, pressing = load.forces(times), np.where(scenario.motion.touches(times), pull, 0.0)
    return np.asarray(pull * contact.outline(pressed(contact, forces, pressing)))


def mean_force(scenario: Scenario, section: PhasorSection, *, amplitude: Any) -> Real:
    """Compute the time mean of the attraction under one sine.

    `amplitude` is the peak value of the drive, one for each case if it is a column; returns the force [N] at each frequency
    of the section.
    """
    count = 16 * PHASES
    if not scenario.contact.grows:
        count = 4 if scenario.force.of_second_degree else PHASES
    phasor: dict[str, Complex] = scenario.force.amplitudes(section)
    total: Any = 0.0
    for turn in np.exp(2j * np.pi * np.arange(count) / count).tolist():
        waves = {name: np.real(amplitude * value * turn) for name, value in phasor.items()}
        total = total + attraction(scenario, total_pull(scenario, waves))
    return np.asarray(total / count)


def pressed(contact: Contact, load: Real, pull: Real) -> Real:
    """Compute the total contact force W = load + pull area(W), load and attraction on the area under that force.

    Of several states it is the one with the least force, which a slowly rising attraction reaches from the
    load alone. Where the mean pressure rises with the force there is only one state.
    """
    load, pull = np.broadcast_arrays(np.asarray(load, dtype=float), np.asarray(pull, dtype=float))
    if not contact.grows:
        return np.asarray(load + pull * contact.gross_area())
    whole = np.where(np.isnan(load + pull), np.nan, load)
    found = (load > 0) & (pull != 0) & np.isfinite(load + pull)
    if np.any(found):
        whole[found] = _least(contact, load[found], pull[found])
    return whole


def _least(contact: Contact, load: Real, pull: Real) -> Real:
    """Return the least force: above the load where the pull is positive, below it where it is negative."""

    def lacking(whole: Real, which: Any = slice(None)) -> Real:
        return np.asarray(whole - load[which] - pull[which] * contact.outline(whole))

    highest = np.maximum(load + pull * LARGEST, load * (1 + 1e-9))  # a faint pull is lost in rounding
    low, high = np.array(load), np.array(load)
    ratio = FAR if _one_state(contact, float(np.min(load)), float(np.max(highest))) else NEAR
    open_ = pull > 0
    while np.any(open_):
        low = np.where(open_, high, low)
        high = np.where(open_, np.minimum(ratio * high, highest), high)
        short = open_ & (lacking(high) < 0)
        if np.any(short & (high >= highest)):
            raise without_bound(contact, pull=float(np.max(pull[short])))
        open_ = short
    open_ = pull < 0
    while np.any(open_):
        high = np.where(open_, low, high)
        low = np.where(open_, low / FAR, low)
        open_ = open_ & (lacking(low) > 0) & (low > SMALLEST * load)
    return np.asarray(np.where(lacking(low) > 0, 0.0, _bracketed(lacking, low, high)))


def _one_state(contact: Contact, least: float, most: float) -> bool:
    """Return whether the mean contact pressure rises with the force between two forces [N]."""
    forces = np.geomspace(least, max(most, 2 * least), FORCES)
    return bool(np.all(np.diff(contact.mean_pressure(forces)) >= 0))


def _bracketed(function: Callable[[Real, Any], Real], low: Real, high: Real) -> Real:
    """Return the root of a function that is < 0 at `low` and >= 0 at `high`, by secants (Anderson and Bjoerck)."""
    root, left = np.array(high), np.arange(len(high))
    at_low, at_high = function(low, left), function(high, left)
    for step in range(MOST_STEPS):
        with np.errstate(invalid="ignore", divide="ignore"):
            middle = low - at_low * (high - low) / (at_high - at_low)
        halve = (step % HALVED == HALVED - 1) | ~((middle > low) & (middle < high))
        middle = np.where(halve, (low + high) / 2, middle)
        value = function(middle, left)
        right = value >= 0
        kept = np.where(right, at_high, at_low)  # the end that is replaced
        with np.errstate(invalid="ignore", divide="ignore"):
            share = 1 - value / kept
        share = np.where(share > 0, share, 0.5)
        at_low, at_high = np.where(right, at_low * share, value), np.where(right, value, at_high * share)
        low, high = np.where(right, low, middle), np.where(right, middle, high)
        root[left] = middle
        open_ = (np.abs(value) > np.spacing(high)) & (high - low > np.spacing(high))
        if not np.any(open_):
            break
        left = left[open_]
        low, high, at_low, at_high = (each[open_] for each in (low, high, at_low, at_high))
    return root


def pressed_states(contact: Contact, *, load: float, pull: float) -> tuple[tuple[float, bool], ...]:
    """Return all total contact forces in equilibrium under one load and one attraction.

    States are sought in steps of a 64th of the force; two states closer than that are missed.
    """
    if pull <= 0 or not contact.grows:
        return ((float(pressed(contact, np.array([load]), np.array([pull]))[0]), True),)

    def lacking(whole: Real) -> Real:
        return np.asarray(whole - load - pull * contact.outline(whole))

    return crossed(lacking, least=load, most=max(load + pull * LARGEST, load * (1 + 1e-9)))


def crossed(lacking: Callable[[Real], Real], *, least: float, most: float) -> tuple[tuple[float, bool], ...]:
    """Return the forces at which a function changes its sign, and whether it rises there."""
    count = max(2, int(np.ceil(np.log(most / least) / np.log(NEAR))) + 1)
    forces = np.geomspace(least, most, count)
    values = lacking(forces)
    places = np.flatnonzero((values[:-1] < 0) != (values[1:] < 0))
    found = []
    for place in places.tolist():
        rises = bool(values[place] < 0)
        sign = 1.0 if rises else -1.0
        ends = np.array([forces[place]]), np.array([forces[place + 1]])
        root = _bracketed(lambda whole, _, sign=sign: sign * lacking(whole), *ends)  # type: ignore[misc]
        found.append((float(root[0]), rises))
    return tuple(found)


def without_bound(contact: Contact, *, pull: float) -> InputError:
    """Return the error that an attraction lets the area of a contact grow without bound."""
    return InputError(
        f"contact = {type(contact).__name__}: under an attraction of {format_quantity(pull, 'Pa', digits=4)} the contact area"
        f" grows beyond {LARGEST:g} m2, that is without bound: the attraction grows with the area, and the mean contact"
        " pressure does not balance it. Lower the voltage, or contact.exponent (at 1 the pressure does not rise with the area)"
    )


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
