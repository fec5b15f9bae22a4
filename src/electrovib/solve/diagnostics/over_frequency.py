"""Diagnostics of what gains, impedance and mean force over frequency leave out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.solve.stack.expand import behind_amplifier, per_volt_of

if TYPE_CHECKING:
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.conduction import Conduction
    from electrovib.scenario import Scenario

_VANISHING = 1e-12
"""Field at which the two slopes of a leak are compared [V/m]."""


def over_frequency_diagnostics(scenario: Scenario) -> list[Diagnostic]:
    """Return warnings where the values over frequency are not those of a sine in time."""
    leaks = {name: layer.leak for name, layer in scenario.stack.layers.items() if layer.leak is not None}
    amplifier = scenario.circuit.amplifier
    return [
        *(_rectifies(name) for name, leak in leaks.items() if _is_rectifying(leak)),
        *([] if amplifier is None or not amplifier.is_limited else _not_supplied(scenario, amplifier)),
    ]


def _is_rectifying(leak: Conduction) -> bool:
    backward, forward = leak.slope(np.array([-_VANISHING, _VANISHING])).tolist()
    return bool(backward != forward)


def _rectifies(name: str) -> Diagnostic:
    text = (
        f"values over frequency: '{name}' counts with the mean of its two conductivities. A rectifying layer that no direct"
        " current passes charges until its mean current is 0, and the constant field of that charge is missing from the mean"
        " force and the gains, at any amplitude; use the response in time"
    )
    return Diagnostic(f"over frequency, {name}", "warning", text)


def _not_supplied(scenario: Scenario, amplifier: Amplifier) -> list[Diagnostic]:
    """Return a warning if a sine of the drive's peak voltage exceeds a limit of the amplifier at some frequency."""
    frequency, peak = scenario.frequency.frequencies(), scenario.drive.largest()
    section = behind_amplifier(scenario, per_volt_of(scenario, frequency))
    pole = 1.0 if amplifier.bandwidth is None else 1 + 1j * frequency / amplifier.bandwidth
    stray = 2j * np.pi * frequency * amplifier.stray_capacitance * amplifier.gain / pole
    current = peak * np.abs(section.current_density * scenario.contact_area + stray)
    found = []
    voltage = abs(amplifier.gain) * peak
    if amplifier.saturation is not None and voltage > amplifier.saturation:
        reached, limit = format_quantity(voltage, "V", digits=3), format_quantity(amplifier.saturation, "V")
        found.append(f"the drive times the gain reaches {reached}, above the saturation of {limit}")
    largest = min(-amplifier.current_limits[0], amplifier.current_limits[1])
    if np.any(current > largest):
        first = format_quantity(float(frequency[current > largest][0]), "Hz", digits=3)
        reached, limit = format_quantity(float(np.max(current)), "A", digits=3), format_quantity(largest, "A")
        found.append(f"the current reaches {reached}, above {limit}, from {first} on")
    if not found:
        return []
    text = (
        f"values over frequency: the mean force is that of a sine which the amplifier does not supply: {' and '.join(found)};"
        " its limits are not part of these values. Reduce the drive, or use the response in time"
    )
    return [Diagnostic("over frequency, amplifier", "warning", text)]
