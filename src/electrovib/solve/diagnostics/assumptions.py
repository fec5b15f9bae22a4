"""Diagnostics of what a run assumes: contact and friction, the gap, a settled charge, values over frequency, output times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.physics.drive.extremes import FEWEST, ROUNDING, enough, fastest_frequency, shows
from electrovib.solve.electrics.attraction import pressed_states
from electrovib.solve.electrics.solution import STRETCH
from electrovib.solve.mechanics.lateral import resting
from electrovib.solve.rough_contact.solved import solved_contact
from electrovib.solve.stack.expand import behind_amplifier, per_volt_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario

SMALLEST_GAP: Final = 1e-9
"""Smallest real gap considered [m]: about the roughness of the smoothest plates; a choice."""
LARGEST_SHARE: Final = 0.01
"""Share of the voltage across that gap above which the limit does not describe it; a choice."""
_ROUNDING = 1e-9
"""Negative attraction over the largest absolute one, below which it is rounding."""
SETTLED_CHARGE: Final = "settled charge"
LONGEST_RELAXATION: Final = 100.0
"""Charge relaxation time that an experiment with one drive hardly exceeds [s]; a choice."""
SMALLEST_MEAN: Final = 1e-3
"""Mean over largest voltage below which a drive counts as free of an offset; a choice."""
_SAMPLES: Final = 4096
_TWO_SIGNS: Final = np.array([-1e-12, 1e-12])
"""Fields at which the two slopes of a leak are compared [V/m]."""
MOST: Final = 4_000_000
"""Samples beyond which no number of even times is advised."""


def contact_diagnostics(scenario: Scenario, variables: dict[str, Any], times: Real) -> list[Diagnostic]:
    """Return the diagnostics of contact and friction.

    `times` (n,) [s].
    """
    return [
        *_off_the_plate(scenario, times),
        *_at_rest(scenario, variables, times),
        *_several_states(scenario, variables, times),
        *_real_contact(scenario, variables),
    ]


def _real_contact(scenario: Scenario, variables: dict[str, Any]) -> tuple[Diagnostic, ...]:
    """Return how a rough contact was solved, or how large the error of a law of it is."""
    if (solved := solved_contact(scenario)) is not None:
        force = variables["electrostatic_force"][1]
        return solved.diagnostics(float(np.max(force, initial=0.0)) / scenario.contact_area)
    surface = scenario.contact.surface
    if surface is None or "real_contact_area" not in variables:
        return ()
    real, gross = (np.ravel(variables[f"{name}_contact_area"][1]) for name in ("real", "gross"))
    ends = list[float]()
    for at in range(0, real.size, STRETCH):  # a long record would take memory for each step of this
        share = real[at : at + STRETCH] / np.maximum(gross[at : at + STRETCH], np.finfo(float).tiny)
        touching = share[share > 0]
        ends += [float(touching.min()), float(touching.max())] if touching.size else []
    return surface.diagnostics(np.array(ends))


def _off_the_plate(scenario: Scenario, times: Real) -> list[Diagnostic]:
    """Return that there is no friction off the plate, and a warning of a load there."""
    off = ~scenario.motion.touches(times)
    if not np.any(off):
        return []
    found = [
        Diagnostic(
            "off the plate",
            "ok",
            f"the finger is off the plate for {_share(off, times)} of the time: no friction there",
        )
    ]
    if np.any(scenario.load.forces(times)[off] > 0):
        text = (
            "load.normal_force is above 0 while the finger is off the plate, where no contact carries it: set it to 0 at"
            " these times with load.time_profile"
        )
        found.append(Diagnostic("load off the plate", "warning", text))
    return found


def _at_rest(scenario: Scenario, variables: dict[str, Any], times: Real) -> list[Diagnostic]:
    """Return which friction and lateral reading are unknown where the finger rests, or what determines them."""
    motion, spans = scenario.motion, resting(scenario.motion)
    if not spans:
        return []
    still = "motion.speed = 0" if not motion.speed else "motion.time_profile gives a speed of 0"
    if scenario.friction.deflects:
        text = f"the finger rests ({still}): the friction is the force that the bristles of the friction law hold"
        return [Diagnostic("friction at rest", "ok", text)]
    if scenario.finger is not None:
        text = (
            f"the finger rests ({still}): the friction is the force that the spring of the skin holds, 0 before the first"
            " sliding; mass and damper of the skin are neglected there"
        )
        return [Diagnostic("friction at rest", "ok", text)]
    missing = [
        f"{name.replace('_', ' ')} for {_share(unknown, times)} of the time"
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


def _several_states(scenario: Scenario, variables: dict[str, Any], times: Real) -> list[Diagnostic]:
    """Return the area of a contact that depends on the load, the area of the circuit, and any other states."""
    contact, circuit = scenario.contact, scenario.contact_area
    if not contact.grows:
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


def _share(found: NDArray[np.bool_], times: Real) -> str:
    """Write for which part of a run something holds: the times of a sweep lie closest where most happens."""
    if np.all(found) or len(times) < 2:
        return "all" if np.all(found) else "none"
    held = np.trapezoid(found.astype(float), times) / (times[-1] - times[0])
    return f"{100 * float(held):.3g} %"


def moving_gap(scenario: Scenario, variables: dict[str, Any]) -> list[Diagnostic]:
    """Return the range of a moving gap, and what its declared thickness is used for."""
    if "gap" not in variables:
        return []
    low, high = (
        format_quantity(float(edge(variables["gap"][1])), "m", digits=3) for edge in (np.min, np.max)
    )
    declared = format_quantity(scenario.stack.layers[str(scenario.stack.gap_name)].thickness, "m")
    text = (
        f"the gap varies from {low} to {high} in time; quantities over frequency and the drawing of the stack use the"
        f" declared {declared}"
    )
    return [Diagnostic("moving gap", "ok", text)]


def vanishing_gap(scenario: Scenario, times: Real, variables: dict[str, Any]) -> list[Diagnostic]:
    """Return whether the limit of a vanishing gap describes the smallest real gap.

    `times` (n,) [s].

    A gap g has the voltage E g across it. While that is a small share of the whole voltage, a smaller gap has the same
    field; over a conducting plate E grows as long as the voltage is held.
    """
    if scenario.stack.gap_name is not None or scenario.force.evaluation_surface != "gap":
        return []
    name, gap = "vanishing gap", format_quantity(SMALLEST_GAP, "m")
    add = "add a layer with role = 'gap' to the stack, for instance stack.gap.thickness = '1 um'"
    if "interface_field" not in variables:
        text = f"the field of a vanishing gap is not known, so the limit was not compared with a gap of {gap}: {add}"
        return [Diagnostic(name, "unknown", text)]
    field, voltage = (np.abs(variables[each][1]) for each in ("interface_field", "stack_voltage"))
    reached = np.maximum.accumulate(voltage)
    share = np.divide(field * SMALLEST_GAP, reached, out=np.zeros_like(field), where=reached > 0)
    worst = float(np.max(share, initial=0.0))
    beyond = np.flatnonzero(share > LARGEST_SHARE)
    said = f"a gap of {gap} would have {100 * worst:.3g} % of the voltage across it"
    if len(beyond):
        since = format_quantity(float(times[beyond[0]]), "s", digits=3)
        text = (
            f"{said}, and more than {100 * LARGEST_SHARE:g} % from {since} on: from then on the force is larger than that of"
            f" any real gap; {add}"
        )
        return [Diagnostic(name, "warning", text, worst, LARGEST_SHARE, "1")]
    text = f"the stack has no gap: the force is the limit of a vanishing gap; {said} at most"
    return [Diagnostic(name, "ok", text, worst, LARGEST_SHARE, "1")]


def negative_attraction(scenario: Scenario, variables: dict[str, Any]) -> list[Diagnostic]:
    """Return a warning where the attraction is negative, with the reason that the force law declares."""
    force = variables["electrostatic_force"][1]
    lowest, largest = float(np.min(force)), float(np.max(np.abs(force)))
    if not lowest < -_ROUNDING * largest:
        return []
    law = scenario.force
    why = law.negative or f"{type(law).__name__} does not declare why its pressure may be negative"
    text = f"the attraction falls to {format_quantity(lowest, 'N', digits=3)}: {why}"
    return [Diagnostic("negative attraction", "warning", text, -lowest, 0.0, "N")]


def settled_charge(scenario: Scenario) -> list[Diagnostic]:
    """Warn where a layer of the plate conducts so little that the periodic state is reached long after an experiment.

    Over a gap that does not conduct, the mean of the voltage is across the gap once the charge in a
    conducting layer has relaxed, in a time of the order of the permittivity over the conductivity.
    """
    if not scenario.time.settled or scenario.drive.quantity != "voltage":
        return []
    roles = scenario.stack.roles
    times = {
        name: _relaxation_time(layer)
        for name, layer in scenario.stack.layers.items()
        if roles[name] == "plate"
    }
    slow = {name: time for name, time in times.items() if LONGEST_RELAXATION < time < np.inf}
    if not slow or not (mean := _held_mean(scenario.drive)):
        return []
    name = max(slow, key=lambda each: slow[each])
    text = (
        f"the periodic state assumes that the mean of {format_quantity(mean, 'V', digits=3)} has been held for longer than the"
        f" charge relaxation time of '{name}', {format_quantity(slow[name], 's', digits=3)}; for a shorter experiment set"
        f" stack.{name}.material.conductivity = 0, or time.initial_state.model = AtRest"
    )
    return [Diagnostic(SETTLED_CHARGE, "warning", text, slow[name], LONGEST_RELAXATION, "s")]


def _relaxation_time(layer: Layer) -> float:
    """Charge relaxation time of a layer [s]; infinite without conduction."""
    sigma = layer.material.conductivity
    return eps0 * float(layer.material.bound_permittivity(np.array(1e3)).real) / sigma if sigma else np.inf


def _held_mean(drive: Drive) -> float:
    """Mean voltage of a drive over its period, or its voltage if it is held [V]; 0 where it is small."""
    length = drive.period or drive.duration or 1.0
    mean = float(np.mean(drive.voltage((np.arange(_SAMPLES) + 0.5) / _SAMPLES * length)))
    return mean if abs(mean) > SMALLEST_MEAN * drive.largest() else 0.0


def over_frequency_diagnostics(scenario: Scenario) -> list[Diagnostic]:
    """Return warnings where the values over frequency are not those of a sine in time."""
    leaks = {name: layer.leak for name, layer in scenario.stack.layers.items() if layer.leak is not None}
    amplifier = scenario.circuit.supply
    return [
        *(_rectifies(name) for name, leak in leaks.items() if np.ptp(leak.slope(_TWO_SIGNS))),
        *(_not_supplied(scenario, amplifier) if amplifier.is_limited else []),
    ]


def _rectifies(name: str) -> Diagnostic:
    text = (
        f"values over frequency: '{name}' counts with the mean of its two conductivities. A rectifying layer that no direct"
        " current passes charges until its mean current is 0, and the constant field of that charge is missing from the mean"
        " force and the gains, at any amplitude; use the response in time"
    )
    return Diagnostic(f"over frequency, {name}", "warning", text)


def _not_supplied(scenario: Scenario, amplifier: Amplifier) -> list[Diagnostic]:
    """Return a warning if a sine of the drive's peak voltage exceeds a limit of the amplifier at some frequency."""
    frequency, peak = scenario.frequency.frequencies(), scenario.drive.largest()
    section = behind_amplifier(scenario, per_volt_of(scenario, frequency))
    pole = 1.0 if amplifier.bandwidth is None else 1 + 1j * frequency / amplifier.bandwidth
    stray = 2j * np.pi * frequency * amplifier.stray_capacitance * amplifier.gain / pole
    current = peak * np.abs(section.current_density * scenario.contact_area + stray)
    found = []
    voltage = abs(amplifier.gain) * peak
    if amplifier.saturation is not None and voltage > amplifier.saturation:
        reached, limit = format_quantity(voltage, "V", digits=3), format_quantity(amplifier.saturation, "V")
        found.append(f"the drive times the gain reaches {reached}, above the saturation of {limit}")
    largest = min(-amplifier.current_limits[0], amplifier.current_limits[1])
    if np.any(current > largest):
        first = format_quantity(float(frequency[current > largest][0]), "Hz", digits=3)
        reached, limit = format_quantity(float(np.max(current)), "A", digits=3), format_quantity(largest, "A")
        found.append(f"the current reaches {reached}, above {limit}, from {first} on")
    if not found:
        return []
    text = (
        f"values over frequency: the mean force is that of a sine which the amplifier does not supply: {' and '.join(found)};"
        " its limits are not part of these values. Reduce the drive, or use the response in time"
    )
    return [Diagnostic("over frequency, amplifier", "warning", text)]


def sampling(drive: Drive, times: Real) -> list[Diagnostic]:
    """Return a warning where output values are exact but a line through them does not follow the result.

    `times` (n,) [s].
    """
    if len(times) < 2 or shows(drive, times):
        return []
    step, fastest = float(np.max(np.diff(times))), fastest_frequency(drive)
    needed = enough(drive, float(times[0]), float(times[-1]), fewest=len(times), most=MOST)
    changes = f"varies at {format_quantity(fastest, 'Hz')}"
    if step * fastest * FEWEST <= 1 + ROUNDING:
        changes = "has pieces that lie between them"
    advice = f"time.samples = {needed} would show it"
    if drive.time_stamps is not None:
        advice = "omit time.samples: the times of the measured drive show it"
    elif needed > MOST:
        advice = f"more than {MOST} samples would be needed: request numbers with --quantity, or a shorter time.duration"
    text = (
        f"the output times are {format_quantity(step, 's')} apart, but the drive {changes}: the values are exact at each"
        f" time, and a line between them is misleading; {advice}"
    )
    return [Diagnostic("sampling", "warning", text, float(needed), float(len(times)), "1")]
