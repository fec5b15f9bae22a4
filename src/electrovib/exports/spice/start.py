"""Initial voltages of the capacitors of the circuit, after a step of the drive at time 0."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.stack import interface_place
from electrovib.scenario import PeriodicState, Scenario
from electrovib.solve.electrics.transient import transient
from electrovib.solve.stack.expand import Surroundings, modes
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.solve.stack.section import ModalSection

APART = 1e-7
"""Relative distance by which a relaxation rate is moved from an equal rate of the stack, to avoid a double pole."""


@dataclass(frozen=True, kw_only=True)
class Start:
    """Voltages at time 0: those of the periodic state, or from rest those of initial charge and a step of the drive.

    `section` is the stack in modes for the periodic state, None from rest. From rest there are the `fields`
    of the layers and the `second_fields` of those of a second contact in the direction of the current [V/m],
    the voltage `body` [V], and the displacement `interface` between plate and finger [C/m2].
    """

    scenario: Scenario
    section: ModalSection | None
    fields: Mapping[str, float]
    second_fields: Mapping[str, float]
    body: float
    interface: float

    @classmethod
    def of(cls, scenario: Scenario, debye: Mapping[str, DebyeSum]) -> Start:
        """Compute the voltages at time 0 of a scenario."""
        if not isinstance(scenario.time.initial_state, PeriodicState):
            fields, second, body, interface = _charged(scenario, debye)
            return cls(
                scenario=scenario,
                section=None,
                fields=fields,
                second_fields=second,
                body=body,
                interface=interface,
            )
        _check_periodic(scenario)
        none = dict.fromkeys(debye, 0.0)
        return cls(
            scenario=scenario,
            section=modes(scenario)[0],
            fields=none,
            second_fields=none,
            body=0.0,
            interface=0.0,
        )

    def field(self, name: str) -> Transfer | None:
        """Return the field of a layer in modes [V/m per volt]; None from rest."""
        return None if self.section is None else self.section[name].field

    def displacement(self, name: str) -> Transfer | None:
        """Return the bound displacement of a layer in modes [C/m2 per volt]; None from rest."""
        return None if self.section is None else self.section[name].displacement

    def current_density(self) -> Transfer | None:
        """Return the current density in modes [A/m2 per volt]; None from rest."""
        return None if self.section is None else self.section.current_density

    def interface_charge(self) -> float:
        """Return the displacement at the interface of plate and finger at time 0 [C/m2]."""
        if self.section is None:
            return self.interface
        return self.level(self.section.interface_displacement)

    def level(self, signal: Transfer | None) -> float:
        """Return the value at time 0 of a quantity that is linear in the drive [its unit]; 0 without modes."""
        if signal is None:
            return 0.0
        forced = replace(signal, slope=0.0, free=np.zeros(len(signal.rates)))
        return float(transient({"": forced}, self.scenario.drive, np.zeros(1), settled=True)[""][0])

    def lowpassed(self, signal: Transfer | None, rates: Real) -> list[float]:
        """Return the values at time 0 of a quantity after filters rate/(s + rate), with rates in 1/s [its unit]."""
        if signal is None:
            return [0.0] * len(rates)
        forced = replace(signal, free=np.zeros(len(signal.rates)))
        return [
            self.level(Transfer(rates=np.array([rate]), gains=np.ones(1)) * _kept_clear(forced, rate))
            for rate in rates
        ]

    def body_voltage(self) -> float:
        """Return the voltage of the capacitance of the body at time 0 [V]: the drive less stack and resistance."""
        if self.section is None:
            return self.body
        around = Surroundings.of(self.scenario)
        if self.scenario.drive.quantity == "current":
            rate = np.array([around.element.rate or INTEGRATING])
            return self.level(Transfer(rates=rate, gains=around.element.elastance / rate))
        drop = self.level(self.section.voltage) * (1 + around.second)
        if around.element.resistance:
            drop += around.element.resistance * around.area * self.level(self.section.current_density)
        return float(self.scenario.drive.voltage(0.0)) - drop


def _kept_clear(signal: Transfer, rate: float) -> Transfer:
    """Return a signal in modes whose rates are moved away from a given rate [1/s]."""
    close = np.abs(signal.rates - rate) < APART * rate
    return replace(signal, rates=np.where(close, rate * (1 + APART), signal.rates))


def _check_periodic(scenario: Scenario) -> None:
    layers = scenario.stack.layers.items()
    where = "time.initial_state = PeriodicState: a netlist cannot begin in the periodic state"
    instead = "use AtRest and a longer time.duration"
    problems = [
        f"{where} with stack.{name}.leak, which is not linear; {instead}"
        for name, layer in layers
        if layer.leak
    ]
    problems += [
        f"{where} with stack.{name}.initial_charge, of which only trapped charge remains in that state; {instead}"
        for name, layer in layers
        if layer.initial_charge
    ]
    if problems:
        raise InputError(problems)


def _charged(
    scenario: Scenario, debye: Mapping[str, DebyeSum]
) -> tuple[dict[str, float], dict[str, float], float, float]:
    """Return the fields of both contacts, the voltage of the body and the displacement at the interface from rest.

    Before time 0 the plate carries the image q of the charges Q_k on the plate's side of each element, so
    that the voltages add up to 0; under a prescribed current it carries none. Without a resistance in series,
    a step of the drive changes the charge at once: q sum T/eps = eps0 v - sum Q_k T_k/eps_k, with both sums
    over all elements in series.
    """
    layers, around, drive = scenario.stack.layers, Surroundings.of(scenario), scenario.drive
    charges = np.cumsum([0.0, *(layer.initial_charge for layer in layers.values())]).tolist()
    held, on_body = (
        dict(zip(layers, charges, strict=False)),
        charges[-1] + around.element.charge / around.area,
    )
    flown = 0.0
    if drive.quantity == "voltage":
        lengths = {name: layer.thickness / debye[name].high for name, layer in layers.items()}
        body = eps0 * around.area * around.element.elastance
        whole = sum(lengths.values()) * (1 + around.second) + body
        jump = eps0 * float(drive.voltage(0.0)) if around.element.resistance == 0 else 0.0
        flown = (jump - sum(held[name] * lengths[name] for name in layers) - on_body * body) / whole
    fields = {name: (held[name] + flown) / (eps0 * debye[name].high) for name in layers}
    second = {name: flown * around.second / (eps0 * debye[name].high) for name in layers}
    interface = charges[interface_place(scenario.stack.roles.values())] + flown
    return fields, second, (on_body + flown) * around.area * around.element.elastance, interface
