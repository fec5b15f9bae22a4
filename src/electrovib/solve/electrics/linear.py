"""Linear layers under a voltage or a current, from rest or in the periodic state, behind an amplifier without limits.

The gain and the pole of an amplifier are a filter before the stack.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.physics.drive.pieces import Linear
from electrovib.solve.electrics.solution import CURRENT_DRIVE, PERIODIC, TRANSIENT, Solution
from electrovib.solve.electrics.straight import BreakStates, lag_since_breaks
from electrovib.solve.electrics.transient import how_it_begins, part_lag, transient
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key

SAME_RATE: Final = 1e-8
"""Relative distance below which two rates count as equal, and are moved apart by twice as much."""


def answer_linear(question: Question) -> Solution:
    """Compute the response of linear layers to a voltage, behind an amplifier without limits if there is one, or to a current."""
    amplifier, drive = question.scenario.circuit.amplifier, question.scenario.drive
    transfers, settled = question.wanted(question.section), question.settled
    if amplifier is not None:
        return behind_gain_and_pole(transfers, drive, question.times, amplifier=amplifier, settled=settled)
    method, how = PERIODIC if settled else TRANSIENT, "a voltage drive: real modes"
    if drive.quantity == "current":
        method, how = (
            CURRENT_DRIVE,
            "a current drive: modes of each layer, blocking layers integrate the current,",
        )
    return Solution(
        found=transient(transfers, drive, question.times, settled=settled),
        method=method,
        reason=f"linear layers, fixed gap and {how} {how_it_begins(drive, settled=settled)}",
    )


def behind_gain_and_pole(
    transfers: Mapping[Any, Transfer], drive: Drive, time: Real, *, amplifier: Amplifier, settled: bool
) -> Solution:
    """Compute the response behind an amplifier without limits of quantities that are linear in the plate's voltage.

    `time` (n,) [s].
    """
    found = transient(amplified(transfers, amplifier), drive, time, settled=settled)
    begin = how_it_begins(drive, settled=settled)
    why = f"linear layers behind an amplifier without limits: its gain and pole are a filter before the stack, {begin}"
    return Solution(found=found, method=PERIODIC if settled else TRANSIENT, reason=why)


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
    refuse_behind_amplifier(scenario)


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


def refuse_amplified(drive: Drive, amplifier: Amplifier, *, settled: bool) -> None:
    """Refuse a drive or an initial state that cannot be combined with an amplifier before linear layers."""
    if drive.quantity == "current":
        raise InputError(
            f"circuit.amplifier: {type(drive).__name__} prescribes the current itself; omit the amplifier"
        )
    if settled and amplifier.is_limited:
        raise InputError(
            "time.initial_state = PeriodicState: behind an amplifier with limits the periodic state is not known"
            " beforehand. Start AtRest and evaluate a late period, or omit its limits"
        )


def refuse_behind_amplifier(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with its amplifier before linear layers."""
    if scenario.circuit.amplifier is not None:
        refuse_amplified(scenario.drive, scenario.circuit.amplifier, settled=scenario.time.settled)


def amplified(transfers: Mapping[Any, Transfer], amplifier: Amplifier) -> dict[Any, Transfer]:
    """Return quantities per volt of the drive from those per volt of the plate, with those of the plate itself."""
    plate = Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=1.0)
    own = {"plate_voltage": plate, "amplifier_current": transfers["current"] + _stray(amplifier)}
    return {name: _behind(transfer, amplifier) for name, transfer in (dict(transfers) | own).items()}


def _stray(amplifier: Amplifier) -> Transfer:
    """Return the current into the stray capacitance per volt of the plate [A/V]."""
    return Transfer(rates=np.zeros(0), gains=np.zeros(0), slope=amplifier.stray_capacitance, static=0.0)


def _corner(amplifier: Amplifier, rates: Real) -> float | None:
    """Return the angular corner frequency of an amplifier [rad/s], moved away from rates [1/s] that almost equal it."""
    if amplifier.bandwidth is None:
        return None
    corner = 2 * np.pi * amplifier.bandwidth
    return corner * (1 + 2 * SAME_RATE) if np.any(np.abs(rates - corner) < SAME_RATE * corner) else corner


