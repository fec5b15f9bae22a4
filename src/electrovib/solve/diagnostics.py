"""How far a result can be believed: what is judged against which limit, and what could not be judged."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.lamps import Lamp
from electrovib.core.units import format_quantity
from electrovib.physics.contact import FixedArea
from electrovib.physics.drive.parts import Linear
from electrovib.physics.friction import BristleFriction
from electrovib.physics.safety import SMALLEST_PASCHEN_GAP, air_lamps, lamps, paschen_voltage, peak
from electrovib.solve.current import caveat
from electrovib.solve.electrical import Electrical, electrical
from electrovib.solve.equilibrium import pressed_states
from electrovib.solve.moisture import moisture_lamp
from electrovib.solve.sampling import sampling
from electrovib.solve.unknown import resting
from electrovib.solve.vanishing_gap import negative_attraction, vanishing_gap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.solve.scenario import Scenario
    from electrovib.solve.section import ModalSection
    from electrovib.solve.transfer import Real

MOST_CORNERS = 10_000
"""Corners of a drive at which a current is looked for beside the times that are asked for."""


def diagnostics(
    scenario: Scenario, section: ModalSection, answer: Electrical, times: Real, variables: dict[str, Any]
) -> list[Lamp]:
    """Judge a result before it is handed out.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    section : ModalSection
        Its stack as modes.
    answer : Electrical
        The electrical answer at the output times.
    times : ndarray, shape (n,)
        Output times [s].
    variables : dict
        Dimensions and values of the signals of the Trace, in their units.

    Returns
    -------
    list of Lamp
        Law, materials, layers from plate to finger, circuit, motion, sampling.
    """
    unseen = _peak_current_in_edges(scenario, section, answer, times)
    return [
        *_lamps(scenario, variables, unseen),
        *_off_the_plate(scenario, times),
        *_at_rest(scenario, variables),
        *_contact(scenario, variables, times),
        *_moving_gap(scenario, variables),
        *vanishing_gap(scenario, times, variables),
        *negative_attraction(scenario, variables),
        *sampling(scenario.drive, times),
    ]


def _peak_current_in_edges(
    scenario: Scenario, section: ModalSection, answer: Electrical, times: Real
) -> float:
    """Largest current [A] at the corners of the drive and between them, where a closed form tells it for little."""
    if answer.choice["solver"] not in {"transient", "periodic"} or len(times) < 2:
        return 0.0
    corners = scenario.drive.corners(float(times[-1]))[0]
    corners = np.unique(np.append(corners, 0.0))
    corners = corners[(corners >= times[0]) & (corners <= times[-1])][:MOST_CORNERS]
    moments = np.unique(np.concatenate([corners, (corners[1:] + corners[:-1]) / 2]))
    if not len(moments):
        return 0.0
    found = electrical(scenario, section, moments).found
    return peak(found.get("amplifier_current", found["current"]))


def _lamps(scenario: Scenario, variables: dict[str, Any], unseen: float) -> list[Lamp]:
    layers, voltage = scenario.stack.layers, scenario.drive.quantity == "voltage"
    spoken = [*scenario.force.lamps(layers), *([] if voltage else [caveat()])]
    moist = moisture_lamp(scenario)
    spoken += [] if moist is None else [moist]
    for name, layer in layers.items():
        spoken += layer.material.lamps(name)
    peaks = {name: peak(row) for name, row in zip(layers, variables["field"][1], strict=True)}
    thicknesses = {name: layer.thickness for name, layer in layers.items()}
    if "gap" in variables:
        place = list(layers).index(str(scenario.stack.gap_name))
        thicknesses["gap"], peaks["gap"] = _nearest_to_breakdown(variables, place)
    insulator = layers.get("insulator")
    permittivity = insulator.material.polarisation(np.array(1e3)).real if insulator else None
    amplifier, given = scenario.circuit.amplifier, "amplifier_current" in variables
    softened = amplifier is not None and (amplifier.bandwidth is not None or amplifier.is_limited)
    jumps = any(isinstance(p, Linear) and _jumps(p) for p in scenario.drive.parts())
    judged = lamps(
        peak_fields=peaks,
        thicknesses=thicknesses,
        breakdown_fields={name: layer.breakdown_field for name, layer in layers.items()},
        peak_current=max(unseen, peak(variables["amplifier_current" if given else "current"][1])),
        current_of="plate, stray capacitance and finger" if given else "the contact",
        jumps=voltage and jumps and not softened,
        peak_voltage=peak(variables["stack_voltage"][1]),
        insulator_permittivity=None if permittivity is None else float(permittivity),
        limits=scenario.limits,
        return_path=type(scenario.circuit.return_path).__name__,
    )
    if "gap" in variables:  # the field is not largest where Paschen's law is nearest
        largest = peak(variables["interface_field"][1])
        emission = air_lamps(largest, thicknesses["gap"])[-1]
        judged = [emission if lamp.name == emission.name else lamp for lamp in judged]
    return spoken + judged


def _off_the_plate(scenario: Scenario, times: Real) -> list[Lamp]:
    """Say that nothing rubs off the plate, and warn of a load there."""
    off = ~scenario.motion.touches(times)
    if not np.any(off):
        return []
    found = [
        Lamp(
            "off the plate",
            "ok",
            f"the finger is off the plate at {_share(off)} of the times: no friction there",
        )
    ]
    if np.any(scenario.load.forces(times)[off] > 0):
        text = "presses while the finger is held off the plate, where nothing bears it: set it to 0, or give load.programme"
        found.append(Lamp("load off the plate", "warning", f"load.normal_force {text}"))
    return found


def _at_rest(scenario: Scenario, variables: dict[str, Any]) -> list[Lamp]:
    """Say what is not known of friction and lateral reading, or what stands for it, where the finger rests."""
    motion, spans = scenario.motion, resting(scenario.motion)
    if not spans:
        return []
    still = "motion.speed = 0" if not motion.speed else "motion.programme gives a speed of 0"
    if isinstance(scenario.friction, BristleFriction):
        text = f"the finger rests ({still}): the friction is what its bristles hold"
        return [Lamp("friction at rest", "ok", text)]
    if scenario.finger is not None:
        text = (
            f"the finger rests ({still}): the friction is what the spring of the skin holds, none where it has not slid"
            " before; mass and damper of the skin are left out of that"
        )
        return [Lamp("friction at rest", "ok", text)]
    missing = [
        f"{name.replace('_', ' ')} at {_share(unknown)} of the times"
        for name in ("lateral_force", "lateral_force_measured")
        if name in variables and np.any(unknown := np.isnan(variables[name][1]))
    ]
    if not missing:
        return []
    text = (
        f"not known: {' and '.join(missing)}. The finger rests ({still}), where friction is not determined by a law of"
        " sliding, and a memory behind it has to forget that first. Give it a finger, whose spring tells it, a friction"
        " of bristles, or another motion.speed"
    )
    return [Lamp("friction at rest", "unknown", text)]


def _contact(scenario: Scenario, variables: dict[str, Any], times: Real) -> list[Lamp]:
    """Say which area a contact that grows has, which one the circuit saw, and whether there are other states."""
    contact, circuit = scenario.contact, scenario.contact_area
    if isinstance(contact, FixedArea):
        return []
    area = variables["gross_contact_area"][1]
    low, high = (format_quantity(float(edge), "m2", digits=4) for edge in (np.min(area), np.max(area)))
    ratio = float(np.max(area)) / circuit
    text = (
        f"load and attraction make an outline of {low} to {high} together; charge and current are those of the"
        f" {format_quantity(circuit, 'm2', digits=4)} under the full load alone"
    )
    found = [Lamp("contact area", "ok" if 0.99 < ratio < 1.01 else "unknown", text, ratio, 1.01, "1")]
    force = variables["electrostatic_force"][1]
    worst = int(np.argmax(np.where(scenario.motion.touches(times), force, -np.inf)))
    load = float(scenario.load.forces(times)[worst])
    if not (load > 0 and force[worst] > 0 and area[worst] > 0):
        return found
    states = pressed_states(contact, load, float(force[worst] / area[worst]))
    if len(states) > 1:
        listed = ", ".join(
            f"{format_quantity(whole - load, 'N', digits=4)}{'' if stable else ' (not stable)'}"
            for whole, stable in states
        )
        text = (
            f"at {format_quantity(float(times[worst]), 's')} load and attraction balance in {len(states)} states, with an"
            f" attraction of {listed}; used is the first, which a slowly rising attraction reaches from the load alone"
        )
        found.append(Lamp("contact states", "unknown", text))
    return found


def _share(found: NDArray[np.bool_]) -> str:
    return "all" if np.all(found) else f"{100 * float(np.mean(found)):.3g} %"


def _moving_gap(scenario: Scenario, variables: dict[str, Any]) -> list[Lamp]:
    """Say what the declared thickness of a gap that moves is used for."""
    if "gap" not in variables:
        return []
    low, high = (
        format_quantity(float(edge(variables["gap"][1])), "m", digits=3) for edge in (np.min, np.max)
    )
    declared = format_quantity(scenario.stack.layers[str(scenario.stack.gap_name)].thickness, "m")
    text = (
        f"the gap is {low} to {high} over time; over frequency, and as drawn, it is the declared {declared}"
    )
    return [Lamp("moving gap", "ok", text)]


def _nearest_to_breakdown(variables: dict[str, Any], place: int) -> tuple[float, float]:
    """Gap [m] and field [V/m] at the moment at which a moving gap is nearest to Paschen's breakdown."""
    gap, field = variables["gap"][1], np.abs(variables["field"][1][place])
    held = np.array([paschen_voltage(max(each, SMALLEST_PASCHEN_GAP)) for each in gap.tolist()])
    worst = int(np.argmax(field * gap / held))
    return float(gap[worst]), float(field[worst])


def _jumps(part: Linear) -> bool:
    heights = np.abs(part.after - part.before)[: -1 if part.period else None]
    return bool(np.any(heights > 1e-9 * max(math.ulp(1.0), float(np.max(np.abs(part.after))))))
