"""The attraction at a voltage held for ever when nothing conducts, and whether air bears it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.physics.material import Material
from electrovib.physics.safety import air_diagnostics, peak
from electrovib.scenario import Scenario
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    import xarray


def insulating(scenario: Scenario) -> Scenario:
    """Give the same stack with nothing that conducts, and dispersion kept."""
    changes: dict[str, Any] = {}
    for name, layer in scenario.stack.layers.items():
        changes |= _without_conduction(layer.material, f"stack.{name}.material")
        if layer.leak is not None:
            changes[f"stack.{name}.leak"] = None
    return scenario.replace(changes) if changes else scenario


def _without_conduction(material: Material, path: str) -> dict[str, Any]:
    return {f"{path}.conductivity": 0.0} if material.conductivity else {}


def static_force(scenario: Scenario, *, voltage: float) -> float:
    """Attraction at a voltage held for ever when nothing conducts [N].

    Parameters
    ----------
    scenario : Scenario
        Stack, contact and law.
    voltage : float
        V.

    Returns
    -------
    float
        N. For a law of magnitudes, twice its mean under a slow sine.
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
    """Tell how the air of the gap breaks down at a voltage held for ever when nothing conducts.

    Parameters
    ----------
    scenario : Scenario
        Stack; its law does not count.
    voltage : float
        V.

    Returns
    -------
    str
        The texts of the diagnostics beyond their limits; empty if there are none.
    """
    changes = {
        "force": {"model": "MaxwellStressInGap"},
        "drive": {"model": "Step", "level": voltage},
        "time.initial_state": {"model": "PeriodicState"},
    }
    trace = simulate(insulating(scenario).replace(changes), time=np.array([0.0, 1.0]))
    return "; ".join(air_warnings(scenario, trace))


def air_warnings(scenario: Scenario, trace: xarray.Dataset) -> tuple[str, ...]:
    """Judge the air of the gap by the largest field of a Trace.

    Parameters
    ----------
    scenario : Scenario
        Stack; without a gap, a vanishing one.
    trace : xarray.Dataset
        Of that stack.

    Returns
    -------
    tuple of str
        The texts of the diagnostics beyond their limits.
    """
    gap = scenario.stack.gap_name
    field, thickness = (
        peak(trace.interface_field.values),
        scenario.stack.layers[gap].thickness if gap else 0.0,
    )
    return tuple(
        diagnostic.text
        for diagnostic in air_diagnostics(field=field, gap=thickness)
        if diagnostic.state == "warning"
    )