def _behind(transfer: Transfer, amplifier: Amplifier) -> Transfer:
    """Multiply a linear quantity of the plate's voltage by gain and pole of an amplifier, by partial fractions."""
    gain, corner = amplifier.gain, _corner(amplifier, transfer.rates)
    if corner is None:
        return replace(transfer * gain, free=transfer.free)
    apart = corner - transfer.rates
    direct = transfer.direct if transfer.static is None else transfer.static - float(np.sum(transfer.gains))
    own = direct - transfer.slope * corner - float(np.sum(transfer.gains * transfer.rates / apart))
    return Transfer(
        rates=np.append(transfer.rates, corner),
        gains=gain * np.append(transfer.gains * corner / apart, own),
        direct=gain * transfer.slope * corner,
        free=np.append(transfer.free, 0.0),
        static=None if transfer.static is None else gain * transfer.static,
    )


class Unlimited:
    """Plate, modes and current behind an amplifier that never meets a limit.

    Parameters
    ----------
    drive : Drive
        Off before time 0.
    amplifier : Amplifier
        Gain, pole and stray capacitance.
    rates : ndarray, shape (modes,)
        Rates of the modes of the stack [1/s], > 0.
    current : Transfer
        Current into the stack per volt of the plate [A/V].

    Attributes
    ----------
    amplifier : Amplifier
        The same with a pole that differs from all rates.
    corner : float or None
        That pole [rad/s].
    """

    def __init__(self, drive: Drive, amplifier: Amplifier, rates: Real, current: Transfer) -> None:
        self.drive, self.rates, self.corner = drive, rates, _corner(amplifier, rates)
        if self.corner is not None:
            amplifier = amplifier.model_copy(update={"bandwidth": self.corner / (2 * np.pi)})
        self.amplifier = amplifier
        self.current_per_volt = supplied = _behind(current + _stray(amplifier), amplifier)
        self.modes = _Lags(drive, rates if self.corner is None else np.append(rates, self.corner))
        driven = (supplied.gains != 0) & (supplied.rates > 0)
        self.flows, self.weights = _Lags(drive, supplied.rates[driven]), supplied.gains[None, driven]

    def current(self, time: Real) -> Real:
        """Compute the current of the amplifier [A] at some times [s]."""
        per_volt = self.current_per_volt
        found = per_volt.at_rest() * self.drive.voltage(time) + self.flows.of(self.weights, time)[0]
        if per_volt.slope:
            found = found + per_volt.slope * self.drive.slope(time)
        left = per_volt.free != 0
        if np.any(left):
            found = found + per_volt.free[left] @ np.exp(-np.outer(per_volt.rates[left], time))
        return np.asarray(found)

    def state(self, time: float) -> tuple[float, Real]:
        """Return the voltage of the plate just before a time [V], and the states of the modes (modes,) [V]."""
        at, gain = np.array([time]), self.amplifier.gain
        lags = self.modes.of(np.eye(len(self.modes.rates)), at)[:, 0]
        now = float(self.drive.voltage(at)[0])
        if self.corner is None:
            before = sum(float(part.value_before(at)[0]) for part in self.drive.parts()) if time > 0 else 0.0
            return gain * before, gain * (now + lags)
        lags, own = lags[:-1], float(lags[-1])
        lags = (self.corner * lags - self.rates * own) / (self.corner - self.rates)
        return gain * (now + own), gain * (now + lags)


class _Lags:
    """Lag x - u of modes x' = rate (u - x) behind a drive u, from rest; rates (modes,) [1/s], > 0."""

    def __init__(self, drive: Drive, rates: Real) -> None:
        self.rates = rates
        self.smooth = [part for part in drive.parts() if not isinstance(part, Linear)]
        pieces = [part for part in drive.parts() if isinstance(part, Linear)]
        self.straight = [BreakStates(each, rates, np.zeros(len(rates))) for each in pieces]

    def of(self, gains: Real, time: Real) -> Real:
        """Compute the sums of gain (x - u) over modes [V]: `gains` (outputs, modes), `time` (n,) [s]."""
        found = np.zeros((len(gains), len(time)))
        if len(self.rates):
            found += sum(part_lag(part, self.rates, gains, time) for part in self.smooth)
            found += sum(lag_since_breaks(states, gains, time) for states in self.straight)
        return found
