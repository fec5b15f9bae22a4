"""Stacks without fixed modes: a gap that moves or follows the forces, several leaks, an amplifier with limits before a leak."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.force import MaxwellStressInGap
from electrovib.physics.stack import INTERFACE
from electrovib.solve.electrics.attraction import pressed
from electrovib.solve.electrics.leaks import leaking_slabs
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf
from electrovib.solve.stack.section import APART, StackLayer, StackSection

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question, Solution
    from electrovib.solve.nonlinear.finger import Yielding
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.layer_states import StackStates


def why_no_modes(scenario: Scenario) -> str:
    """Return the parts of a scenario that no solver with fixed modes accepts, in words; empty if there are none."""
    leaks = [slab[0] for slab in leaking_slabs(scenario.stack.layers)]
    said = []
    if scenario.motion.moved_gap is not None:
        said.append("a gap that is moved")
    if scenario.contact.closing is not None:
        said.append("a gap that follows load and attraction")
    if leaks and said:
        said.append(f"the leak of '{leaks[0]}'")
    elif len(leaks) > 1:
        said.append(f"leaks of {' and '.join(leaks)}")
    if leaks and scenario.circuit.supply.is_limited:
        said.append("an amplifier with limits before a leak")
    return ", ".join(said)


def moves_alone(scenario: Scenario) -> bool:
    """Return whether a gap of prescribed motion is the only part without fixed modes, so that the rest is linear."""
    return (
        scenario.motion.moved_gap is not None
        and scenario.contact.closing is None
        and all(layer.leak is None for layer in scenario.stack.layers.values())
        and not scenario.circuit.supply.is_limited
    )


def follow_moving_gap(question: Question) -> Solution:
    """Compute the response of linear layers under a gap of prescribed thickness."""
    from electrovib.solve.electrics.moving_gap import move_gap

    scenario, distance = question.scenario, question.scenario.motion.moved_gap
    assert distance is not None
    space, amplifier = _states(question), scenario.circuit.supply
    moved = move_gap(space, scenario.drive, question.times, motion=distance, amplifier=amplifier)
    return _with_law(scenario, moved)


def follow_all(question: Question) -> Solution:
    """Compute the response of any stack by the general nonlinear solver."""
    from electrovib.solve.nonlinear.finger import follow_finger

    scenario = question.scenario
    motion = _yielding(scenario) if scenario.contact.closing is not None else scenario.motion.moved_gap
    followed = follow_finger(
        _states(question),
        scenario.drive,
        question.times,
        amplifier=scenario.circuit.supply,
        motion=motion,
    )
    reason = f"{why_no_modes(scenario)}: {followed.reason}"
    errors = {"events": len(followed.events)}
    return _with_law(scenario, replace(followed, reason=reason, errors=errors))


def _states(question: Question) -> StackStates:
    """Return the stack as physical states, with the layer that moves."""
    from electrovib.solve.stack.layer_states import stack_states

    scenario = question.scenario
    moves = scenario.motion.moved_gap is not None or scenario.contact.closing is not None
    return stack_states(
        scenario.stack.layers,
        question.section.debye,
        moving=_moving(scenario) if moves else None,
        **vars(Surroundings.of(scenario)),
    )


def _with_law(scenario: Scenario, solution: Solution) -> Solution:
    """Add the amplitudes of the force law to a solution, and omit signals of the amplifier where there is none."""
    found = dict(solution.found)
    if scenario.circuit.amplifier is None:
        for name in ("plate_voltage", "amplifier_current"):
            found.pop(name, None)
    seen, law = _over_time(scenario, found), scenario.force
    found |= {AmplitudeOf(name): values for name, values in law.amplitudes(seen).items()}
    effective = law.effective_voltage(seen)
    if effective is not None:
        found["effective_voltage"] = effective
    return replace(solution, found=found)


def _over_time(scenario: Scenario, found: dict[Key, Real]) -> TimeSection:
    """Return the stack over time in the form that a force law takes."""
    gap = scenario.stack.gap_name
    layers = {
        name: StackLayer(
            thickness=found["gap"] if name == gap and "gap" in found else layer.thickness,
            material=layer.material,
            field=found[FieldOf(name)],
            displacement=found[DisplacementOf(name)],
        )
        for name, layer in scenario.stack.layers.items()
    }
    density, at = found["current"] / scenario.contact_area, found[DisplacementOf(gap or INTERFACE)]
    return TimeSection(
        layers=layers,
        roles=scenario.stack.roles,
        voltage=found["stack_voltage"],
        current_density=density,
        interface_displacement=at,
    )


def _moving(scenario: Scenario) -> str:
    """Return the name of the layer whose thickness changes."""
    name = scenario.stack.gap_name
    if name is None:
        path = "contact.closing" if scenario.motion.distance is None else "motion.distance"
        raise InputError(
            f"{path}: it moves the gap, and the stack only has {', '.join(scenario.stack.layers)}; add a table stack.gap, or"
            " another layer with role = 'gap'"
        )
    return name


def refuse_without_modes(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with a stack without modes."""
    why, drive, law = why_no_modes(scenario), scenario.drive, type(scenario.force)
    closes, moves = scenario.contact.closing is not None, scenario.motion.distance is not None
    if drive.quantity == "current":
        raise InputError(
            f"drive = {type(drive).__name__}: a stack with {why} needs a voltage drive; a current drive is solved with a"
            " fixed gap and at most one leak"
        )
    if scenario.time.settled:
        raise InputError(
            f"time.initial_state = PeriodicState: for a stack with {why} the periodic state is not known beforehand. Start"
            " AtRest and evaluate a late period"
        )
    if getattr(law, "replaces", ()):
        raise InputError(
            f"force = {law.__name__}: its gaps are no layers of the stack, and their response to {why} is"
            " not modelled. Give the stack a layer 'gap' and use force.model = MaxwellStressInGap"
        )
    if closes and (
        law.pressure is not MaxwellStressInGap.pressure or law.amplitudes is not MaxwellStressInGap.amplitudes
    ):
        raise InputError(
            "contact.closing: the gap follows the Maxwell stress in the gap, eps0 E^2/2, and"
            f" force = {law.__name__} gives another attraction (evaluation surface: {law.evaluation_surface}); use"
            " force.model = MaxwellStressInGap, or omit contact.closing"
        )
    if closes and moves:
        raise InputError(
            "contact.closing and motion.distance: either sets the thickness of the gap; omit one of them"
        )
    if closes and scenario.circuit.return_path.second_contact(1.0):
        raise InputError(
            "contact.closing: under a SecondElectrode each contact would close by its own pull and its share of the load;"
            " use Grounded or Floating"
        )
    if closes or moves:
        _moving(scenario)
    if closes and scenario.contact.surface is None:
        raise InputError(
            "contact.closing needs contact.surface, the surface topography against which the gap closes, for instance"
            ' contact.surface = { model = "LinearSpring", ... }'
        )


