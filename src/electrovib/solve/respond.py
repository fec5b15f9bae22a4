"""Which solver answers in time: it follows from what the models declare, and is told with its reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError
from electrovib.solve.branch import leaky_response
from electrovib.solve.current import REASON, current_response, drive_voltage
from electrovib.solve.leak import leak_alone, leak_section, leaking_layer
from electrovib.solve.periodic import count_harmonics
from electrovib.solve.scenario import PeriodicState
from electrovib.solve.transient import transient

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.section import ModalSection
    from electrovib.solve.transfer import Real, Transfer


def respond(
    scenario: Scenario,
    section: ModalSection,
    wanted: Callable[[ModalSection], dict[str, Transfer]],
    times: Real,
    *,
    element: SeriesElement,
    second: float,
) -> tuple[dict[str, Real], dict[str, Any]]:
    """Compute quantities of a stack over time with the solver its models ask for.

    Parameters
    ----------
    scenario : Scenario
        Drive, layers and initial state.
    section : ModalSection
        The stack per unit of the drive, without leaks.
    wanted : callable
        Names the linear quantities of a section, `stack_voltage` among them.
    times : ndarray, shape (n,)
        s.
    element : SeriesElement
        Source and return path.
    second : float
        First contact area over that of a second contact; 0 for none.

    Returns
    -------
    found : dict of str to ndarray
        The quantities, `drive_voltage`, and `drive_current` under current drive.
    choice : dict
        Solver and reason, and of a march its error.

    Raises
    ------
    InputError
        If the models do not go together.
    """
    drive, layers = scenario.drive, scenario.stack.layers
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    current = drive.quantity == "current"
    name = leaking_layer(layers, second=second)
    _refuse_gaps_of_a_law(scenario, current=current, leak=name)
    if name is not None:
        found, choice = _leaky(scenario, section, wanted, times, name, element)
    elif current:
        found = current_response(wanted(section), drive, times, settled=settled)
        choice = {"solver": "current drive", "solver_reason": f"{REASON}, {_start(drive, settled=settled)}"}
    else:
        found = transient(wanted(section), drive, times, settled=settled)
        choice = _linear(drive, settled=settled)
    if current:
        found["drive_current"] = drive.voltage(times)
        found["drive_voltage"] = drive_voltage(
            found["stack_voltage"], drive, times, element=element, second=second, settled=settled
        )
    else:
        found["drive_voltage"] = drive.voltage(times)
    return found, choice


def _refuse_gaps_of_a_law(scenario: Scenario, *, current: bool, leak: str | None) -> None:
    """A law with gaps of its own takes the voltage of linear layers as given."""
    law = type(scenario.force)
    if getattr(law, "replaces", ()) and (current or leak):
        why = f"what leaks beside '{leak}' is not followed into them"
        if current:
            why = "under a prescribed current they would decide on the voltage themselves"
        raise InputError(
            f"force = {law.__name__}: its gaps are no layers of the stack, and {why}. Give the stack a layer 'gap' and"
            " use force.model = GapPlane"
        )


def _start(drive: Drive, *, settled: bool) -> str:
    count = count_harmonics(drive) if settled else None
    how = f"its {count} harmonics exactly" if count else "straight pieces and sines exactly"
    return f"from {'the periodic state' if settled else 'rest'}, {how}"


def _linear(drive: Drive, *, settled: bool) -> dict[str, Any]:
    why = f"linear layers, fixed gap and a voltage drive: real modes {_start(drive, settled=settled)}"
    return {"solver": "periodic" if settled else "transient", "solver_reason": why}


def _leaky(
    scenario: Scenario,
    section: ModalSection,
    wanted: Callable[[ModalSection], dict[str, Transfer]],
    times: Real,
    name: str,
    element: SeriesElement,
) -> tuple[dict[str, Real], dict[str, Any]]:
    layers, area = scenario.stack.layers, scenario.contact.gross_area()
    leak = layers[name].leak
    assert leak is not None
    if isinstance(scenario.time.initial_state, PeriodicState):
        raise InputError(
            f"time.initial_state = PeriodicState: layer '{name}' leaks by {type(leak).__name__}, not in proportion to"
            " its field, so its periodic state is not known beforehand. Start AtRest and look at a late period"
        )
    if scenario.drive.quantity == "current":
        answer = leak_alone(section, layers, name, area=area)
    else:
        answer = leak_section(section, layers, name, area=area, element=element)
    leaked = leaky_response(
        wanted(section), wanted(answer), scenario.drive, times, leak=leak, control=f"field {name}"
    )
    return leaked.found, {
        "solver": "nonlinear branch",
        "solver_reason": leaked.reason(name, leak),
        "step_error": leaked.error,
    }
