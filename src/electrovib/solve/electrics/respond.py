"""Which solver answers in time: it follows from what the models declare, and is told with its reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from electrovib.core.errors import InputError
from electrovib.physics.circuit import Grounded
from electrovib.scenario import PeriodicState
from electrovib.solve.electrics import renewal
from electrovib.solve.electrics.general import beyond_modes, refuse_beyond_modes, solve_beyond, time_section
from electrovib.solve.electrics.leaks.branch import leaky_response
from electrovib.solve.electrics.leaks.leak import leak_alone, leak_section, leaking_layer
from electrovib.solve.electrics.linear.current import REASON, drive_voltage
from electrovib.solve.electrics.linear.periodic import count_harmonics
from electrovib.solve.electrics.linear.transient import transient
from electrovib.solve.stack.expand import total_pull
from electrovib.solve.stack.integrator import refuse_unrepeated

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.section import ModalSection
    from electrovib.solve.stack.transfer import Transfer

AMPLITUDE = "amplitude "
"""Before the name of an amplitude of the force law, among what is wanted of a solver."""


class Response(NamedTuple):
    """What a solver found.

    Parameters
    ----------
    found : dict of str to ndarray
        Quantities over time, amplitudes of the law among them where the force is theirs.
    choice : dict
        Solver and reason, and of a march or a mean its error.
    pull : ndarray or None
        As from `total_pull`, where it is a mean over places and not that of mean amplitudes.
    """

    found: dict[str, Real]
    choice: dict[str, Any]
    pull: Real | None = None


def respond(
    scenario: Scenario,
    section: ModalSection,
    wanted: Callable[[ModalSection], dict[str, Transfer]],
    times: Real,
    *,
    element: SeriesElement,
    second: float,
) -> Response:
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
    Response
        The quantities, `drive_voltage`, and `drive_current` under current drive.

    Raises
    ------
    InputError
        If the models do not go together.
    """
    refuse_unsolved(scenario, second=second)
    drive, layers = scenario.drive, scenario.stack.layers
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    current = drive.quantity == "current"
    if beyond_modes(scenario) and not scenario.motion.renews_film:
        found, choice = solve_beyond(scenario, section, times, element=element, second=second)
        return Response(found | _law(scenario, found), choice)
    name = leaking_layer(layers, second=second)
    pull = None
    if scenario.motion.renews_film:
        found, choice, pull = _renewed(scenario, wanted(section), times)
    elif name is not None:
        found, choice = _leaky(scenario, section, wanted, times, name, element)
    elif scenario.circuit.amplifier is not None:
        found, choice = _amplified(scenario, wanted(section), times, settled=settled)
        current = False
    elif current:
        found = transient(wanted(section), drive, times, settled=settled)
        choice = {"solver": "current drive", "solver_reason": f"{REASON}, {_start(drive, settled=settled)}"}
    else:
        found = transient(wanted(section), drive, times, settled=settled)
        choice = _linear(drive, settled=settled)
    if current:
        found["drive_current"] = drive.voltage(times)
        charge = element.charge + scenario.contact_area * sum(each.initial_charge for each in layers.values())
        found["drive_voltage"] = drive_voltage(
            found["stack_voltage"],
            drive,
            times,
            element=element,
            second=second,
            settled=settled,
            charge=charge,
        )
    else:
        found["drive_voltage"] = drive.voltage(times)
    return Response(found, choice, pull)