def _yielding(scenario: Scenario) -> Yielding:
    """Return the gap that follows the forces; its first value carries the load alone, or is as declared without a load."""
    from electrovib.solve.nonlinear.finger import Yielding

    contact = scenario.contact
    surface, closing = contact.surface, contact.closing
    assert surface is not None
    assert closing is not None

    def load(time: float) -> float:
        return float(contact.mean_pressure(scenario.load.forces(time)))

    def together(time: float, pull: float) -> float:
        return float(contact.mean_pressure(pressed(contact, scenario.load.forces(time), np.asarray(pull))))

    start = float(surface.gap(np.asarray(load(0.0))))
    if not np.isfinite(start):  # without a load the gap of such a surface topography is infinite
        start = scenario.stack.layers[_moving(scenario)].thickness
    if not start > 0:
        raise InputError(
            "contact.surface: the load alone closes the gap; give a stiffer surface topography, or less load.normal_force"
        )
    return Yielding(
        surface=surface,
        load=load,
        start=start,
        damping=closing.damping,
        pulling=scenario.stack.layers[_moving(scenario)].material.pulling_share,
        together=together if contact.grows else None,
    )


@dataclass(frozen=True, kw_only=True)
class TimeSection(StackSection):
    """The stack as values over time, for solvers without modes: moving gap, several leaks."""

    voltage: Real
    current_density: Real
    interface_displacement: Real

    @property
    def frequency(self) -> Real:
        """Raise a TypeError: a law that reads the frequency has no time-domain form."""
        raise TypeError("a record has no single frequency")

    def inverse_root_thickness(self, names: Sequence[str]) -> Any:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2], which must not be dispersive."""
        total: Any = 0.0
        for name in names:
            low, high = (self[name].material.bound_permittivity(np.array(f)) for f in APART)
            if abs(low - high) > 1e-12 * abs(high):
                raise InputError(
                    f"stack.{name}.material: the force law filters by permittivities, and this one depends on frequency; with"
                    " this gap, leak or amplifier use force.model = MaxwellStressInGap, or a non-dispersive material"
                )
            total = total + self[name].thickness / float(high.real)
        return total**-0.5
