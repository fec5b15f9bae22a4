"""Diagnostics of contact and friction: off the plate, at rest, and where a contact has several states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.physics.contact import FixedArea
from electrovib.physics.friction import BristleFriction
from electrovib.solve.electrics.pressed import pressed_states
from electrovib.solve.mechanics.lateral import resting

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario


def contact_diagnostics(scenario: Scenario, variables: dict[str, Any], times: Real) -> list[Diagnostic]:
    """Return the diagnostics of contact and friction.

    `times` (n,) [s].
    """
    return [
        *_off_the_plate(scenario, times),
        *_at_rest(scenario, variables),
        *_contact(scenario, variables, times),
    ]


def _off_the_plate(scenario: Scenario, times: Real) -> list[Diagnostic]:
    """Return that there is no friction off the plate, and a warning of a load there."""
    off = ~scenario.motion.touches(times)
    if not np.any(off):
        return []
    found = [
        Diagnostic(
            "off the plate",
            "ok",
            f"the finger is off the plate at {_share(off)} of the times: no friction there",
        )
    ]
    if np.any(scenario.load.forces(times)[off] > 0):
        text = (
            "load.normal_force is above 0 while the finger is off the plate, where no contact carries it: set it to 0 at"
            " these times with load.time_profile"
        )
        found.append(Diagnostic("load off the plate", "warning", text))
    return found


def _at_rest(scenario: Scenario, variables: dict[str, Any]) -> list[Diagnostic]:
    """Return which friction and lateral reading are unknown where the finger rests, or what determines them."""
    motion, spans = scenario.motion, resting(scenario.motion)
    if not spans:
        return []
    still = "motion.speed = 0" if not motion.speed else "motion.time_profile gives a speed of 0"
    if isinstance(scenario.friction, BristleFriction):
        text = f"the finger rests ({still}): the friction is the force that the bristles of the friction law hold"
        return [Diagnostic("friction at rest", "ok", text)]
    if scenario.finger is not None:
        text = (
            f"the finger rests ({still}): the friction is the force that the spring of the skin holds, 0 before the first"
            " sliding; mass and damper of the skin are neglected there"
        )
        return [Diagnostic("friction at rest", "ok", text)]
    missing = [
        f"{name.replace('_', ' ')} at {_share(unknown)} of the times"
        for name in ("lateral_force", "lateral_force_measured")
        if name in variables and np.any(unknown := np.isnan(variables[name][1]))
    ]
    if not missing:
        return []
    text = (
        f"not known: {' and '.join(missing)}. The finger rests ({still}), where a law of sliding friction does not determine"
        " the friction, and the output of a filter behind it stays unknown until the effect of the rest has decayed. Declare a"
        " finger, whose spring determines the friction, a friction with bristles, or another motion.speed"
    )
    return [Diagnostic("friction at rest", "unknown", text)]


def _contact(scenario: Scenario, variables: dict[str, Any], times: Real) -> list[Diagnostic]:
    """Return the area of a contact that depends on the load, the area of the circuit, and any other states."""
    contact, circuit = scenario.contact, scenario.contact_area
    if isinstance(contact, FixedArea):
        return []
    area = variables["gross_contact_area"][1]
    low, high = (format_quantity(float(edge), "m2", digits=4) for edge in (np.min(area), np.max(area)))
    ratio = float(np.max(area)) / circuit
    text = (
        f"under load and attraction the gross contact area is {low} to {high}; charge and current are computed with"
        f" the {format_quantity(circuit, 'm2', digits=4)} under the full load alone"
    )
    found = [Diagnostic("contact area", "ok" if 0.99 < ratio < 1.01 else "unknown", text, ratio, 1.01, "1")]
    force = variables["electrostatic_force"][1]
    worst = int(np.argmax(np.where(scenario.motion.touches(times), force, -np.inf)))
    load = float(scenario.load.forces(times)[worst])
    if not (load > 0 and force[worst] > 0 and area[worst] > 0):
        return found
    states = pressed_states(contact, load=load, pull=float(force[worst] / area[worst]))
    if len(states) > 1:
        listed = ", ".join(
            f"{format_quantity(whole - load, 'N', digits=4)}{'' if stable else ' (not stable)'}"
            for whole, stable in states
        )
        text = (
            f"at {format_quantity(float(times[worst]), 's')} load and attraction balance in {len(states)} states, with an"
            f" attraction of {listed}; the result uses the first, which a slowly rising attraction reaches from the load"
            " alone"
        )
        found.append(Diagnostic("contact states", "unknown", text))
    return found


def _share(found: NDArray[np.bool_]) -> str:
    return "all" if np.all(found) else f"{100 * float(np.mean(found)):.3g} %"
