"""Diagnostics of the largest values of a solution: of films, air, skin, sweat and the declared limits."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.physics.drive.extremes import slew_of
from electrovib.physics.limits import SWITCH_ON, limit_diagnostics
from electrovib.physics.safety import (
    emission_diagnostic,
    film_diagnostic,
    paschen_diagnostic,
    skin_diagnostic,
    sweat_diagnostic,
)
from electrovib.physics.stack import in_one_piece
from electrovib.scenario.moisture import moisture_diagnostic
from electrovib.solve.diagnostics.peaks import PeakRecord
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.circuit import Circuit
    from electrovib.scenario import Scenario


ROUNDED = 1e-9
"""Height of a discontinuity over the largest value of the drive, below which it is rounding."""


def slew_rate(scenario: Scenario, end: float) -> float:
    """Return the largest rate of change of the drive times the gain, from time 0 to an end."""
    drive, amplifier = scenario.drive, scenario.circuit.supply
    if drive.quantity == "current":
        return math.nan
    settled = scenario.time.settled
    until = max(end, drive.period or 0.0) if settled else end
    return abs(amplifier.gain) * slew_of(drive, until, from_rest=not settled)


def discontinuities(scenario: Scenario, *, end: float) -> tuple[float, float]:
    """Return the heights of the discontinuities of the voltage that reach the stack."""
    drive, amplifier = scenario.drive, scenario.circuit.supply
    if drive.quantity == "current" or (
        amplifier.bandwidth is not None or np.isfinite(amplifier.current_limits[1])
    ):
        return 0.0, 0.0
    settled = scenario.time.settled
    smallest = ROUNDED * sum(part.bound() for part in drive.parts())
    until = max(end, drive.period or 0.0) if settled else end
    times, heights = drive.corners(until)
    if amplifier.saturation is not None:
        after = drive.voltage(times)
        passed = np.abs(amplifier.aim(after) - amplifier.aim(after - heights))
        heights = np.where(passed > ROUNDED * amplifier.saturation, heights, 0.0)
    later = float(np.max(np.abs(heights), initial=0.0))
    first = 0.0 if settled else abs(float(drive.voltage(0.0)))
    return first * (first > smallest), later * (later > smallest)


def stack_diagnostics(scenario: Scenario, record: PeakRecord) -> list[Diagnostic]:
    """Return the diagnostics of every layer, of the interface and of the sweat in it."""
    peaks = record.peaks()
    nearest = record.nearest_to_breakdown() if "gap" in record.rows else None
    fields = {name: peaks[FieldOf(name)] for name in scenario.stack.layers}
    return layer_diagnostics(
        scenario, fields, interface=peaks["interface"], nearest=nearest, across=peaks["across"]
    )


def layer_diagnostics(
    scenario: Scenario,
    fields: Mapping[str, float],
    *,
    interface: float,
    nearest: tuple[float, float] | None,
    across: float,
) -> list[Diagnostic]:
    """Return the diagnostics of layers, interface and sweat for given largest values at the first contact.

    Of two contacts the smaller is judged: both carry the same current, so its fields are larger by the ratio of the areas.
    """
    roles, layers = scenario.stack.roles, scenario.stack.layers
    plate = [name for name, role in roles.items() if role == "plate"]
    finger = [name for name, role in roles.items() if role == "finger"]
    found: list[Diagnostic] = []
    ratio, where = _judged_contact(scenario)
    fields = {name: ratio * field for name, field in fields.items()}
    whole = in_one_piece(layers)
    for name, layer in whole.items():
        if name in plate or layer.breakdown_field is not None or layer.material.substance is not None:
            found.append(film_diagnostic(name, layer, field=fields[name]))
    if nearest is not None:
        field, gap = nearest
        found.append(paschen_diagnostic(field=ratio * field, gap=gap))
    found.append(emission_diagnostic(field=ratio * interface, vanishing=nearest is None))
    found += [skin_diagnostic(name, voltage=fields[name] * whole[name].thickness) for name in finger]
    bound = {name: layers[name].material.bound_permittivity(np.array(1e3)).real for name in plate}
    blocking = sum(layers[name].thickness / float(bound[name]) for name in plate)
    if blocking:
        found.append(sweat_diagnostic(voltage=ratio * across, electrical_thickness=blocking))
    return [replace(each, text=f"{each.text}{where}") for each in found]


def _judged_contact(scenario: Scenario) -> tuple[float, str]:
    """Return the fields of the smaller contact over those of the first, and the words that name it where there are two."""
    second = Surroundings.of(scenario).second
    if second in (0, 1):
        return 1.0, ""
    name = "second" if second > 1 else "first"
    return max(1.0, second), f"; judged at the {name} contact, the smaller of the two"


def circuit_diagnostics(
    scenario: Scenario,
    record: PeakRecord,
    running: Mapping[str, float] | None,
    mean_squares: Mapping[str, float] | None = None,
) -> list[Diagnostic]:
    """Return the diagnostics of voltage, current, charge and energy, and of discontinuities of the drive."""
    reached = largest_values(scenario, record, running) | dict(mean_squares or {})
    if scenario.limits.slew_rate is not None:
        reached["slew_rate"] = slew_rate(scenario, float(record.times[-1]))
    first, later = discontinuities(scenario, end=float(record.times[-1]))
    amplified = scenario.circuit.amplifier is not None
    return [
        *limit_diagnostics(reached, scenario.limits, amplified=amplified),
        *_discontinuity(scenario, reached, first=first, later=later),
    ]


def largest_of(reached: Mapping[str, float], name: str) -> float:
    """Return the larger of the value of a limit over the run and at switch-on."""
    return max(reached[name], reached.get(name + SWITCH_ON, 0.0)) if name in reached else math.nan


def largest_values(
    scenario: Scenario, record: PeakRecord, running: Mapping[str, float] | None
) -> dict[str, float]:
    """Return the largest absolute values that the declared limits are compared with."""
    drive, circuit = scenario.drive, scenario.circuit
    end = float(record.times[-1])
    limited = type(scenario.limits).model_fields
    reached = {
        name: value for name, value in record.peaks().items() if isinstance(name, str) and name in limited
    }
    if drive.quantity == "voltage" and circuit.amplifier is None:
        reached["voltage"] = drive.largest(end)
    elif drive.quantity == "voltage" and circuit.amplifier is not None:
        # the output of one pole or of a limited slope never passes its target, a parabola between times may
        target = float(np.max(np.abs(circuit.amplifier.aim([drive.largest(end)]))))
        reached["voltage"] = min(reached["voltage"], target)
        (sink, source), current = circuit.amplifier.current_limits, record.rows["current"]
        supplied = source if np.max(current) >= -np.min(current) else -sink
        reached["current"] = min(reached["current"], supplied)
    first, later = discontinuities(scenario, end=end)
    if first and running is not None and circuit.element().resistance > 0:
        switched = {name: reached[name] for name in running if reached[name] > running[name] * (1 + ROUNDED)}
        reached |= {**running, **{f"{name}{SWITCH_ON}": value for name, value in switched.items()}}
    if first or later:
        names = [name if later else f"{name}{SWITCH_ON}" for name in _unbounded_currents(circuit)]
        reached |= dict.fromkeys(names, math.inf)
    return reached


def _unbounded_currents(circuit: Circuit) -> tuple[str, ...]:
    """Return the currents that have no bound at a discontinuity of the plate's voltage."""
    if circuit.element().resistance == 0:
        return ("current", "body_current")
    return ("current",) if circuit.supply.stray_capacitance > 0 else ()


