"""A resistor between amplifier and plate that limits the current through a finger if the insulator fails."""

from __future__ import annotations

import math


def smallest_series_resistance(*, voltage: float, current: float, body_resistance: float = 0.0) -> float:
    """Compute the smallest resistance [ohm] that holds the current after a breakdown of the insulator.

    It is V/I - R_body, and 0 where the body alone suffices: `voltage` V is the largest of the supply [V],
    `current` I the largest through the finger [A], above 0, `body_resistance` R_body that of finger and body
    that is relied on [ohm]. The insulator counts as a short circuit. The charge behind the resistor, on the
    plate and its stray capacitance, is not limited by it: see `stored_energy_behind`.
    """
    return max(voltage / current - body_resistance, 0.0)


def largest_supply_voltage(*, resistance: float, current: float, body_resistance: float = 0.0) -> float:
    """Compute the largest voltage of a supply at which a series resistance holds the current after a breakdown.

    It is I (R + R_body) [V], with the arguments of `smallest_series_resistance`.
    """
    return current * (resistance + body_resistance)


def resistor_power(*, voltage: float, resistance: float, body_resistance: float = 0.0) -> float:
    """Compute the power in the series resistor while the insulator is a short circuit: R (V/(R + R_body))^2 [W]."""
    return resistance * (voltage / (resistance + body_resistance)) ** 2 if resistance > 0 else 0.0


def charging_time(*, resistance: float, capacitance: float) -> float:
    """Compute the time constant [s] with which the plate charges through the resistor: R C.

    C is the capacitance of the plate under the finger and of the stray capacitance behind the resistor [F].
    """
    return resistance * capacitance


def corner_frequency(*, resistance: float, capacitance: float) -> float:
    """Compute the frequency at which the voltage of the plate has fallen by a factor of the square root of 2.

    It is 1/(2 pi R C) [Hz], and infinite without a resistor.
    """
    time_constant = charging_time(resistance=resistance, capacitance=capacitance)
    return 1 / (2 * math.pi * time_constant) if time_constant > 0 else math.inf


def stored_energy_behind(*, voltage: float, capacitance: float) -> float:
    """Compute the energy [J] that the resistor does not limit, which a breakdown releases at once: C V^2/2."""
    return capacitance * voltage**2 / 2
