"""A resistor between amplifier and plate that limits the current through a finger if the insulator fails."""

from __future__ import annotations

import math


def smallest_series_resistance(*, voltage: float, current: float, body_resistance: float = 0.0) -> float:
    """Compute the smallest resistance that holds the current after a breakdown of the insulator.

    Parameters
    ----------
    voltage : float
        Largest voltage of the supply [V], >= 0.
    current : float
        Largest current through the finger [A], > 0.
    body_resistance : float
        Resistance of finger and body that is relied on [ohm], >= 0; 0 for none.

    Returns
    -------
    resistance : float
        V/I - R_body, and 0 where the body alone suffices [ohm].

    Notes
    -----
    The insulator counts as a short circuit. The charge behind the resistor, on the plate and its stray capacitance, is not
    limited by it: see `stored_energy_behind`.
    """
    return max(voltage / current - body_resistance, 0.0)


def largest_supply_voltage(*, resistance: float, current: float, body_resistance: float = 0.0) -> float:
    """Compute the largest voltage of a supply at which a series resistance holds the current after a breakdown.

    Parameters
    ----------
    resistance : float
        Between supply and plate [ohm], >= 0.
    current : float
        Largest current through the finger [A], >= 0.
    body_resistance : float
        Resistance of finger and body that is relied on [ohm], >= 0.

    Returns
    -------
    voltage : float
        I (R + R_body) [V].
    """
    return current * (resistance + body_resistance)


def resistor_power(*, voltage: float, resistance: float, body_resistance: float = 0.0) -> float:
    """Compute the power in the series resistor while the insulator is a short circuit.

    Parameters
    ----------
    voltage : float
        Held by the supply [V].
    resistance : float
        Of the resistor [ohm], >= 0.
    body_resistance : float
        In series with it [ohm], >= 0.

    Returns
    -------
    power : float
        R (V/(R + R_body))^2 [W]; 0 without a resistor.
    """
    return resistance * (voltage / (resistance + body_resistance)) ** 2 if resistance > 0 else 0.0


def charging_time(*, resistance: float, capacitance: float) -> float:
    """Compute the time constant with which the plate charges through the resistor.

    Parameters
    ----------
    resistance : float
        Between amplifier and plate [ohm].
    capacitance : float
        Of the plate under the finger and of the stray capacitance behind the resistor [F].

    Returns
    -------
    time_constant : float
        R C [s]; the voltage of the plate has a corner at 1/(2 pi R C).
    """
    return resistance * capacitance


def corner_frequency(*, resistance: float, capacitance: float) -> float:
    """Compute the frequency at which the voltage of the plate has fallen by a factor of the square root of 2.

    Parameters
    ----------
    resistance : float
        Between amplifier and plate [ohm].
    capacitance : float
        Behind it [F].

    Returns
    -------
    frequency : float
        1/(2 pi R C) [Hz]; infinite without a resistor.
    """
    time_constant = charging_time(resistance=resistance, capacitance=capacitance)
    return 1 / (2 * math.pi * time_constant) if time_constant > 0 else math.inf


def stored_energy_behind(*, voltage: float, capacitance: float) -> float:
    """Compute the energy that the resistor does not limit.

    Parameters
    ----------
    voltage : float
        Of the plate [V].
    capacitance : float
        Behind the resistor [F].

    Returns
    -------
    energy : float
        C V^2/2 [J], which a breakdown releases at once.
    """
    return capacitance * voltage**2 / 2
