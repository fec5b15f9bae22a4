"""Quantities of a set-up that are measured without solving it over time: impedance, friction alone, vibration threshold."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.friction.base import SteadyFriction
from electrovib.scenario import Scenario

F = TypeVar("F", bound=Callable[[Scenario], Any])


@dataclass(frozen=True, kw_only=True)
class ComputedQuantity:
    """A quantity that a function computes of a scenario, as a measurement names it; papers offer theirs in `quantities`."""

    title: str
    unit: str
    compute: Callable[[Scenario], float]


def takes_columns(function: F) -> F:
    """Declare that a function of a scenario takes numbers in it as columns, (cases, 1), and returns one for each case."""
    function.takes_columns = True  # type: ignore[attr-defined]
    return function


def impedance(scenario: Scenario) -> Any:
    """Compute the impedance [ohm] of stack and return path at the frequency of a sine, (cases,) where numbers are columns."""
    from electrovib.solve.stack.expand import phasors

    section = phasors(scenario, np.atleast_1d(scenario.drive.frequency))  # type: ignore[attr-defined]
    return (1 / (section.current_density * scenario.contact_area))[..., 0]


@takes_columns
def magnitude(scenario: Scenario) -> Any:
    """Compute the magnitude of the impedance [ohm], (cases,) where numbers are columns."""
    return np.abs(impedance(scenario))


@takes_columns
def lag(scenario: Scenario) -> Any:
    """Compute the angle [rad] by which the voltage lags behind the current, positive for a capacitor; (cases,) of columns."""
    return -np.angle(impedance(scenario))


def steady(scenario: Scenario) -> SteadyFriction:
    """Return the friction of steady fast sliding."""
    law: Any = scenario.friction
    law = getattr(law, "steady", law)
    if not isinstance(law, SteadyFriction):
        raise InputError(f"friction: {type(law).__name__} has no coefficient in steady sliding")
    return law


def friction_alone(scenario: Scenario, *, times: float = 1.0) -> float:
    """Compute the friction force [N] of steady sliding under a multiple of the load, without attraction."""
    from electrovib.solve.electrics.attraction import real_area

    load = np.asarray(times * scenario.load.normal_force)
    law = steady(scenario)
    pressed = scenario if times == 1 else scenario.replace({"load.normal_force": float(load)})
    real = real_area(pressed, load, np.asarray(0.0)) if law.needs_real_area else np.asarray(0.0)
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