def _discontinuity(
    scenario: Scenario, reached: Mapping[str, float], *, first: float, later: float
) -> list[Diagnostic]:
    if not first and not later:
        return []
    resistance = scenario.circuit.element().resistance
    when = "at time 0 only" if not later else "after time 0" if not first else "at time 0 and later"
    height = format_quantity(max(first, later), "V", digits=3)
    text = f"the drive has a discontinuity of up to {height}, {when}: right after it the current"
    unbounded = _unbounded_currents(scenario.circuit)
    bounded = next((name for name in ("current", "body_current") if name not in unbounded), None)
    if bounded is None:
        text += " has no bound, because there is no series resistance"
    else:
        shown = {
            name: format_quantity(value, "A", digits=3)
            for name, value in reached.items()
            if "current" in name and math.isfinite(value)
        }
        largest = shown[bounded]
        if (switched := shown.get(f"{bounded}{SWITCH_ON}")) is not None:
            largest = f"{switched} at time 0, {largest} apart from that"
        if unbounded:
            text += " into the stray capacitance has no bound, and that through the finger"
        text += (
            f" is bounded only by the series resistance of {format_quantity(resistance, 'ohm')} ({largest})"
        )
    text += "; give the drive the edge time of the real source, or let it start at 0 V"
    return [Diagnostic("discontinuity", "warning", text)]


def declared_diagnostics(scenario: Scenario) -> list[Diagnostic]:
    """Return the diagnostics that depend on what is declared alone, and hold under any drive: moisture, materials, grounding."""
    moist = moisture_diagnostic(scenario)
    found = [] if moist is None else [moist]
    for name, layer in scenario.stack.layers.items():
        found += layer.material.diagnostics(name)
    return [*found, *_return_path(scenario)]


def _return_path(scenario: Scenario) -> list[Diagnostic]:
    """Return a warning where the body is not grounded."""
    if type(scenario.circuit.return_path).__name__ != "Floating":
        return []
    text = "the body is not grounded: part of the voltage drops across the return path from body to ground"
    return [Diagnostic("return path", "warning", text)]
