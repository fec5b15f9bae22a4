"""Quantities of a set-up that are measured without solving it over time: impedance, friction alone, vibration threshold."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.friction.base import SteadyFriction
from electrovib.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class ComputedQuantity:
    """A quantity that a function computes of a scenario, as a measurement names it; papers offer theirs in `quantities`."""

    title: str
    unit: str
    compute: Callable[[Scenario], float]


def impedance(scenario: Scenario) -> complex:
    """Compute the impedance [ohm] of stack and return path at the frequency of a sine."""
    from electrovib.solve.stack.expand import phasors

    section = phasors(scenario, np.array([scenario.drive.frequency]))  # type: ignore[attr-defined]
    return complex(1 / (section.current_density[0] * scenario.contact_area))


def magnitude(scenario: Scenario) -> float:
    """Compute the magnitude of the impedance [ohm]."""
    return abs(impedance(scenario))


def lag(scenario: Scenario) -> float:
    """Compute the angle by which the voltage lags behind the current [rad], positive for a capacitor."""
    return -cmath.phase(impedance(scenario))


def steady(scenario: Scenario) -> SteadyFriction:
    """Return the friction of steady fast sliding."""
    law: Any = scenario.friction
    law = getattr(law, "steady", law)
    if not isinstance(law, SteadyFriction):
        raise InputError(f"friction: {type(law).__name__} has no coefficient in steady sliding")
    return law


def friction_alone(scenario: Scenario, *, times: float = 1.0) -> float:
    """Compute the friction force [N] of steady sliding under a multiple of the load, without attraction."""
    load = np.asarray(times * scenario.load.normal_force)
    law = steady(scenario)
    real = scenario.contact.real_area(load) if law.needs_real_area else np.asarray(0.0)
    return float(law.lateral_force(load, np.asarray(0.0), real))


def coefficient(scenario: Scenario) -> float:
    """Compute the coefficient of friction of steady sliding, without attraction."""
    return friction_alone(scenario) / scenario.load.normal_force


def load_exponent(scenario: Scenario) -> float:
    """Compute the exponent n with which the friction force grows with the load."""
    step = 1.01
    return math.log(friction_alone(scenario, times=step) / friction_alone(scenario)) / math.log(step)


def vibration_threshold(scenario: Scenario) -> float:
    """Compute the vibration that is just felt at the frequency of a sine [m], zero to peak; infinite where none is."""
    person = scenario.perception
    if person is None or person.threshold is None:
        raise InputError(
            "perception.threshold is not given: the threshold at any other frequency follows from it"
        )
    frequency = scenario.drive.frequency  # type: ignore[attr-defined]
    sensitivity = max(float(each.weight(frequency)) for each in person.channels)
    return person.threshold / sensitivity if sensitivity else math.inf


QUANTITIES: Final = {
    "impedance magnitude": ComputedQuantity(
        title="magnitude of the impedance", unit="ohm", compute=magnitude
    ),
    "impedance lag": ComputedQuantity(title="lag of the voltage behind the current", unit="rad", compute=lag),
    "friction coefficient": ComputedQuantity(
        title="coefficient of friction without attraction", unit="1", compute=coefficient
    ),
    "friction load_exponent": ComputedQuantity(
        title="power of the load in the friction", unit="1", compute=load_exponent
    ),
    "vibration threshold": ComputedQuantity(
        title="vibration that is just felt", unit="m", compute=vibration_threshold
    ),
}
"""Quantities that a measurement may name beside those of a run."""
