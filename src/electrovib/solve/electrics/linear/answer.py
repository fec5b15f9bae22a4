"""Linear layers under a voltage or a current, from rest or in the periodic state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.solve.electrics.linear.current import drive_voltage
from electrovib.solve.electrics.linear.transient import how_it_begins, transient
from electrovib.solve.electrics.methods import CURRENT_DRIVE, PERIODIC, TRANSIENT
from electrovib.solve.electrics.solution import Solution
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key


def answer_to_voltage(question: Question) -> Solution:
    """Compute the response of linear layers to a voltage, behind an amplifier without limits if there is one."""
    amplifier, drive = question.scenario.circuit.amplifier, question.scenario.drive
    transfers = question.wanted(question.section)
    if amplifier is not None:
        from electrovib.solve.electrics.amplifier.amplifier import amplified_response

        return amplified_response(
            transfers, drive, question.times, amplifier=amplifier, settled=question.settled
        )
    found = transient(transfers, drive, question.times, settled=question.settled)
    why = f"linear layers, fixed gap and a voltage drive: real modes {how_it_begins(drive, settled=question.settled)}"
    return Solution(found=found, method=PERIODIC if question.settled else TRANSIENT, reason=why)


def answer_to_current(question: Question) -> Solution:
    """Compute the response of linear layers to a prescribed current."""
    drive, transfers = question.scenario.drive, question.wanted(question.section)
    found = transient(transfers, drive, question.times, settled=question.settled)
    why = "linear layers, fixed gap and a current drive: modes of each layer, blocking layers integrate the current"
    return Solution(
        found=found, method=CURRENT_DRIVE, reason=f"{why}, {how_it_begins(drive, settled=question.settled)}"
    )


def of_drive(question: Question, found: dict[Key, Real]) -> dict[Key, Real]:
    """Return the voltage of the drive, and under a prescribed current the current as well."""
    scenario, times = question.scenario, question.times
    drive = scenario.drive
    if drive.quantity == "voltage":
        return {"drive_voltage": drive.voltage(times)}
    around = Surroundings.of(scenario)
    charges = sum(layer.initial_charge for layer in scenario.stack.layers.values())
    voltage = drive_voltage(
        found["stack_voltage"],
        drive,
        times,
        element=around.element,
        second=around.second,
        settled=question.settled,
        charge=around.element.charge + around.area * charges,
    )
    return {"drive_current": drive.voltage(times), "drive_voltage": voltage}


def refuse_gaps_of_a_law(scenario: Scenario, leak: str | None = None) -> None:
    """Refuse a law with gaps of its own where the voltage over linear layers is not prescribed."""
    law, current = type(scenario.force), scenario.drive.quantity == "current"
    if getattr(law, "replaces", ()) and (current or leak):
        why = f"their response to the leak of '{leak}' is not modelled"
        if current:
            why = "under a prescribed current they would change the voltage"
        raise InputError(
            f"force = {law.__name__}: its gaps are no layers of the stack, and {why}. Give the stack a layer 'gap' and"
            " use force.model = MaxwellStressInGap"
        )


def refuse_current(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with a prescribed current."""
    refuse_gaps_of_a_law(scenario)
    if scenario.circuit.amplifier is not None:
        raise InputError(
            f"circuit.amplifier: {type(scenario.drive).__name__} prescribes the current itself; omit the amplifier"
        )
