"""Validity of a result: its diagnostics, each with its value and limit, or why it could not be evaluated.

The largest values of a solution are found here, and judged: of films, air, skin, sweat and the declared limits.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
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
from electrovib.scenario.experiment import moisture_diagnostic
from electrovib.solve.choice import chosen, solve_fields
from electrovib.solve.diagnostics.assumptions import (
    contact_diagnostics,
    moving_gap,
    negative_attraction,
    over_frequency_diagnostics,
    settled_charge,
    vanishing_gap,
)
from electrovib.solve.diagnostics.closed_gap import with_closed_gap
from electrovib.solve.diagnostics.peaks import (
    PeakRecord,
    evaluation_times,
    joined,
    resolved,
)
from electrovib.solve.electrics.transient import caveat
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import FieldOf

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import Circuit
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Solution
    from electrovib.solve.stack.section import ModalSection

MET = 1e-6
"""Relative distance from a largest value within which it is reached: rounding, and the error of a time step."""
LESS = 0.01
"""Share of the asked voltage whose absence at the plate a bandwidth is named for; a choice."""
ROUNDED = 1e-9
"""Height of a discontinuity over the largest value of the drive, or distance from a limit over it, below which it is rounding."""


def watched(scenario: Scenario, section: ModalSection, times: Real, answer: Solution) -> PeakRecord:
    """Return the quantities with limits, from a response at closely spaced times.

    `times` (n,) [s].
    """
    record = PeakRecord.of(scenario, times, answer.found)
    if (method := chosen(scenario).method).is_marched and not method.by_regimes:
        return record

    corners = np.union1d(scenario.drive.corners(float(times[-1]))[0], answer.kinks)
    look = functools.partial(at_moments, scenario, section)
    whole = joined(record, np.setdiff1d(record.before_corners(corners), times), look)
    return whole if method.by_regimes else resolved(whole, look)


def at_moments(scenario: Scenario, section: ModalSection, times: Real) -> PeakRecord:
    """Return the quantities with limits at further times [s]."""
    return PeakRecord.of(scenario, times, solve_fields(scenario, section, times).found)


def judge_run(
    scenario: Scenario,
    section: ModalSection,
    record: PeakRecord,
    times: Real,
    variables: dict[str, Any],
    mean_squares: Mapping[str, float] | None = None,
) -> list[Diagnostic]:
    """Return the diagnostics of a run.

    `times` (n,) [s].
    """
    return [
        *scenario.force.diagnostics(scenario.stack.layers),
        *([] if scenario.drive.quantity == "voltage" else [caveat()]),
        *declared_diagnostics(scenario),
        *stack_diagnostics(scenario, record),
        *circuit_diagnostics(scenario, section, record, mean_squares),
        *settled_charge(scenario),
        *contact_diagnostics(scenario, variables, times),
        *moving_gap(scenario, variables),
        *vanishing_gap(scenario, times, variables),
        *negative_attraction(scenario, variables),
        *over_frequency_diagnostics(scenario),
    ]


def _running_currents(
    scenario: Scenario, section: ModalSection, record: PeakRecord
) -> dict[str, float] | None:
    """Return the largest currents apart from the response to the step of the drive at time 0."""
    end, drive = float(record.times[-1]), scenario.drive
    if chosen(scenario).method.is_marched or scenario.circuit.supply.is_limited:
        return None
    names = ("current", "body_current")
    try:
        if drive.period is not None:
            periodic = scenario.replace({"time.initial_state": {"model": "PeriodicState"}})
            wanted = evaluation_times(drive, end=end, settled=True)
            repeated = at_moments(periodic, section, wanted).peaks()
            return {name: repeated[name] for name in names}
        stepped = scenario.replace({"drive": {"model": "Step", "level": float(drive.voltage(0.0))}})
        records = [record] if record.whole is None else [record, record.whole]
        switched = [
            PeakRecord.of(scenario, each.times, solve_fields(stepped, section, each.times).found)
            for each in records
        ]
        rest = {
            name: np.concatenate(
                [each.rows[name] - alone.rows[name] for each, alone in zip(records, switched, strict=True)]
            )
            for name in names
        }
        return {name: float(np.max(np.abs(row))) for name, row in rest.items()}
    except InputError:
        return None


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
    until = max(end, drive.period or 0.0) if settled else end
    times, heights = drive.corners(until)
    if amplifier.saturation is not None:
        after = drive.voltage(times)
        passed = np.abs(amplifier.aim(after) - amplifier.aim(after - heights))
        heights = np.where(passed > ROUNDED * amplifier.saturation, heights, 0.0)
    later = float(np.max(np.abs(heights), initial=0.0))
    first = 0.0 if settled else abs(float(drive.voltage(0.0)))
    if not (first or later):
        return 0.0, 0.0
    smallest = ROUNDED * sum(part.bound() for part in drive.parts())
    return first * (first > smallest), later * (later > smallest)


def stack_diagnostics(scenario: Scenario, record: PeakRecord) -> list[Diagnostic]:
    """Return the diagnostics of every layer, of the interface and of the sweat in it."""
    peaks = record.peaks()
    nearest = record.nearest_to_breakdown() if "gap" in record.rows else None
    fields = {name: peaks[FieldOf(name)] for name in scenario.stack.layers}
    return layer_diagnostics(
        scenario,
        fields,
        interface=peaks["interface"],
        nearest=nearest,
        across=peaks["across"],
        supplied=supplied_voltages(scenario, record),
    )


def supplied_voltages(scenario: Scenario, record: PeakRecord) -> tuple[float, float]:
    """Return the lowest and the highest voltage between plate and finger that there can be [V], with 0 between them.

    A charged body counts, and may lose its charge. What a resistance, a bandwidth or a limit of current leaves of the voltage of
    the drive depends on the contact, which is not the declared one where the gap is closed; only the saturation of the amplifier
    counts.
    """
    end, drive = float(record.times[-1]), scenario.drive
    if drive.quantity == "current":
        reached = record.peaks()["voltage"]
        ends = [-reached, reached]
    else:
        until = max(end, drive.period or 0.0) if scenario.time.settled else end
        ends = [float(each) for each in scenario.circuit.supply.aim(drive.extremes(0.0, until))]
        stated = max(map(abs, ends))
        if (seen := _no_less(stated, record)) > stated:
            ends = [-seen, seen]
    body = scenario.circuit.element()
    ends += [each - body.elastance * body.charge for each in ends]
    return min(0.0, *ends), max(0.0, *ends)


def _no_less(stated: float, record: PeakRecord) -> float:
    """Return the largest voltage that a drive states, or the one that was met where its formula states too little."""
    met = float(np.max(np.abs(record.rows["voltage"])))
    return met if met > stated * (1 + MET) else stated


def layer_diagnostics(
    scenario: Scenario,
    fields: Mapping[str, float],
    *,
    interface: float,
    nearest: tuple[float, float] | None,
    across: float,
    supplied: tuple[float, float],
) -> list[Diagnostic]:
    """Return the diagnostics of layers, interface and sweat for given largest values at the first contact.

    Of two contacts the smaller is judged: both carry the same current, so its fields are larger by the ratio of the areas.
    Films are judged once more with the gap closed, under the range of voltages that are `supplied` [V].
    """
    roles, layers = scenario.stack.roles, scenario.stack.layers
    plate = [name for name, role in roles.items() if role == "plate"]
    finger = [name for name, role in roles.items() if role == "finger"]
    found: list[Diagnostic] = []
    ratio, where = _judged_contact(scenario)
    fields = {name: ratio * field for name, field in fields.items()}
    whole = in_one_piece(layers)
    films = [
        name
        for name, layer in whole.items()
        if name in plate or layer.breakdown_field is not None or layer.material.substance is not None
    ]
    found += [film_diagnostic(name, whole[name], field=fields[name]) for name in films]
    if nearest is not None:
        field, gap = nearest
        found.append(paschen_diagnostic(field=ratio * field, gap=gap))
    found.append(emission_diagnostic(field=ratio * interface, vanishing=nearest is None))
    found += [skin_diagnostic(name, voltage=fields[name] * whole[name].thickness) for name in finger]
    bound = {name: layers[name].material.bound_permittivity(np.array(1e3)).real for name in plate}
    blocking = sum(layers[name].thickness / float(bound[name]) for name in plate)
    if blocking:
        found.append(sweat_diagnostic(voltage=ratio * across, electrical_thickness=blocking))
    found = [replace(each, text=f"{each.text}{where}") for each in found] if where else found
    return [*found, *with_closed_gap(scenario, films, supplied)]


def _judged_contact(scenario: Scenario) -> tuple[float, str]:
    """Return the fields of the smaller contact over those of the first, and the words that name it where there are two."""
    second = Surroundings.of(scenario).second
    if second in (0, 1):
        return 1.0, ""
    name = "second" if second > 1 else "first"
    return max(1.0, second), f"; judged at the {name} contact, the smaller of the two"


def circuit_diagnostics(
    scenario: Scenario,
    section: ModalSection,
    record: PeakRecord,
    mean_squares: Mapping[str, float] | None = None,
) -> list[Diagnostic]:
    """Return the diagnostics of voltage, current, charge and energy, and of discontinuities of the drive."""
    reached = largest_values(scenario, section, record) | dict(mean_squares or {})
    if scenario.limits.slew_rate is not None:
        reached["slew_rate"] = slew_rate(scenario, float(record.times[-1]))
    first, later = discontinuities(scenario, end=float(record.times[-1]))
    amplified = scenario.circuit.amplifier is not None
    return [
        *limit_diagnostics(reached, scenario.limits, amplified=amplified),
        *_discontinuity(scenario, reached, first=first, later=later),
        *_amplifier(scenario, record, largest_of(reached, "voltage")),
    ]


def _amplifier(scenario: Scenario, record: PeakRecord, seen: float) -> list[Diagnostic]:
    """Return a warning where the amplifier meets one of its limits, or its bandwidth leaves less than it is asked for."""
    amplifier, drive = scenario.circuit.amplifier, scenario.drive
    if amplifier is None or drive.quantity == "current":
        return []
    asked = abs(amplifier.gain) * drive.largest(float(record.times[-1]))
    saturation, bandwidth = amplifier.saturation or math.inf, amplifier.bandwidth or math.inf
    (sink, source), current = amplifier.current_limits, (record.whole or record).rows["current"]
    back = "source_current" if amplifier.sink_current is None else "sink_current"
    limits = (
        ("saturation", saturation, "V", asked > saturation * (1 + ROUNDED)),
        ("source_current", source, "A", np.max(current) >= source * (1 - ROUNDED)),
        (back, -sink, "A", np.min(current) <= sink * (1 - ROUNDED)),
        ("bandwidth", bandwidth, "Hz", math.isfinite(bandwidth) and seen < (1 - LESS) * asked),
    )
    met = [f"{name} = {format_quantity(value, unit)}" for name, value, unit, is_met in limits if is_met]
    if not met:
        return []
    plate, whole = (format_quantity(each, "V", digits=3) for each in (seen, asked))
    sees = "follows late to" if plate == whole else f"sees up to {plate} of"
    text = (
        f"the amplifier limits: the plate {sees} the {whole} that the drive asks for, with"
        f" {' and '.join(dict.fromkeys(met))} of circuit.amplifier; 'electrovib check' tells what the drive asks of an amplifier"
    )
    return [Diagnostic("amplifier", "warning", text, asked, seen, "V")]


def largest_of(reached: Mapping[str, float], name: str) -> float:
    """Return the larger of the value of a limit over the run and at switch-on."""
    return max(reached[name], reached.get(name + SWITCH_ON, 0.0)) if name in reached else math.nan


def largest_currents(record: PeakRecord, largest: float) -> tuple[float, float]:
    """Return the largest current out of the amplifier and into it [A], both positive, of which the larger is known better."""
    row = (record.whole or record).rows["current"]
    found = float(np.max(row, initial=0.0)), float(-np.min(row, initial=0.0))
    top = max(found) if math.isfinite(largest) else min(found)  # a discontinuity of either sign has no bound
    return found[0] if found[0] < top else largest, found[1] if found[1] < top else largest


def largest_values(scenario: Scenario, section: ModalSection, record: PeakRecord) -> dict[str, float]:
    """Return the largest absolute values that the declared limits are compared with."""
    drive, circuit = scenario.drive, scenario.circuit
    end = float(record.times[-1])
    limited = type(scenario.limits).model_fields
    reached = {
        name: value for name, value in record.peaks().items() if isinstance(name, str) and name in limited
    }
    if drive.quantity == "voltage" and circuit.amplifier is None:
        reached["voltage"] = _no_less(drive.largest(end), record)
    elif drive.quantity == "voltage" and circuit.amplifier is not None:
        # the output of one pole or of a limited slope never passes its target, a parabola between times may
        target = float(np.max(np.abs(circuit.amplifier.aim([drive.largest(end)]))))
        reached["voltage"] = min(reached["voltage"], _no_less(target, record))
        (sink, source), current = circuit.amplifier.current_limits, record.rows["current"]
        supplied = source if np.max(current) >= -np.min(current) else -sink
        reached["current"] = min(reached["current"], supplied)
    first, later = discontinuities(scenario, end=end)
    running = _running_currents(scenario, section, record) if first else None
    if running is not None and circuit.element().resistance > 0:
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
