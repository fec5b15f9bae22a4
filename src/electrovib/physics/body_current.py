"""Currents through a body that sources state as thresholds, no limits of a set-up; and the resistor that limits the current."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from electrovib.core.parsing import read_toml

NOT_A_CLAIM: Final = (
    "These are comparisons with published currents, not a claim of medical safety: they hold for healthy adults and for the"
    " stated conditions, and say nothing about persons with an implanted device or a heart condition, wet or broken skin,"
    " burns, a fault of the amplifier, or breakdown of the insulator. Only hardware that limits the current protects a person."
)


@dataclass(frozen=True, kw_only=True)
class CurrentThreshold:
    """A current through a body or a finger, as a source states it.

    Parameters
    ----------
    name : str
        What the source calls it.
    value : float
        Current [A].
    statistic : str
        ``"peak"`` or ``"rms"``: the statistic of the current that it is compared with.
    of : str
        Current that is compared: ``"current"``, of the amplifier into plate, stray capacitance and finger, or
        ``"body_current"``, through the finger.
    conditions : str
        Conditions under which the source states it.
    source : str
        Publication.
    status : str
        How the source was read: ``"full text"``, ``"second-hand"`` or ``"unverified"``.
    """

    name: str
    value: float
    statistic: str
    of: str
    conditions: str
    source: str
    status: str


_STATED: Final = Path(__file__).with_name("body_current.toml").read_text(encoding="utf-8")
THRESHOLDS: Final = tuple(CurrentThreshold(**each) for each in read_toml(_STATED)["threshold"])
"""In the order in which they are shown."""


def smallest_series_resistance(*, voltage: float, current: float) -> float:
    """Compute the smallest resistance [ohm] that holds the current after a breakdown of the insulator.

    It is V/I: `voltage` V is the largest of the supply [V], `current` I the largest through the finger [A],
    above 0. The insulator counts as a short circuit and the body as no resistance. The charge behind the resistor,
    on the plate and its stray capacitance, is not limited by it: see `stored_energy_behind`.
    """
    return voltage / current


def largest_supply_voltage(*, resistance: float, current: float) -> float:
    """Compute the largest voltage of a supply at which a series resistance holds the current after a breakdown: I R [V]."""
    return current * resistance


def resistor_power(*, voltage: float, resistance: float) -> float:
    """Compute the power in the series resistor while the insulator is a short circuit: V^2/R [W]."""
    return voltage**2 / resistance if resistance > 0 else 0.0


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