def refuse_unsolved(scenario: Scenario, *, second: float) -> None:
    """Refuse what no solver takes; costs nothing, so that it can be told before any work.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    second : float
        First contact area over that of a second contact; 0 for none.

    Raises
    ------
    InputError
        If models do not go together.
    """
    drive, layers, amplifier = scenario.drive, scenario.stack.layers, scenario.circuit.amplifier
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    current = drive.quantity == "current"
    if settled:
        refuse_unrepeated(drive)
    if beyond_modes(scenario) and not scenario.motion.renews_film:
        refuse_beyond_modes(scenario)
        return
    name = leaking_layer(layers, second=second)
    _refuse_gaps_of_a_law(scenario, current=current, leak=name)
    if scenario.motion.renews_film:
        renewal.refuse_with(
            settled=settled,
            current=current,
            leak=name,
            floating=not isinstance(scenario.circuit.return_path, Grounded),
            amplified=amplifier is not None,
            closing=scenario.contact.closing is not None,
        )
    elif name is not None and settled:
        raise InputError(
            f"time.initial_state = PeriodicState: layer '{name}' leaks by {type(layers[name].leak).__name__}, not in"
            " proportion to its field, so its periodic state is not known beforehand. Start AtRest and look at a late period"
        )
    elif name is None and amplifier is not None:
        from electrovib.solve.electrics.amplifier.amplifier import refuse_amplified

        refuse_amplified(drive, amplifier, settled=settled)


def is_marched(scenario: Scenario) -> bool:
    """Tell whether the solver goes from step to step, so that a second look costs as much as the first."""
    if scenario.motion.renews_film:
        return False
    amplifier = scenario.circuit.amplifier
    leaks = any(layer.leak is not None for layer in scenario.stack.layers.values())
    return leaks or bool(beyond_modes(scenario)) or (amplifier is not None and amplifier.is_limited)


def _law(scenario: Scenario, found: dict[str, Real]) -> dict[str, Real]:
    """Ask the force law for its amplitudes in a record."""
    seen, law = time_section(scenario, scenario.contact_area, found), scenario.force
    amplitudes = {f"{AMPLITUDE}{name}": values for name, values in law.amplitudes(seen).items()}
    effective = law.effective_voltage(seen)
    return amplitudes if effective is None else amplitudes | {"effective_voltage": effective}


def _amplified(
    scenario: Scenario, transfers: dict[str, Transfer], times: Real, *, settled: bool
) -> tuple[dict[str, Real], dict[str, Any]]:
    """Answer behind an amplifier."""
    from electrovib.solve.electrics.amplifier.amplifier import amplified_response

    amplifier, drive = scenario.circuit.amplifier, scenario.drive
    assert amplifier is not None
    answer = amplified_response(transfers, drive, times, amplifier=amplifier, settled=settled)
    if not amplifier.is_limited:
        how = "its gain and pole are a filter before the stack"
        why = f"linear layers behind an amplifier without limits: {how}, {_start(drive, settled=settled)}"
        return answer.found, {"solver": "periodic" if settled else "transient", "solver_reason": why}
    return answer.found, {"solver": "amplifier", "solver_reason": answer.reason()}


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


def _renewed(scenario: Scenario, transfers: dict[str, Transfer], times: Real) -> Response:
    """Answer at every place under the sliding finger, and give the mean over them."""
    length = scenario.contact.sliding_length(scenario.load.normal_force)

    def read(places: dict[str, Real]) -> dict[str, Real]:
        amplitudes = {n.removeprefix(AMPLITUDE): row for n, row in places.items() if n.startswith(AMPLITUDE)}
        kept = {name: row for name, row in places.items() if not name.startswith(AMPLITUDE)}
        return kept | ({"pull": total_pull(scenario, amplitudes)} if amplitudes else {})

    mean = renewal.mean_over_contact(
        transfers, scenario.drive, times, motion=scenario.motion, length=length, read=read
    )
    choice = {"solver": "renewal", "solver_reason": mean.reason(), "quadrature_error": mean.error}
    return Response(mean.found, choice, mean.found.pop("pull", None))


def _leaky(
    scenario: Scenario,
    section: ModalSection,
    wanted: Callable[[ModalSection], dict[str, Transfer]],
    times: Real,
    name: str,
    element: SeriesElement,
) -> tuple[dict[str, Real], dict[str, Any]]:
    layers, area = scenario.stack.layers, scenario.contact_area
    leak = layers[name].leak
    assert leak is not None
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
