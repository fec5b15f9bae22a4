"""Linear layers under a voltage or a current, from rest or in the periodic state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.solve.electrics.solution import CURRENT_DRIVE, PERIODIC, TRANSIENT, Solution
from electrovib.solve.electrics.transient import how_it_begins, transient
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key


def answer_to_voltage(question: Question) -> Solution:
    """Compute the response of linear layers to a voltage, behind an amplifier if there is one."""
    amplifier, drive = question.scenario.circuit.amplifier, question.scenario.drive
    transfers = question.wanted(question.section)
    if amplifier is not None:
        from electrovib.solve.electrics.amplifier import amplified_response

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


def drive_voltage(
    stack_voltage: Real,
    drive: Drive,
    time: Real,
    *,
    element: SeriesElement,
    second: float,
    settled: bool,
    charge: float = 0.0,
) -> Real:
    """Compute the voltage that the amplifier has to supply for its current.

    `stack_voltage` (n,) [V], `time` (n,) [s]; returns `voltage` (n,) [V].
    """
    rates, gains, free = np.zeros(0), np.zeros(0), np.zeros(0)
    if element.elastance > 0:
        rates = np.array([element.rate or INTEGRATING, element.rate])
        gains = np.array([element.elastance / rates[0], 0.0])
        free = np.array([0.0, element.elastance * charge])
    around = {"voltage": Transfer(rates=rates, gains=gains, direct=element.resistance, slope=0.0, free=free)}
    return stack_voltage * (1 + second) + transient(around, drive, time, settled=settled)["voltage"]


def caveat() -> Diagnostic:
    """Return the diagnostic that the contact area and stray currents of a prescribed current are not known."""
    text = (
        "the whole current of the drive is assumed to cross this contact area, so the force is proportional to 1/area; a"
        " current through stray capacitance or beside the gap does not attract, and its share is not known here"
    )
    return Diagnostic("current drive", "unknown", text)
