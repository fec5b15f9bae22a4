"""One scenario, one Trace. The solver follows from what the models declare, never from an option."""

from __future__ import annotations

import functools
import json
import math
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.lamps import Lamp
from electrovib.core.trace import make_trace
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Linear
from electrovib.physics.safety import SMALLEST_PASCHEN_GAP, air_lamps, lamps, paschen_voltage, peak
from electrovib.solve.current import caveat
from electrovib.solve.electrical import Electrical, electrical
from electrovib.solve.expand import behind_amplifier, mean_force, modes, per_volt_of, phasors
from electrovib.solve.mechanical import mechanical
from electrovib.solve.moisture import moisture_lamp
from electrovib.solve.sampling import sampling
from electrovib.solve.scenario import Scenario
from electrovib.solve.section import ModalSection, PhasorSection
from electrovib.solve.steps import marks_of
from electrovib.solve.transfer import Real

if TYPE_CHECKING:
    import xarray

    from electrovib.physics.force import ForceLaw

MOST_CORNERS = 10_000
"""Corners of a drive at which a current is looked for beside the times that are asked for."""


def simulate(scenario: Scenario, *, time: Real | None = None) -> xarray.Dataset:
    """Compute what the drive does to the finger.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    time : ndarray, shape (n,), optional
        Increasing, >= 0 [s]; by default what the scenario's time grid says.

    Returns
    -------
    xarray.Dataset
        A Trace: signals over time and over frequency, with solver, reason, errors, lamps and the scenario
        itself in its attributes.

    Raises
    ------
    NotCausalError
        If the force law has no response in time but the drive is not one sine in its steady state.
    InputError
        If the force law does not find the layers it needs, or models do not go together.

    Notes
    -----
    Linear layers: the modes of the stack under voltage drive, those of each layer under current drive, marched
    exactly. A layer with a leak: one nonlinear branch with its error in `step_error`; over frequency the leak
    counts as the conductivity that a vanishing sine sees.
    """
    times = scenario.time.times(scenario.drive) if time is None else np.asarray(time, dtype=float)
    frequency = scenario.frequency.frequencies()
    at_frequency = phasors(scenario, frequency)
    section, reduction_error = modes(scenario)
    attributes = _provenance(scenario)
    attributes["reduction_error"] = reduction_error
    answer = electrical(scenario, section, times)
    if scenario.force.causal:
        bare = phasors(scenario, frequency, leaks=False)
        attributes["transfer_error"] = _transfer_error(scenario.force, section, bare)
    moved = mechanical(
        scenario, times, answer, functools.partial(electrical, scenario, section, force_alone=True)
    )
    attributes |= answer.choice | moved.how
    variables: dict[str, Any] = {
        **answer.signals(section),
        **moved.signals,
        **_over_frequency(scenario, at_frequency),
    }
    unseen = _peak_current_in_edges(scenario, section, answer, times)
    spoken = [
        *_lamps(scenario, variables, unseen),
        *moved.lamps,
        *_off_the_plate(scenario, times),
        *_moving_gap(scenario, variables),
        *sampling(scenario.drive, times),
    ]
    attributes["lamps"] = json.dumps([lamp.to_dict() for lamp in spoken])
    coordinates = {
        "time": times,
        "frequency": frequency,
        "layer": np.array(list(section.layers), dtype=object),
    }
    return make_trace(variables, coordinates, attributes)


def _provenance(scenario: Scenario) -> dict[str, Any]:
    return {
        "title": scenario.title,
        "electrovib": version("electrovib"),
        "scenario": scenario.to_json(),
        "scenario_hash": scenario.digest(),
        "dropped_samples": getattr(scenario.drive, "dropped", 0),
    }


def _over_frequency(scenario: Scenario, section: PhasorSection) -> dict[str, Any]:
    area = scenario.contact_area
    plate = per_volt_of(scenario, section.frequency)
    per_volt = behind_amplifier(scenario, plate)
    section = behind_amplifier(scenario, section)
    variables: dict[str, Any] = {}
    effective = scenario.force.effective_voltage(per_volt)
    if effective is not None:
        variables["effective_voltage_gain"] = (("frequency",), effective)
    layers = per_volt.layers.values()
    gains = np.array([state.field * state.thickness for state in layers])
    permittivities = np.array([state.material.complex_permittivity(section.frequency) for state in layers])
    variables["field_gain"] = (("layer", "frequency"), gains)
    variables["mean_force"] = (("frequency",), mean_force(scenario, section, _peak_value(scenario)))
    variables["impedance"] = (("frequency",), 1 / (plate.current_density * area))
    variables["permittivity"] = (("layer", "frequency"), permittivities)
    return variables


def _peak_value(scenario: Scenario) -> float:
    drive = scenario.drive
    grid = np.linspace(0, drive.duration, 4001)
    corners = [np.abs(np.concatenate([p.before, p.after])) for p in drive.parts() if isinstance(p, Linear)]
    return max([peak(drive.voltage(grid)), *(float(c.max()) for c in corners if len(drive.parts()) == 1)])


def _transfer_error(law: ForceLaw, section: ModalSection, exact: PhasorSection) -> float:
    """Largest error of the law's amplitudes after reduction, against their largest magnitude, where known."""
    reduced, declared = law.amplitudes(section), law.amplitudes(exact)
    bands = [layer.material.band for layer in exact.layers.values()]
    known = (exact.frequency >= max(low for low, _ in bands)) & (
        exact.frequency <= min(high for _, high in bands)
    )
    if not np.any(known):
        return math.nan
    errors = []
    for name, value in declared.items():
        scale = float(np.max(np.abs(value)))
        difference = reduced[name].at(exact.frequency[known]) - value[known]
        errors.append(float(np.max(np.abs(difference))) / (scale or 1.0))
    return max(errors)


def _peak_current_in_edges(
    scenario: Scenario, section: ModalSection, answer: Electrical, times: Real
) -> float:
    """Largest current [A] at the corners of the drive and between them, where a closed form tells it for little."""
    if answer.choice["solver"] not in {"transient", "periodic"} or len(times) < 2:
        return 0.0
    corners = marks_of(scenario.drive, float(times[-1]))[0]
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
        thicknesses["gap"], peaks["gap"] = _nearest_to_breakdown(variables, list(layers).index("gap"))
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
        largest = peak(variables["field"][1][list(layers).index("gap")])
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
    declared = format_quantity(scenario.stack.layers["gap"].thickness, "m")
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
