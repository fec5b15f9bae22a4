"""Whether the periodic state assumes that a mean voltage has been held for longer than an experiment lasts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.scenario import PeriodicState

if TYPE_CHECKING:
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario

TITLE: Final = "settled charge"
LONGEST: Final = 100.0
"""Charge relaxation time that an experiment with one drive hardly exceeds [s]; a choice."""
SMALLEST_MEAN: Final = 1e-3
"""Mean over largest voltage below which a drive counts as free of an offset; a choice."""
_SAMPLES: Final = 4096


def settled_charge(scenario: Scenario) -> list[Diagnostic]:
    """Warn where a layer of the plate conducts so little that the periodic state is reached long after an experiment.

    Over a gap that does not conduct, the mean of the voltage is across the gap once the charge in a
    conducting layer has relaxed, in a time of the order of the permittivity over the conductivity.
    """
    if not isinstance(scenario.time.initial_state, PeriodicState) or scenario.drive.quantity != "voltage":
        return []
    roles = scenario.stack.roles
    times = {name: _time(layer) for name, layer in scenario.stack.layers.items() if roles[name] == "plate"}
    slow = {name: time for name, time in times.items() if LONGEST < time < np.inf}
    if not slow or not (mean := _mean(scenario.drive)):
        return []
    name = max(slow, key=lambda each: slow[each])
    text = (
        f"the periodic state assumes that the mean of {format_quantity(mean, 'V', digits=3)} has been held for longer than the"
        f" charge relaxation time of '{name}', {format_quantity(slow[name], 's', digits=3)}; for a shorter experiment set"
        f" stack.{name}.material.conductivity = 0, or time.initial_state.model = AtRest"
    )
    return [Diagnostic(TITLE, "warning", text, slow[name], LONGEST, "s")]


def _time(layer: Layer) -> float:
    """Charge relaxation time of a layer [s]; infinite without conduction."""
    sigma = layer.material.conductivity
    return eps0 * float(layer.material.bound_permittivity(np.array(1e3)).real) / sigma if sigma else np.inf


def _mean(drive: Drive) -> float:
    """Mean voltage of a drive over its period, or its voltage if it is held [V]; 0 where it is small."""
    length = drive.period or drive.duration or 1.0
    mean = float(np.mean(drive.voltage((np.arange(_SAMPLES) + 0.5) / _SAMPLES * length)))
    return mean if abs(mean) > SMALLEST_MEAN * drive.largest() else 0.0
