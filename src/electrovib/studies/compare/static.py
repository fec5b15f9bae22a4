"""Steady attraction at a constant voltage without conduction, and breakdown of the air at it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.diagnostics import diagnostics_of
from electrovib.physics.material import Material
from electrovib.physics.safety import AIR
from electrovib.scenario import Scenario
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    import xarray


def insulating(scenario: Scenario) -> Scenario:
    """Return the same stack without conduction, with its dispersion."""
    changes: dict[str, Any] = {}
    for name, layer in scenario.stack.layers.items():
        changes |= _without_conduction(layer.material, f"stack.{name}.material")
        if layer.leak is not None:
            changes[f"stack.{name}.leak"] = None
    return scenario.replace(changes) if changes else scenario


def _without_conduction(material: Material, path: str) -> dict[str, Any]:
    return {f"{path}.conductivity": 0.0} if material.conductivity else {}


def static_force(scenario: Scenario, *, voltage: float) -> float:
    """Compute the steady attraction at a constant voltage without conduction.

    Of a law without a response in time it is twice its mean under a sine of 1 Hz.
    """
    held = insulating(scenario)
    changes = {
        "drive": {"model": "Step", "level": voltage},
        "time.initial_state": {"model": "PeriodicState"},
    }
    if not scenario.force.causal:
        slow = phasors(held, np.array([1.0]))
        return 2 * float(mean_force(held, slow, amplitude=voltage)[0])
    return float(simulate(held.replace(changes), time=np.array([0.0, 1.0])).electrostatic_force[-1])


def air_breaks_down(scenario: Scenario, *, voltage: float) -> str:
    """Return the warnings about the air of the gap at a constant voltage without conduction; empty without one."""
    changes = {
        "force": {"model": "MaxwellStressInGap"},
        "drive": {"model": "Step", "level": voltage},
        "time.initial_state": {"model": "PeriodicState"},
    }
    trace = simulate(insulating(scenario).replace(changes), time=np.array([0.0, 1.0]))
    return "; ".join(air_warnings(trace))


def air_warnings(trace: xarray.Dataset) -> tuple[str, ...]:
    """Return what a Trace states about breakdown of the air of its gap."""
    return tuple(each.text for each in diagnostics_of(trace) if each.name in AIR and each.state == "warning")
