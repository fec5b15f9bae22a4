"""How far a result can be believed: what is judged against which limit, and what could not be judged."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.lamps import Lamp
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Linear
from electrovib.physics.safety import SMALLEST_PASCHEN_GAP, air_lamps, lamps, paschen_voltage, peak
from electrovib.solve.current import caveat
from electrovib.solve.electrical import Electrical, electrical
from electrovib.solve.moisture import moisture_lamp
from electrovib.solve.sampling import sampling
from electrovib.solve.vanishing_gap import negative_attraction, vanishing_gap

if TYPE_CHECKING:
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
    """Warn of a load, and so of friction, while the finger does not touch."""
    distance = scenario.motion.distance
    if distance is None or not np.any(scenario.load.forces(times)[~distance.touches(times)] > 0):
        return []
    text = "presses while the finger is held off the plate, and makes friction there: set it to 0, or give load.programme"
    return [Lamp("load off the plate", "warning", f"load.normal_force {text}")]


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
