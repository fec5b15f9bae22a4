"""What fixed modes do not hold: a gap that moves or yields, several leaks, an amplifier before a leak."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.contact import FixedArea
from electrovib.physics.force import GapPlane
from electrovib.physics.interface import INTERFACE
from electrovib.scenario import PeriodicState
from electrovib.solve.electrics.pressed import pressed
from electrovib.solve.stack.section import TimeLayer, TimeSection

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.scenario import Scenario
    from electrovib.solve.nonlinear.finger import Yielding
    from electrovib.solve.stack.section import ModalSection


def beyond_modes(scenario: Scenario) -> str:
    """Say what of a scenario no solver with fixed modes takes; empty if nothing."""
    amplifier, contact = scenario.circuit.amplifier, scenario.contact
    leaks = [name for name, layer in scenario.stack.layers.items() if layer.leak is not None]
    said = []
    if scenario.motion.moved_gap is not None:
        said.append("a gap that is moved")
    if contact.closing is not None:
        said.append("a gap that follows load and attraction")
    if leaks and said:
        said.append(f"the leak of '{leaks[0]}'")
    elif len(leaks) > 1:
        said.append(f"leaks of {' and '.join(leaks)}")
    if leaks and amplifier is not None:
        said.append("an amplifier before a leak")
    return ", ".join(said)


def solve_beyond(
    scenario: Scenario, section: ModalSection, times: Real, *, element: SeriesElement, second: float
) -> tuple[dict[str, Real], dict[str, Any]]:
    """Solve a stack over time without fixed modes.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    section : ModalSection
        Its stack, for the reduced materials.
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    element : SeriesElement
        Source and return path.
    second : float
        First contact area over that of a second contact; 0 for none.

    Returns
    -------
    found : dict of str to ndarray
        Voltages, currents, gap and the fields of every layer.
    choice : dict
        Solver and reason, error or events.

    Raises
    ------
    InputError
        If models do not go together.
    """
    from electrovib.solve.electrics.moving_gap import move_gap
    from electrovib.solve.nonlinear.finger import follow_finger
    from electrovib.solve.stack.state_space import stack_states

    why = beyond_modes(scenario)
    amplifier, distance = scenario.circuit.amplifier, scenario.motion.moved_gap
    yields = scenario.contact.closing is not None
    space = stack_states(
        scenario.stack.layers,
        section.debye,
        area=scenario.contact_area,
        element=element,
        second=second,
        moving=_moving(scenario) if distance is not None or yields else None,
    )
    linear = not space.leaks and (amplifier is None or not amplifier.is_limited)
    if distance is not None and linear and not yields:
        moved = move_gap(space, scenario.drive, times, motion=distance, amplifier=amplifier)
        found, choice = (
            moved.found,
            _choice("moving gap", moved.reason(distance), step_error=moved.error),
        )
    else:
        motion = _yielding(scenario) if yields else distance
        asked = times if times[0] == 0 else np.append(0.0, times)
        followed = follow_finger(space, scenario.drive, asked, amplifier=amplifier, motion=motion)
        found = {name: row[len(asked) - len(times) :] for name, row in followed.found.items()}
        choice = _choice("nonlinear", followed.reason(why), events=len(followed.solved.events))
    if amplifier is None:
        found = {
            name: row for name, row in found.items() if name not in {"plate_voltage", "amplifier_current"}
        }
    return found, choice


def _moving(scenario: Scenario) -> str:
    """Name the layer whose thickness changes."""
    name = scenario.stack.gap_name
    if name is None:
        path = "contact.closing" if scenario.motion.distance is None else "motion.distance"
        raise InputError(
            f"{path}: it moves the gap, and the stack has {', '.join(scenario.stack.layers)} only; add a table stack.gap, or"
            " another layer with role = 'gap'"
        )
    return name


def _choice(solver: str, reason: str, **more: Any) -> dict[str, Any]:
    return {"solver": solver, "solver_reason": reason} | more


def refuse_beyond_modes(scenario: Scenario) -> None:
    """Refuse what does not go with a stack without modes.

    Parameters
    ----------
    scenario : Scenario
        One that `beyond_modes` says something about.

    Raises
    ------
    InputError
        If models do not go together.
    """
    why, drive = beyond_modes(scenario), scenario.drive
    if drive.quantity == "current":
        raise InputError(
            f"drive = {type(drive).__name__}: {why} is solved under a voltage; with a fixed gap and at most one leak a"
            " current drive has its own solver"
        )
    if isinstance(scenario.time.initial_state, PeriodicState):
        raise InputError(
            f"time.initial_state = PeriodicState: {why}: the periodic state is not known beforehand. Start AtRest and look"
            " at a late period"
        )
    if getattr(type(scenario.force), "replaces", ()):
        raise InputError(
            f"force = {type(scenario.force).__name__}: its gaps are no layers of the stack, and {why} is not followed into"
            " them. Give the stack a layer 'gap' and use force.model = GapPlane"
        )
    law = type(scenario.force)
    if scenario.contact.closing is not None and (
        law.pressure is not GapPlane.pressure or law.amplitudes is not GapPlane.amplitudes
    ):
        raise InputError(
            f"contact.closing: the gap follows the attraction in the plane of the gap, eps0 E^2/2, and force = {law.__name__}"
            f" gives another one (plane: {law.plane}); use force.model = GapPlane, or leave contact.closing away"
        )
    if scenario.contact.closing is not None and scenario.motion.distance is not None:
        raise InputError(
            "contact.closing and motion.distance: one of them says where the gap is; leave one away"
        )
    if scenario.contact.closing is not None and scenario.circuit.return_path.second_contact(1.0):
        raise InputError(
            "contact.closing: under a SecondElectrode either contact closes by its own pull and its share of the load; use"
            " Grounded or Floating"
        )
    if scenario.motion.distance is not None or scenario.contact.closing is not None:
        _moving(scenario)
    if scenario.contact.closing is not None and scenario.contact.surface is None:
        raise InputError(
            "contact.closing needs contact.surface, the relief that the gap closes against, for instance"
            ' contact.surface = { model = "LinearSpring", ... }'
        )


def _yielding(scenario: Scenario) -> Yielding:
    """Give the gap that follows the forces, beginning where the relief carries the load; as declared if there is none."""
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
    if not np.isfinite(start):  # without a load such a relief is endlessly far
        start = scenario.stack.layers[_moving(scenario)].thickness
    if not start > 0:
        raise InputError(
            "contact.surface: the load alone closes the gap; give a stiffer relief, or less load.normal_force"
        )
    return Yielding(
        surface=surface,
        load=load,
        start=start,
        damping=closing.damping,
        pulling=scenario.stack.layers[_moving(scenario)].material.pulling_share,
        together=None if isinstance(contact, FixedArea) else together,
    )


def time_section(scenario: Scenario, space_area: float, found: dict[str, Real]) -> TimeSection:
    """Show what was found to a force law.

    Parameters
    ----------
    scenario : Scenario
        Its layers.
    space_area : float
        Contact area [m2].
    found : dict of str to ndarray
        As from `solve_beyond`.

    Returns
    -------
    TimeSection
        Over time.
    """
    gap = scenario.stack.gap_name
    layers = {
        name: TimeLayer(
            found["gap"] if name == gap and "gap" in found else layer.thickness,
            layer.material,
            found[f"field {name}"],
            found[f"displacement {name}"],
        )
        for name, layer in scenario.stack.layers.items()
    }
    density, at = found["current"] / space_area, found[f"displacement {gap or INTERFACE}"]
    return TimeSection(layers, scenario.stack.roles, found["stack_voltage"], density, at)
